"""Families of periodic orbits: followed through folds in any parameter of a scene, with their special points."""
