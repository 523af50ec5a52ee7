"""Jobs that each compare one block or function with the engines. Good outcomes are saved."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_tools.evidence.prove.agreement import comparing
from rcx_tools.evidence.prove.agreement.bench import Subject, missing
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.running import DIED
from rcx_tools.evidence.prove.sources import prover_state
from rcx_tools.evidence.prove.summaries import WAVES
from structured_text.engines.matiec.build import find_matiec, fingerprint_of
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.prove.logic import UnsupportedError

__all__ = [
    "Comparison",
    "compare",
    "compared",
    "comparisons",
    "compiler_state",
    "died",
    "prepare",
    "summary",
]


@dataclass(frozen=True)
class Comparison:
    """A job that compares a block or function of a copy of plc/lib with the engines."""

    folder: str
    pou: str
    block: bool
    matiec: bool
    key: str


def comparisons(library: Library) -> Iterator[Comparison]:
    """Yield a job for each POU, except POUs that use a sine or a similar function.

    The terms cannot express such functions. The proofs hold for any result of these functions.

    Raises:
        InputError: `RCX_MATIEC` or an `iec2c` on `PATH` does not lead to a complete matiec.
    """
    state = prover_state(comparing.__name__)
    matiec = not missing()
    for name in library.pous:
        rests = f"{state} {library.state([name])} {comparing.SCANS} {compiler_state()}"
        key = f"agreement {name}:{hashlib.sha256(rests.encode()).hexdigest()[:16]}"
        if _waves(library, name):
            continue
        block = library.pou(name).kind == "FUNCTION_BLOCK"
        yield Comparison(str(library.folder), name, block, matiec, key)


def _waves(library: Library, name: str) -> bool:
    """Return whether the POU calls, even indirectly, a function that no term can express."""
    called = re.compile(rf"\b({'|'.join(WAVES)})\s*\(", re.IGNORECASE)
    files = {library.pou(one).file for one in library.used([name])}
    return any(called.search(Path(file).read_text(encoding="utf-8")) for file in files)


def compiler_state() -> str:
    """Return the state of matiec and the name of the C compiler.

    Empty if one of them is missing.
    """
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        return ""
    return f"{fingerprint_of(matiec)} {compiler} {comparing.MATIEC_SCANS}"


@lru_cache(maxsize=2)
def _subject(folder: str, *, matiec: bool) -> Subject:
    return Subject.of(sorted(Path(folder).rglob("*.st")), matiec=matiec)


def prepare(folder: str) -> None:
    """Compile all sources for matiec if it is available, before several processes need them."""
    if not missing():
        _subject(folder, matiec=True)


def compared(job: tuple[str, str, dict[str, int], int]) -> dict[str, comparing.Outcome]:
    """Compare a POU.

    `job` contains source folder, POU, number of scans on each engine, and seed.
    """
    folder, name, scans, seed = job
    return comparing.agreed(_subject(folder, matiec="matiec" in scans), name, scans, seed)


def compare(job: Comparison) -> dict[str, Any]:
    """Compare a POU with the engines on random scans, and return the outcome."""
    scans = {"builtin": comparing.SCANS}
    if job.matiec:
        scans["matiec"] = comparing.MATIEC_SCANS
    try:
        found = compared((job.folder, job.pou, scans, 1))
    except UnsupportedError as error:
        return _failed(job, str(error))
    wrong = " ".join(one.disagreement for one in found.values() if one.disagreement)
    engines = {name: asdict(one) for name, one in found.items()}
    return _outcome(job, engines, wrong)


def died(job: Comparison) -> dict[str, Any]:
    """Return the outcome for a POU whose process has died."""
    return _failed(job, DIED)


def _failed(job: Comparison, why: str) -> dict[str, Any]:
    return _outcome(job, {}, f"{job.pou}: {why}")


def _outcome(job: Comparison, engines: Mapping[str, Any], wrong: str) -> dict[str, Any]:
    return {
        "key": job.key,
        "good": not wrong,
        "pou": job.pou,
        "block": job.block,
        "engines": engines,
        "disagreement": wrong,
    }


def summary(found: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the figures of all comparisons.

    `matiec` has its own figures, or a reason without them.
    """
    rows = sorted(found, key=lambda row: str(row["pou"]))
    return {
        **_scans(rows, "builtin"),
        "matiec": _on_matiec(rows),
        "blocks": sum(row["block"] for row in rows),
        "functions": sum(not row["block"] for row in rows),
        "disagreements": [row["disagreement"] for row in rows if row["disagreement"]],
    }


def _on_matiec(rows: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the figures of matiec and a sentence about them.

    Without matiec, return only a sentence.
    """
    why, matiec = missing(), find_matiec()
    if why or matiec is None:
        return {"says": f"not compared on matiec ({why})"}
    compiler, figures = fingerprint_of(matiec)[:12], _scans(rows, "matiec")
    scans, least = figures["scans"], figures["least_of_a_block"]
    says = f"on matiec (compiler {compiler}) {scans:,} scans, at least {least} of each block"
    return {**figures, "compiler": compiler, "says": says}


def _scans(rows: Iterable[Mapping[str, Any]], engine: str) -> dict[str, Any]:
    counts = [(row["engines"].get(engine, {"scans": 0})["scans"], row["block"]) for row in rows]
    return {
        "scans": sum(count for count, _ in counts),
        "least_of_a_block": min((count for count, block in counts if block), default=0),
    }
