"""The two ways a run can end badly; the command line turns them into exit status 2 and 3."""


class SceneError(ValueError):
    """The user's input is wrong: one line naming the key, the value and the allowed range (exit 2)."""


class NumericsError(ArithmeticError):
    """The numerics failed: one line saying what, where and when (exit 3)."""
