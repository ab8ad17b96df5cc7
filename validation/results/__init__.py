"""Options and results of commands, each declared once: options as fields, quantities as columns, files by their result."""
