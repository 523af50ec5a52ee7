"""Structured Text in the dialect of a tool, in files below a folder."""
