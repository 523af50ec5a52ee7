"""The coverage of this library by its tests."""
