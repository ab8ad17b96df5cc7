"""A file for each command: its options as fields, its result with columns, files and figures; and the command line."""
