"""Comparison of the translation for the solver with the engines, on random scans."""
