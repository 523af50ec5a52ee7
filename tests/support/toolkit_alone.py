"""Make a process that can import structured_text, but not the packages that are built on it."""

from __future__ import annotations

import sys
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from typing import Any

_PROJECT_PACKAGES = ("rcx_harness", "rcx_tools")


class _Nothing(MetaPathFinder):
    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if fullname.partition(".")[0] in _PROJECT_PACKAGES:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return None


def toolkit_alone() -> None:
    """Make all later imports of rcx_harness and rcx_tools in this process fail."""
    sys.meta_path.insert(0, _Nothing())
