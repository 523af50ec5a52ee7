"""Generators of the files in plc/lib that are made from the tables in spec/."""

from rcx_tools.library.render import files
from rcx_tools.library.tables import CATEGORIES, Block, Library, library

__all__ = ["CATEGORIES", "Block", "Library", "files", "library"]
