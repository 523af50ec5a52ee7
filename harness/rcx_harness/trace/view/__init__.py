"""Recordings as one page of HTML for a browser; `page.View` makes it."""

__all__ = ["BEGINNING"]

#: How each page begins: what begins so may be written over.
BEGINNING = "<!doctype html>\n<!-- rcx view -->"
