"""References for models: published numbers, LSODA, closed forms of the onset."""
