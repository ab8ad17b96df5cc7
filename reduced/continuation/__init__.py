"""Continuation of periodic orbits through folds in any parameter of a scene, with their special points."""
