"""Fields of a full wave over depth and time: recorded, written, drawn."""
