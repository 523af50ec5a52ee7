"""Generators of the project's own pages, library and evidence. The wheel does not contain them."""
