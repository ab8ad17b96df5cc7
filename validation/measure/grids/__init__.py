"""Attributes of a full wave that are measured on its runs: orders in space, step limits, noise at the scale of the grid."""
