"""A package, so that pytest puts the repository and not this folder on the path, where `tests/scene` would hide `scene`."""
