"""Generators of the project's own pages, library and evidence; not in the wheel."""
