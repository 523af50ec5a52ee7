"""Inference of interfaces for missing names.

The interface is derived from the uses of a name, so that the rest of the program can be checked.
"""
