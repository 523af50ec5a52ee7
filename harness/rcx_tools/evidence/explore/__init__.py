"""The exploration of this library: its models and its seeded bugs."""
