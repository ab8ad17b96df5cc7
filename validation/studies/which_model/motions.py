"""The motion of a model in the paper's scene and in others: its regime, orbits by Newton's method where they are stable."""

from validation.measure.in_words import able, scene_of
from validation.measure.over_r import scene_at
from validation.measure.regimes import UNTRIED, Regime, regime_of

WAVE = "dg:7"
CELLS = 3
"""Cells per slab of the full wave, propagated exactly in time: its orbit is accurate to ten digits."""
TOLERANCE = 1e-9
_IN_PLACE_OF = {"fitted:4": "modal:4"}
"""A rational fit -> the model whose modes it would find, where that can compute the scene."""
_SETTLED, _IN_SCENES = 4000.0, 7000.0  # transits of a run to a stable orbit


def paper_at(log10_r: float) -> str:
    """The words that give the paper's scene at an r in a command."""
    return f"paper --set slab.log10_r={log10_r:g}"


def regime_at(model: str, log10_r: float, until: float = _SETTLED, cells: int = CELLS) -> Regime:
    """The regime of a run of the model to `until` (transits); stable orbits by Newton's method."""
    return regime_of(model, scene_at(log10_r), until, cells if model == WAVE else None, TOLERANCE)


def regime_in(model: str, words: str, until: float = _IN_SCENES, cells: int = CELLS) -> Regime:
    """As `regime_at`, in the scene that the words of a command give; UNTRIED where the model cannot compute it, or another one
    can whose place it takes."""
    scene = scene_of(words)
    if not able(model, scene) or able(_IN_PLACE_OF.get(model, ""), scene):
        return Regime(UNTRIED)
    return regime_of(model, scene, until, cells if model == WAVE else None, TOLERANCE)
