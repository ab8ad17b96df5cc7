"""What commands compute: a model by its name, the run of a scene, its periodic orbit, and branches of orbits."""
