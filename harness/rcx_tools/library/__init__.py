"""Generators of files in plc/lib: the command blocks and their types, from the tables in spec/."""

from rcx_tools.library.render import files
from rcx_tools.library.tables import CATEGORIES, Block, Library, library

__all__ = ["CATEGORIES", "Block", "Library", "files", "library"]
