"""The tools `campaign` and `mutants`."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from rcx_harness.assistant.call import Answer, Call, word
from rcx_harness.assistant.running import check_duration
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.verify.storm.campaign import Explained, Seed, Storms, classes, storms
from rcx_harness.verify.storm.cells import Cells, CellsOf
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.replay import replay
from rcx_harness.verify.storm.written import command, file_name, forget, write
from structured_text.farm import Farm
from structured_text.output.files import replace_files

__all__ = ["campaign", "mutants"]

_SEEDS = 20
#: Greatest number of surviving mutants in an answer.
_MOST_SURVIVORS = 100


def campaign(call: Call) -> Answer:
    """Run a cell with random faults as `rcx campaign` does, in one process."""
    out = call.out()
    forget(out)
    properties = call.paths("properties")
    if (length := call.given.get("duration")) is not None:
        check_duration("duration", length)
        file = out / "length.toml"
        replace_files({file: f'length = "{length}"\n'.encode()})
        properties.append(file)
    stimulus = call.given.get("stimulus")
    good = None if stimulus is None else call.path(stimulus)
    options: dict[str, Any] = {"engine": "builtin"}
    if robots := call.paths("robot"):
        options["robot"] = robots
    if (scan := call.given.get("scan")) is not None:
        options["scan"] = scan
    of = CellsOf.of(call.paths("files"), options, properties, good)
    first = call.given.get("seed_from", 0)
    seeds = range(first, first + call.given.get("seeds", _SEEDS))
    cells = of.make()
    with cells.cell(first) as cell:
        Course(cell, cells.demands)  # raises InputError if a demanded variable is missing
    farm, work = Farm(0, console=Console(quiet=True)), Storms(of)
    failing: dict[str, list[tuple[int, int]]] = {}
    total = Seed({}, 0, 0, 0)
    for done, (seed, result) in enumerate(storms(farm, work, seeds), 1):
        total = Seed(
            {},
            total.virtual_us + result.virtual_us,
            total.scans + result.scans,
            total.acts + result.acts,
        )
        for kind, (t_us, _) in result.failures.items():
            failing.setdefault(kind, []).append((t_us, seed))
        call.progress(f"seed {seed}", done, len(seeds))
    rows: list[dict[str, Any]] = []
    for kind, found in classes(farm, work, failing):
        rows.append(_class(call, cells, kind, found, [row["name"] for row in rows]))
    for row in rows:
        del row["name"]
    data = {
        "exit_code": int(bool(rows)),
        "seeds": {"first": seeds[0], "count": len(seeds)},
        "events": total.acts,
        "scans": total.scans,
        "virtual_us": total.virtual_us,
        "failures": rows,
        "notice": cells.notice,
    }
    lines = [f"{len(seeds)} seeds, {total.acts} events, {total.virtual_us / 1e6:g} s"]
    for row in rows:
        lines.append(f"{row['says']}; {len(row['seeds'])} seeds; replay: {row['replay'] or 'none'}")
    return Answer(data, "\n".join([*lines, *([] if rows else ["nothing failed"])]))


def _class(
    call: Call, cells: Cells, kind: str, found: Explained, taken: list[str]
) -> dict[str, Any]:
    """Write the replay of a class of failures, and return the class for the answer."""
    out = call.out()
    row: dict[str, Any] = {
        "kind": kind,
        "name": file_name(kind, taken),
        "seeds": list(found.seeds),
        "causes": list(found.causes),
        "says": f"{kind}: the failure did not occur again",
        "replay": "",
        "chart": "",
        "command": "",
        "fails_again": False,
    }
    if found.replay is None:
        return row
    file = out / f"{row['name']}.toml"
    write(out, {file.name: found.replay.text})
    again = replay(cells, found.replay, Stimulus.load(file))
    write(out, {f"{row['name']}.svg": again.chart})
    words = call.words("files") + [f"--robot {word(path)}" for path in call.paths("robot")]
    words += [f"--scan {call.given['scan']}"] if call.given.get("scan") else []
    words += [f"--properties {word(path)}" for path in call.paths("properties")]
    return row | {
        "says": found.replay.told,
        "replay": file.as_posix(),
        "chart": file.with_suffix(".svg").as_posix(),
        "command": command(found.replay, [*words, "--engine builtin"], file),
        "fails_again": bool({found.replay.kind, "expect"}.intersection(again.found)),
    }


def mutants(call: Call) -> Answer:
    """Put small mistakes into a program, and run its tests, in one process after the other."""
    from rcx_harness.cell.sources import source_files
    from structured_text.mutants.judging import Judging, is_outcome
    from structured_text.mutants.report import Reasons
    from structured_text.mutants.sessions import PytestCommand
    from structured_text.mutants.user import UserMutants
    from structured_text.output.results import Results

    out = call.out()
    files, tests = call.paths("files"), call.words("tests")
    console = Console(quiet=True)
    run = PytestCommand.of(["pytest", *tests], call.here)
    work = UserMutants(source_files(files), run)
    call.progress("running the tests with the unchanged program", None, None)
    baseline = work.baseline()
    call.progress("running the mutants", None, None)
    results = Results(out / "mutants.jsonl", fresh=False, is_whole=is_outcome)
    judging = Judging(console, results, None)
    verdicts = work.judged(baseline, judging, Farm(0, console=console), Reasons(out / "none.toml"))
    found = verdicts.figures
    survivors = [
        {key: row[key] for key in ("file", "line", "operator", "before", "after")}
        for row in found["survivors"]
    ]
    data = {
        "exit_code": int(bool(survivors)),
        "mutants": found["mutants"],
        "killed": found["killed"],
        "not_compiling": found["not_compiling"],
        "score": found["score_without_reasons"],
        "survivors": survivors[:_MOST_SURVIVORS],
        "survivor_count": len(survivors),
        "results": (out / "mutants.jsonl").as_posix(),
    }
    lines = [
        f"{row['file']}:{row['line']}: {row['operator']} survives: {row['before'].strip()} -> "
        f"{row['after'].strip() or '(nothing)'}"
        for row in data["survivors"]
    ]
    lines.append(f"{found['killed']} of {found['mutants']} mutants killed")
    return Answer(data, "\n".join(lines))
