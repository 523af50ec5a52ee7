"""The share of files of public libraries of Structured Text that the front end accepts.

The libraries are folders that whoever measures has fetched: `RCX_LIBRARIES` names them, separated
as in PATH. Nothing of them is kept here. Each folder is one library: its files are checked
together, since they use each other.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from rcx_harness.cell.build import st_files
from rcx_harness.engine.frontend import check
from rcx_harness.errors import InputError
from rcx_tools.bench.figure import Figure, Options, at_least

__all__ = ["LEAST", "Share", "accepted", "measure"]

#: Share of the files of each library that is to be accepted [%].
LEAST = 95.0
_VARIABLE = "RCX_LIBRARIES"
#: Names and numbers of a message, which its reason does not depend on.
_NAMES = re.compile(r"'[^']*'|\b\w*\d\w*\b|\b[A-Z_]\w*\b")
_SHOWN = 10


@dataclass(frozen=True)
class Share:
    """What became of a library: its files, those refused, and reasons with how often."""

    files: int
    refused: int
    reasons: tuple[tuple[str, int], ...]

    @property
    def percent(self) -> float:
        """The share of files without an error."""
        return 100.0 * (self.files - self.refused) / self.files


def accepted(files: Sequence[Path]) -> Share:
    """Check the files of a library together.

    Raises:
        InputError: there are none.
    """
    if not files:
        raise InputError("no .st files to measure", hint=f"look at {_VARIABLE}")
    errors = check(files)
    refused = {error.file for error in errors if error.file}
    reasons = Counter(_NAMES.sub("…", error.message) for error in errors)
    return Share(len(files), len(refused), tuple(reasons.most_common()))


def measure(options: Options) -> dict[str, Figure]:
    """Measure each folder of `RCX_LIBRARIES`, and print why files are refused.

    Raises:
        InputError: the variable is not set, or a folder has no ST files.
    """
    del options
    folders = [Path(part) for part in os.environ.get(_VARIABLE, "").split(os.pathsep) if part]
    if not folders:
        hint = f"set {_VARIABLE} to folders of Structured Text, separated by {os.pathsep!r}"
        raise InputError("no libraries to measure", hint=hint)
    console = Console(highlight=False, markup=False)
    figures = {}
    for folder in folders:
        share = accepted(st_files(folder))
        console.print(f"{folder.name}: {share.files - share.refused} of {share.files} files")
        for reason, times in share.reasons[:_SHOWN]:
            console.print(f"  {times} x {reason}")
        figures[f"language {folder.name}"] = at_least(share.percent, "% of files", LEAST)
    return figures
