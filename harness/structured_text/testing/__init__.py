"""The pytest plugin for users who test programs: coverage, and runs with mutants.

This module lists the settings. pytest loads the plugin in every run, so the module must not import
anything else of the toolkit.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["COVERAGE", "LIBRARIES"]

#: Options of the command line, by the name of the ini key. The default of each is None.
COVERAGE: dict[str, dict[str, Any]] = {
    "coverage": {
        "action": "store_const",
        "const": "true",
        "help": "coverage of the sources: statements, branches, MC/DC",
    },
    "coverage_out": {"metavar": "DIR", "help": "folder of its report; default: out/coverage"},
    "coverage_library": {
        "action": "store_const",
        "const": "true",
        "help": "coverage of the library's blocks, too",
    },
    "cover_fail_under": {
        "metavar": "PERCENT",
        "help": "fail if fewer statements and branches are covered",
    },
}

#: Functions that return the folders of libraries, which are not the user's own sources. They are
#: called when coverage starts. A package with a library adds its function.
LIBRARIES: set[Callable[[], Path]] = set()
