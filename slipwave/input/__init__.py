"""Reads a scene file into a frozen `Scene`: finds the text, applies overrides, validates every key, converts SI, assembles."""
