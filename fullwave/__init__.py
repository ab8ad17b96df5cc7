"""The slab with a grid: leapfrog and summation-by-parts differences, finite elements, discontinuous Galerkin.

Imports only `scene`, never `reduced`: it is an independent witness.
"""
