"""A recording as one page of HTML that is looked at in a browser; `page.View` makes it."""

__all__ = ["BEGINNING"]

#: How each page begins: what begins so may be written over.
BEGINNING = "<!doctype html>\n<!-- rcx view -->"
