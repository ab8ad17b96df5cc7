"""A scene as data: friction, slabs, drive, start and units. Imports no solver."""

from slipwave.scene.scene import Scene

__all__ = ["Scene"]
