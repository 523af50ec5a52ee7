"""The options of `rcx campaign`, and those that it shares with `rcx sweep`."""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from rcx_harness.cli.cell_options import CellOptions
from rcx_harness.cli.farm import FarmOptions, WorkersOrNone
from rcx_harness.cli.junit_option import Junit
from rcx_harness.verify.fingerprint import fingerprint
from rcx_harness.verify.storm.cells import CellsOf
from rcx_harness.verify.storm.saved_results import saved_results
from rcx_harness.verify.storm.written import forget
from structured_text.errors import InputError
from structured_text.farm import ResultFile

__all__ = ["CampaignOptions", "VerifyOptions"]


@dataclass(frozen=True)
class VerifyOptions(FarmOptions, CellOptions):
    """The options that campaign and sweep have in addition to the options of a cell."""

    properties: Annotated[
        list[Path] | None,
        typer.Option(help="Operator actions and required properties: .toml, .py; repeatable."),
    ] = None
    workers: WorkersOrNone = None

    def cells(self, stimulus: Path | None) -> CellsOf:
        """Return the description of the cell, from which each worker process builds its cells."""
        if self.link != "direct":
            raise InputError(f"--link {self.link} is for rcx run", hint="leave it out")
        return CellsOf.of(self.files, self.of_cell(), self.properties or (), stimulus)

    def results(self, cells: CellsOf, out: Path, further: str = "") -> ResultFile[Any, Any]:
        """Return valid results of earlier calls; print a notice about invalid results."""
        kept, notice = saved_results(out / "results.jsonl", self._about(cells, further))
        if kept.notice:
            print(kept.notice, file=sys.stderr)
        if notice:
            print(notice)
            forget(out)
        return kept

    def _about(self, cells: CellsOf, further: str) -> dict[str, str]:
        """Return the files, options and version that the results depend on."""
        options = " ".join([*self.words()[len(self.files) :], further]).strip()
        ours = hashlib.sha256(repr(fingerprint()).encode()).hexdigest()[:16]
        return {"files": cells.parcel.digest(), "options": options or "none", "rcx": ours}


@dataclass(frozen=True)
class CampaignOptions(VerifyOptions):
    """The options of `rcx campaign`."""

    seeds: Annotated[int, typer.Option(help="Number of random runs (seeds).", min=1, max=10**9)] = (
        100
    )
    seed_from: Annotated[int, typer.Option(help="The first seed.", min=0, max=2**63 - 1)] = 0
    stimulus: Annotated[
        Path | None, typer.Option(help="Stimulus of a good run (TOML), to which faults are added.")
    ] = None
    out: Annotated[Path, typer.Option(help="Folder for results and replays.")] = Path(
        "out/campaign"
    )
    junit: Junit = None
    guided: Annotated[
        bool,
        typer.Option(
            "--guided",
            help="Keep rare states, and branch from them; --seeds is the number of runs.",
        ),
    ] = False
