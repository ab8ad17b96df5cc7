"""A run from its start to its result: the march with its observers, what is kept of it, and how it is resumed."""
