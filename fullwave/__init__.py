"""The slab with a grid: finite differences, finite elements, discontinuous Galerkin.

Imports only `scene`, never `reduced`: it is an independent witness.
"""
