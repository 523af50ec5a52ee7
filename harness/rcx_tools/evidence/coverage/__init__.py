"""Coverage of this library by its tests."""
