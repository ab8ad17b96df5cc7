"""Models with a grid: leapfrog and summation-by-parts differences, finite elements, discontinuous Galerkin.

Imports only `slipwave`, never `reduced`, which it checks independently.
"""
