"""Run times, measured by `make bench`; nothing is judged."""
