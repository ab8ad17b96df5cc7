"""A run as a netCDF file: events always, the interface's history if the scene records it, and where it all came from."""

from importlib.metadata import version
from pathlib import Path

from scene.observe import HistoryObserver, Solver
from validation.output import whole_file
from validation.simulate import Run

_EVENT_NOTES = {
    "time": ("start of the slip event", "transit"),
    "period": ("time to the next event", "transit"),
    "stress_drop": ("max - min of the friction stress over the cycle", "normal stress"),
    "elastic_stress_drop": ("max - min of the elastic stress y over the cycle", "normal stress"),
    "v_max": ("largest slip rate of the cycle", "V*"),
    "v_min": ("smallest slip rate of the cycle", "V*"),
}
_HISTORY_NOTES = {
    "time": ("time", "transit"),
    "slip_rate": ("slip rate v", "V*"),
    "psi": ("state ln phi", "1"),
    "stress": ("friction stress mu", "normal stress"),
    "elastic_stress": ("elastic stress y", "normal stress"),
}


def history_for(solver: Solver) -> HistoryObserver | None:
    """The observer of the interface's history, if the scene's `record` asks for it."""
    if "interface" not in solver.scene.record:
        return None
    return HistoryObserver(solver.scene.law, solver.nodes)


def write_run(path: Path, done: Run, history: HistoryObserver | None) -> None:
    """Write `done` to `path`, which is whole or absent; `complete` is 0 if the numerics failed on the way.

    Raises SceneError if the file cannot be written.
    """
    import xarray

    scene = done.solver.scene
    variables = {
        ("event_time" if name == "time" else name): ("event", values, _notes(_EVENT_NOTES[name]))
        for name, values in done.events._asdict().items()
    }
    if history is not None:
        for name, values in history.columns().items():
            label = "time" if name == "time" else f"interface_{name}"
            variables[label] = ("sample", values, _notes(_HISTORY_NOTES[name]))
    facts = {
        "title": f"slipwave run of scene {scene.name} with model {done.solver.model}",
        "scene": scene.name,
        "scene_digest": scene.digest,
        "model": done.solver.model,
        "slipwave_version": version("slipwave"),
        "until_transits": done.until,
        "transit_in_friction_time": scene.transit,
        "events": done.starts,
        "failures": done.solver.failures,
        "complete": 0 if done.failed else 1,
        "failed": done.failed,
    }
    with whole_file(path) as temporary:
        xarray.Dataset(variables, attrs=facts).to_netcdf(temporary, engine="netcdf4")


def _notes(facts: tuple[str, str]) -> dict[str, str]:
    return {"long_name": facts[0], "units": facts[1]}
