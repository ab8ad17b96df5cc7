"""Models by name: what each honours, what it refuses and which models it names instead, what `auto` takes."""

import pytest

import slipwave
from slipwave.errors import SceneError
from slipwave.family import FEATURES, features_of
from slipwave.solve import follow
from validation.registry.build import build, build_all
from validation.registry.choice import families, honouring, resolve
from validation.registry.families import FAMILIES, GRIDS


@pytest.mark.parametrize(
    ("name", "features"),
    [
        ("paper", set()),
        ("unlike", {"unlike"}),
        ("unlike-irrational", {"unlike"}),
        ("grip", {"grip"}),
        ("machine", {"grip", "mass"}),
        ("reflection", {"reflection"}),
        ("layered", {"layers"}),
        ("viscous", {"kelvin-voigt"}),
        ("ramp", set()),
        ("slip-law", set()),
    ],
)
def test_features(name, features):
    assert features_of(slipwave.read(name)) == features


def test_the_registry_is_consistent():
    names = [family.name for family in FAMILIES]
    assert len(set(names)) == len(names)
    for family in FAMILIES:
        assert family.honours <= set(FEATURES)
        assert (family.default is not None) == bool(family.numbers)
        assert callable(family.maker())


@pytest.mark.parametrize("family", families(), ids=lambda family: family.name)
@pytest.mark.parametrize("name", ["paper", "unlike", "grip", "layered", "viscous", "ramp", "reflection"])
def test_every_family_builds_what_it_honours_and_refuses_the_rest(family, name):
    one = next(found for found in families() if found is family)
    scene = slipwave.read(name)
    if one in honouring(scene):
        solver = build(one.example, scene)
        assert solver.model == one.example
        assert solver.scene is scene
        assert solver.time == 0.0
    else:
        with pytest.raises(SceneError, match=r"models that can: .*fd") as caught:
            build(one.example, scene)
        assert len(str(caught.value).splitlines()) == 1


def test_auto_is_the_exact_one_or_says_why_not():
    assert resolve("auto", slipwave.read("paper")) == ("delay", "exact for this scene")
    chosen, why = resolve("auto", slipwave.read("viscous"))
    assert chosen in [family.example for family in GRIDS]
    assert "Kelvin-Voigt" in why
    assert resolve("block8", slipwave.read("paper")) == ("block8", "")


@pytest.mark.parametrize(
    "model", ["modal:65", "modal:-1", "modal:x", "modal:", "modal", "delay:1", "", ":", "auto:2", "MODAL:2", "modal:٢", "x" * 999]
)
def test_names_that_are_no_model(model):
    with pytest.raises(SceneError) as caught:
        build(model, slipwave.read("paper"))
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("name", "tolerance", "model"),
    [("dg", None, "dg:7"), ("dg", 1e-4, "dg:5"), ("dg", 1e-8, "dg:7"), ("fem", 1e-6, "fem:6"), ("sbp", 1e-3, "sbp:6")],
)
def test_a_degree_left_open_suits_the_tolerance(name, tolerance, model):
    solver = build(name, slipwave.read("paper", ["run.until=20"]), tolerance=tolerance)
    assert solver.model == model


def test_a_tolerance_beside_given_cells_is_for_the_steps_of_the_exact_march():
    scene = slipwave.read("paper", {"slab.log10_r": -2.6})
    plain, coarse, fine = (build("dg:8", scene, cells=4, tolerance=tolerance) for tolerance in (None, 1e-5, 1e-9))
    assert [solver.settings["cells"] for solver in (plain, coarse, fine)] == [[4]] * 3
    assert [solver.settings["resolution"] for solver in (plain, coarse, fine)] == [1e-12, 1e-5, 1e-9]
    exact, far, near = (follow(solver, 60.0).psi for solver in (plain, coarse, fine))
    assert 1e-10 < abs(far / exact - 1.0) < 1e-7  # 1.5e-9 measured
    assert abs(near / exact - 1.0) < 1e-10  # 4e-12 measured


@pytest.mark.parametrize(
    ("model", "options", "changes"),
    [("fd", {}, {}), ("dg:3", {"time": "explicit"}, {}), ("dg:3", {"cfl": 0.5}, {}), ("dg:3", {}, {"start.kind": "jump"})],
)
def test_cells_beside_a_tolerance_are_refused_where_no_step_can_follow_it(model, options, changes):
    with pytest.raises(SceneError, match=r"tolerance = 1e-09: chooses the cells itself; leave out cells = 6"):
        build(model, slipwave.read("paper", changes), cells=6, tolerance=1e-9, **options)


def test_options_go_to_the_models_that_take_them():
    delay, leapfrog = build_all("delay,fd", slipwave.read("paper"), cells=10, tolerance=1e-6)
    assert (delay.model, leapfrog.model) == ("delay", "fd")
    assert getattr(leapfrog, "cells") == 10  # noqa: B009
    for options in ({"cells": 10}, {"cfl": 0.5}):
        with pytest.raises(SceneError, match="none of the models"):
            build_all("delay,block8", slipwave.read("paper"), **options)  # type: ignore[arg-type]
