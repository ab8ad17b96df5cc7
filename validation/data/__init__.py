"""Measured records: their columns by name, and the slip events in them."""
