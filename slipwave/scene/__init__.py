"""A scene as data: friction, slabs, drive, start and units. Knows no solver."""

from slipwave.scene.scene import Scene

__all__ = ["Scene"]
