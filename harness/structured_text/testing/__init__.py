"""For users who test programs with pytest: the plugin, coverage, runs with mutants.

What a project can set stands here, since pytest loads the plugin in every run: nothing else of
the toolkit may come with it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["COVERAGE", "LIBRARIES"]

#: Options of the command line, by the name of the ini key: default is None for each.
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
        "help": "fail where less of statements and branches is covered",
    },
}

#: What finds the folders of libraries, which are not the user's own sources: asked where sources
#: are counted. Whoever has a library adds to it.
LIBRARIES: set[Callable[[], Path]] = set()
