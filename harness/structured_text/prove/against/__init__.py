"""Comparison of two versions of a program: the same outputs in every run, or a run that differs."""
