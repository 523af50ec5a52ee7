"""The option `--junit` of several commands, and their results as suites of a JUnit file.

Each item of a command is a case: a seed, a moment, a property or a mutant. The text of a failure
names the command that replays it, if there is one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from structured_text.errors import InputError
from structured_text.output.junit import JunitCase, JunitFile, JunitSuite, Problem
from structured_text.output.units import format_us

if TYPE_CHECKING:
    from structured_text.mutants.report import Judged
    from structured_text.mutants.user import Verdicts
    from structured_text.prove.user import Result

__all__ = ["Junit", "junit_file", "moments_suite", "mutants_suite", "properties_suite", "seed_case"]

Junit = Annotated[Path | None, typer.Option("--junit", help="Write the results as JUnit XML.")]


def junit_file(file: Path | None, json_file: Path | None, read: Iterable[Path]) -> JunitFile:
    """Return the file of `--junit`; raise InputError if writing it would destroy another file."""
    if file is not None and file == json_file:
        raise InputError("--json and --junit name the same file", file=file)
    return JunitFile(file, read)


def seed_case(
    seed: int,
    virtual_us: int,
    failures: Mapping[str, tuple[int, str]],
    replays: Mapping[tuple[str, int], str],
) -> JunitCase:
    """Return a seed of a campaign as a case; `replays` has the replay by failure and seed."""
    texts, kinds = [], list(failures)
    for kind, (t_us, text) in failures.items():
        replay = replays.get((kind, seed), "")
        texts.append(f"{kind} at {format_us(t_us)}: {text}{_replayed(replay)}")
    problems = (Problem("failure", ", ".join(kinds), "\n".join(texts)),) if kinds else ()
    return JunitCase(f"seed {seed}", "campaign", seconds=virtual_us / 1e6, problems=problems)


def moments_suite(
    injects: Iterable[str],
    scans: Sequence[int],
    scan_us: int,
    found: Mapping[tuple[str, str], Mapping[int, str]],
    replays: Mapping[tuple[str, str], str],
) -> JunitSuite:
    """Return a sweep as a suite.

    `found` has the failing scans with their sentences, by injected fault and kind of failure.
    `replays` has the replay of the first of these scans.
    """
    cases = []
    for name in injects:
        of_fault = {kind: those for (fault, kind), those in found.items() if fault == name}
        for scan in scans:
            failing = {kind: those[scan] for kind, those in of_fault.items() if scan in those}
            texts = [
                f"{kind}: {text}{_replayed(replays.get((name, kind), ''))}"
                for kind, text in failing.items()
            ]
            problem = Problem("failure", ", ".join(failing), "\n".join(texts))
            at = f"scan {scan} ({format_us(scan * scan_us)})"
            cases.append(JunitCase(at, f"sweep.{name}", problems=(problem,) if failing else ()))
    return JunitSuite("sweep", cases)


def _replayed(replay: str) -> str:
    return f"\n  replay: {replay}" if replay else ""


def properties_suite(results: Iterable[Result]) -> JunitSuite:
    """Return a proof as a suite. A property that is neither proved nor refuted is an error."""
    cases = []
    for result in results:
        file, _, line = result.at.rpartition(":")
        place = (file, int(line)) if line.isdecimal() else (result.at, 0)
        problems: tuple[Problem, ...] = ()
        if result.status in ("refuted", "unknown"):
            kind = "failure" if result.status == "refuted" else "error"
            text = "\n".join(filter(None, (result.says, result.note)))
            replay = _replayed(result.command)
            problems = (Problem(kind, f"{result.status}: {result.says}", f"{text}{replay}"),)
        cases.append(
            JunitCase(result.name, "prove", *place, seconds=result.seconds, problems=problems)
        )
    return JunitSuite("prove", cases)


def mutants_suite(verdicts: Verdicts) -> JunitSuite:
    """Return the mutants as a suite.

    A survivor is a failure. It is skipped if the user has given a reason, as is a mutant that was
    not run yet.
    """
    rows = iter(verdicts.figures["survivors"])  # in the order of the survivors
    cases = [_mutant(one, {} if one.killed else next(rows)) for one in verdicts.judged]
    for mutant in verdicts.not_run:
        name = f"line {mutant.line}: {mutant.operator}: {mutant.after or 'nothing'}"
        place = (mutant.file, mutant.line)
        cases.append(JunitCase(name, mutant.pou, *place, skipped="not run yet"))
    return JunitSuite("mutants", cases)


def _mutant(judged: Judged, row: Mapping[str, Any]) -> JunitCase:
    mutant = judged.mutant
    name = f"line {mutant.line}: {mutant.operator}: {mutant.after or 'nothing'}"
    place = (mutant.file, mutant.line)
    if judged.killed:
        return JunitCase(name, mutant.pou, *place)
    if row["reason"]:
        return JunitCase(name, mutant.pou, *place, skipped=str(row["reason"]))
    lines = [f"{mutant.file}:{mutant.line}: {mutant.operator} survives"]
    lines += [f"  - {line}" for line in mutant.before.splitlines()]
    lines += [f"  + {line}" for line in (mutant.after or "(nothing)").splitlines()]
    why = f", because {judged.by}" if judged.by else ""
    problem = Problem("failure", f"{mutant.operator} survives{why}", "\n".join(lines))
    return JunitCase(name, mutant.pou, *place, problems=(problem,))
