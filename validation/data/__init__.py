"""Measured records: their columns by name, and the slip events in them; the variables of results."""
