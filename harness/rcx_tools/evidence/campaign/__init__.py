"""Random long runs of this library with every kind of fault."""
