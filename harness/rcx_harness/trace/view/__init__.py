"""Recordings as one page of HTML for a browser; `page.View` makes it."""

__all__ = ["BEGINNING"]

#: First characters of each page. A file that begins with them may be overwritten.
BEGINNING = "<!doctype html>\n<!-- rcx view -->"
