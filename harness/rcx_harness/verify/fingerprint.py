"""The fingerprint that all computers of a cluster must share: package, tables and library."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from pathlib import Path

from rcx_harness.cell.sources import default_lib
from rcx_harness.spec import folder as spec_folder
from structured_text.farm import fingerprint as toolkit

__all__ = ["fingerprint"]

_PACKAGE = Path(__file__).parents[1]


@cache
def fingerprint() -> toolkit.Fingerprint:
    """Return the fingerprint: name and value of each component as text."""
    own = toolkit.fingerprint((_PACKAGE, *toolkit.PACKAGES))
    folders = {"its tables": spec_folder(), "its library": default_lib()}
    tables = [(name, toolkit.digest_of([folder])) for name, folder in folders.items()]
    return (("rcx-harness", version("rcx-harness")), *own, *tables)
