"""Many scenes at once: axes and points, the store of finished parts, the engine, refinement, and maps."""
