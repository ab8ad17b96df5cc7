"""Solvers: their interface, the march of a run with its observers and marks, and checkpoints."""

from slipwave.solve.checkpoint import tables, take_back, whole_numbers
from slipwave.solve.follow import Final, Mark, Observer, follow, has_fields
from slipwave.solve.solver import Energy, FieldSolver, Leaping, Resumable, SlabSnapshot, Snapshot, Solver, State

__all__ = ["Energy", "FieldSolver", "Final", "Leaping", "Mark", "Observer", "Resumable", "SlabSnapshot", "Snapshot", "Solver"]
__all__ += ["State", "follow", "has_fields", "tables", "take_back", "whole_numbers"]
