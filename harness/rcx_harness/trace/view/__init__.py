"""Recordings as one page of HTML for a browser; `page.View` makes it."""

__all__ = ["BEGINNING"]

#: Beginning of each page; a file with this beginning may be overwritten.
BEGINNING = "<!doctype html>\n<!-- rcx view -->"
