"""What models are compared with: published numbers, LSODA, closed forms of the onset."""
