"""What commands take and give back, each declared once: options as fields, quantities as columns, files by their result."""
