"""The generated pages and pictures."""
