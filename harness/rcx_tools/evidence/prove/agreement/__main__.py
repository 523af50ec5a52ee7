"""Command `python -m rcx_tools.evidence.prove.agreement`: compare without `make prove`."""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from pathlib import Path as File

from rich.console import Console

from rcx_tools.evidence.prove.agreement.bench import missing
from rcx_tools.evidence.prove.agreement.comparing import ENGINES, MATIEC_SCANS, SCANS
from rcx_tools.evidence.prove.agreement.jobs import compared, prepare
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.results import ROOT
from structured_text.farm import Farm
from structured_text.output.system import processors

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run the comparison; return 0 if all agree, 1 if a POU disagrees, 2 on bad input."""
    parser = ArgumentParser(
        prog="python -m rcx_tools.evidence.prove.agreement", description=__doc__
    )
    parser.add_argument("pous", nargs="*", help="blocks and functions (default: all)")
    parser.add_argument("--lib", default=str(ROOT / "plc/lib"), help="another copy of plc/lib")
    parser.add_argument("--scans", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="builtin")
    parser.add_argument("--jobs", type=int, default=processors())
    options = parser.parse_args(arguments)
    console = Console(highlight=False)
    if not File(options.lib).is_dir():
        console.print(f"there is no folder {options.lib}: name a copy of plc/lib", markup=False)
        return 2
    known = Library(File(options.lib)).pous
    wanted = [name.upper() for name in options.pous] or known
    unknown = [name for name in wanted if name not in known]
    if unknown:
        console.print(f"there is no block or function {', '.join(unknown)} in {options.lib}")
        return 2
    matiec = options.engine == "matiec"
    if matiec and (reason := missing()):
        console.print(f"skipped: {reason}", markup=False)
        return 0
    if matiec:
        prepare(options.lib)
    scans = options.scans or (MATIEC_SCANS if matiec else SCANS)
    work = [(options.lib, name, {options.engine: scans}, options.seed) for name in wanted]
    parts = Farm(options.jobs, console=console).run(compared, work, title="POUs")
    found = [one for _, part in parts for one in part.values()]
    for one in found:
        if one.disagreement:
            console.print(one.disagreement, markup=False)
    scans = sum(one.scans for one in found)
    bad = sum(bool(one.disagreement) for one in found)
    seconds = sum(one.seconds for one in found)
    stopped = sum(one.faults for one in found)
    console.print(
        f"{len(found)} POUs, {scans:,} scans ({stopped:,} stopped by a fault on both sides), "
        f"{seconds:.0f} s, {bad} disagree"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
