"""A scene: everything about a run except how it is computed. Frozen, dimensionless; `slipwave.read` reads one from TOML."""

import hashlib
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import Any

from slipwave.friction import Law, respond, steady_state, unknown_of
from slipwave.scene.drive import Drive, Forcing, Start
from slipwave.scene.slab import Slab
from slipwave.scene.units import Units


@dataclass(frozen=True)
class Scene:
    """Two slabs, the interface's law, the drive, the start, the length of the run and what to record.

    Units: length L, velocity V*, stress sigma, friction clock L/V*. "transit" is the round trip of the upper slab; `until` is in
    transits; None: the length of a run follows from its motion. `units` holds L, V* and sigma when the scene was given in SI.
    `tables`: those of the file that it was read from, passed as `written`; None for a scene made in any other way, also by
    `dataclasses.replace`.
    """

    name: str
    law: Law
    upper: Slab
    lower: Slab
    drive: Drive
    start: Start = field(default_factory=Start)
    until: float | None = None
    record: frozenset[str] = frozenset({"events"})
    units: Units | None = None
    written: InitVar[Mapping[str, Any] | None] = None
    tables: Mapping[str, Any] | None = field(init=False, repr=False, compare=False)

    def __post_init__(self, written: Mapping[str, Any] | None) -> None:
        # not by a field with a default: `replace` would hand the tables on to a scene that they do not describe
        object.__setattr__(self, "tables", written)

    @property
    def alike(self) -> bool:
        """True if both slabs are the same, so that one of them is sufficient (the motion is antisymmetric)."""
        return self.upper == self.lower

    @cached_property
    def equivalent(self) -> Slab | None:
        """One of two alike slabs that answer the interface as both of the scene's; None if there are no such slabs.

        Z_1(s) and Z_2(s) of slabs that differ in epsilon alone (layers and face are relative to it) have a constant ratio, and
        1/Z = 1/Z_1 + 1/Z_2 is that of alike slabs of epsilon = 2/(1/eps_1 + 1/eps_2). That holds for any drive: how a slab that
        carries no stress at the interface follows it does not depend on epsilon."""
        upper, lower = self.upper, self.lower
        if upper == lower:
            return upper
        if replace(lower, epsilon=upper.epsilon) != upper:
            return None
        return replace(upper, epsilon=2.0 / (1.0 / upper.epsilon + 1.0 / lower.epsilon), material=None)

    @property
    def slabs(self) -> tuple[Slab, ...]:
        """The slabs that the interface's motion needs: the `equivalent` one, else the upper and the lower one."""
        return (self.upper, self.lower) if self.equivalent is None else (self.equivalent,)

    @property
    def named_slabs(self) -> list[tuple[str, Slab]]:
        """The slabs under the names of their tables in scene files: one if they are alike."""
        return [("slab", self.upper)] if self.alike else [("upper", self.upper), ("lower", self.lower)]

    @property
    def is_held_rigidly(self) -> bool:
        """Whether both outer faces move with the drive."""
        return self.upper.termination.is_rigid and self.lower.termination.is_rigid

    @property
    def is_plain(self) -> bool:
        """Whether the slabs have an `equivalent` that is plain: one wave and one delay are then sufficient."""
        return self.equivalent is not None and self.equivalent.is_plain

    @property
    def velocity(self) -> float:
        """V at t = 0, in V*: the rate of the steady sliding from which every start departs."""
        return self.drive.initial

    @property
    def transit(self) -> float:
        """One transit of the upper slab on the friction clock L/V*."""
        return self.upper.round_trip

    @property
    def impedance(self) -> float:
        """Z of the interface condition: 1/Z = 1/eps_1 + 1/eps_2 (layers next to the interface)."""
        return 1.0 / (1.0 / self.upper.interface_impedance + 1.0 / self.lower.interface_impedance)

    @property
    def stiffness(self) -> float:
        """Quasi-static stiffness of both slabs in series, per transit: elastic stress y' = stiffness (V - v), t~ clock; equal to
        epsilon for alike plain slabs (41). It includes the spring of a grip; a bare reflection coefficient has no spring."""
        return self.transit / (self.upper.compliance + self.lower.compliance)

    @cached_property
    def steady_psi(self) -> float:
        """psi_ss(V)."""
        return steady_state(self.law, self.velocity)

    @cached_property
    def steady_stress(self) -> float:
        """mu_ss(V)."""
        return float(respond(self.law, unknown_of(self.law, self.velocity), self.steady_psi)[2])

    @cached_property
    def forcing(self) -> Forcing:
        """Numbers of the scene for compiled marches."""
        return Forcing(self.transit, self.stiffness, self.steady_stress, self.velocity, self.start.nudge_size)

    @cached_property
    def digest(self) -> str:
        """Twelve hex digits that name this scene's physics (not its name) in logs and stored results."""
        facts = (type(self.law).__qualname__, tuple(self.law), self.upper, self.lower, self.drive, self.start, self.until)
        return hashlib.sha256(repr(facts).encode()).hexdigest()[:12]
