"""`slipwave verify`: judges a scheme, a law or a scene by the report's own rows."""
