"""Models with a grid: leapfrog and summation-by-parts differences, finite elements, discontinuous Galerkin.

Imports only `slipwave`, never `reduced`, so that it is an independent witness.
"""
