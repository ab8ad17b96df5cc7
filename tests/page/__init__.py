"""The page of the report in a real browser: `make page`."""
