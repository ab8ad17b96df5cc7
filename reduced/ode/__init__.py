"""Reductions of the slabs to ordinary differential equations, and the march that integrates them."""
