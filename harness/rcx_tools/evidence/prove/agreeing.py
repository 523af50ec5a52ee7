"""The comparison of translation and engine as jobs: one block or function each, kept while good."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rcx_harness.verify.prove.logic import UnsupportedError
from rcx_tools.evidence.prove import agreement
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.running import DIED
from rcx_tools.evidence.prove.sources import prover_state

__all__ = ["Comparison", "compare", "comparisons", "died", "summary"]


@dataclass(frozen=True)
class Comparison:
    """A block or function of a copy of plc/lib."""

    folder: str
    pou: str
    block: bool
    key: str


def comparisons(library: Library) -> Iterator[Comparison]:
    """One of each POU."""
    state = prover_state(agreement.__name__)
    for name in library.pous:
        rests = f"{state} {library.state([name])} {agreement.SCANS}"
        key = f"agreement {name}:{hashlib.sha256(rests.encode()).hexdigest()[:16]}"
        block = library.pou(name).kind == "FUNCTION_BLOCK"
        yield Comparison(str(library.folder), name, block, key)


def compare(job: Comparison) -> dict[str, Any]:
    """Run the random scans of a POU."""
    try:
        found = asdict(agreement.compare((job.folder, job.pou, agreement.SCANS, 1)))
    except UnsupportedError as error:
        return _failed(job, str(error))
    return {"key": job.key, "good": not found["disagreement"], "block": job.block, **found}


def died(job: Comparison) -> dict[str, Any]:
    """The outcome of a POU whose process has ended by itself."""
    return _failed(job, DIED)


def _failed(job: Comparison, why: str) -> dict[str, Any]:
    outcome = {"key": job.key, "good": False, "block": job.block, "pou": job.pou, "scans": 0}
    return {**outcome, "disagreement": f"{job.pou}: {why}"}


def summary(found: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """The figures."""
    rows = sorted(found, key=lambda row: str(row["pou"]))
    blocks = [row["scans"] for row in rows if row["block"]]
    return {
        "scans": sum(row["scans"] for row in rows),
        "blocks": len(blocks),
        "functions": len(rows) - len(blocks),
        "least_of_a_block": min(blocks, default=0),
        "disagreements": [row["disagreement"] for row in rows if row["disagreement"]],
    }
