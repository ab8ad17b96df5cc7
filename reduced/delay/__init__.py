"""The exact delay systems: alike slabs, and networks of transmission lines for all others."""
