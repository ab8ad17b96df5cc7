"""Branches of periodic orbits of a scene: where one begins, the record of its points, and its file."""

SPECIAL_KINDS = {"HB": "Hopf", "LP": "fold", "PD": "period doubling", "NS": "torus"}
"""Kinds of special points, and their names."""
