"""Rockwell's L5X: Add-On Instructions and a routine."""
