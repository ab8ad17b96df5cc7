"""Fits parameters, with intervals, by least squares of a model's friction against measured records."""
