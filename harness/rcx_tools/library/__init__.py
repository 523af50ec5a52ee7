"""Generators of the generated part of plc/lib: command blocks and their types, from spec/."""

from rcx_tools.library.render import files
from rcx_tools.library.tables import CATEGORIES, Block, Library, library

__all__ = ["CATEGORIES", "Block", "Library", "files", "library"]
