"""What a scene may record, by name."""

OBSERVERS: dict[str, str] = {}
"""Name -> "module:Class" of an observer that is made of the scene and the nodes of pieces (`slipwave.solve.follow`)."""

RECORDED = ("events", "interface", "fields", *OBSERVERS)
"""All that `run.record` may name."""
