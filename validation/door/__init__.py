"""The door of the house: what `slipwave` offers, one function per file. The command line and Python programs use the same."""
