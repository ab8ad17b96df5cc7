"""The errors that end a run early; the command line turns them into exit status 2, 3 and 130."""

from typing import Any


class SceneError(ValueError):
    """The user's input is wrong: one line naming the key, the value and the allowed range (exit 2)."""


class Interrupted(Exception):
    """The user stopped the run: one line says when, and how to continue (exit 130)."""


class NumericsError(ArithmeticError):
    """The numerics failed: one line saying what, where and when (exit 3). `result`: what was computed before it, or None."""

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result
