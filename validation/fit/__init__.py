"""Data in, parameters with intervals out: least squares of a model's friction against measured records."""
