"""The questions of the probe, grouped by subject."""
