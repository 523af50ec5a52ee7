"""Inference of interfaces for missing names from their use, so that the rest can be checked."""
