"""The mutants of this library and of what judges it."""
