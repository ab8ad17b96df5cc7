"""Nodes, elements and closures from which the families build their operators."""
