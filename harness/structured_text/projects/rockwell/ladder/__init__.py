"""Ladder routines of an L5X: the rungs in neutral text, and their translation to Structured Text."""
