"""Fields of a full wave over depth and time: how they are recorded, written and drawn."""
