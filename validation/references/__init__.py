"""References for models: published numbers, results of another program, closed forms of the onset."""
