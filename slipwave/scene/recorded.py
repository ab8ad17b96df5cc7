"""Names of what a scene may record."""

OBSERVERS: dict[str, str] = {}
"""Name -> "module:Class" of an observer that is made of the scene and the nodes of pieces (`slipwave.solve.follow`)."""

RECORDED = ("events", "interface", "fields", *OBSERVERS)
"""The names allowed in `run.record`."""
