"""What commands compute: a model by its name, the run of a scene, its orbit, branches and curves of orbits; the timer."""
