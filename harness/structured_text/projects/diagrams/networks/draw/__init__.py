"""Drawings of the networks of a diagram: as text and as SVG."""
