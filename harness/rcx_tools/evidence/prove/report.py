"""Report of the proofs: out/prove.json, and text for people."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rcx_tools.evidence.prove.assumptions import ASSUMPTIONS
from rcx_tools.evidence.prove.jobs import Job, property_of, worst
from rcx_tools.evidence.prove.property import Property
from structured_text.prove.logic import PROVED

__all__ = ["is_good", "properties", "show", "taken_for_granted", "write"]

#: Number of the slowest goals in the report.
_SLOWEST = 3


def properties(work: Sequence[Job], found: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return one entry for each property. `found` maps the key of a job to its outcome."""
    names = dict.fromkeys(job.property for job in work)
    return [
        _entry(name, [found[job.key] for job in work if job.property == name]) for name in names
    ]


def _entry(name: str, parts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    item = property_of(name)
    goals = [{"part": part["part"], **goal} for part in parts for goal in part["goals"]]
    slowest = sorted(goals, key=lambda goal: -goal["seconds"])[:_SLOWEST]
    return {
        "name": item.name,
        "says": item.says,
        "section": item.section,
        "status": worst(part["status"] for part in parts),
        "seconds": round(sum(part["seconds"] for part in parts), 1),
        "assumes": _assumes(item),
        "uses": list(item.uses),
        "parts": len(parts),
        "goals": len(goals),
        "slowest": [[_told(goal), round(goal["seconds"], 1)] for goal in slowest],
        "not_proved": [goal for goal in goals if goal["status"] != PROVED],
    }


def _assumes(item: Property) -> list[str]:
    """Return the assumptions of a property, including the assumptions of properties it uses."""
    used = (name for other in item.uses for name in _assumes(property_of(other)))
    return list(dict.fromkeys([*item.assumes, *used]))


def _told(goal: Mapping[str, Any]) -> str:
    """Return the name of a goal. The part stands in front if the name does not contain it."""
    part, name = goal["part"], goal["goal"]
    return name if part in name else f"{part}: {name}"


def taken_for_granted(report: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """Map the name of each assumption of these properties to its sentence."""
    names = {name for item in report for name in item["assumes"]}
    return {name: text for name, text in ASSUMPTIONS.items() if name in names}


def write(file: Path, report: Mapping[str, Any]) -> None:
    """Write the report, and create its folder if it is missing."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(report, indent=1, ensure_ascii=False, default=str)
    file.write_text(text + "\n", encoding="utf-8")


def is_good(report: Mapping[str, Any]) -> bool:
    """Return whether all is proved, the engines agree, and each bug breaks its properties."""
    proved = all(item["status"] == PROVED for item in report["properties"])
    bad = report.get("seeded", {}).get("defects"), report.get("agreement", {}).get("disagreements")
    return proved and not any(bad)


def show(report: Mapping[str, Any], console: Console) -> None:
    """Print the report of the proofs for people."""
    table = Table("property", "", "goals", "solver [s]", "slowest goal", box=None)
    for item in report["properties"]:
        seconds = [str(item[key]) for key in ("goals", "seconds")]
        slowest = ", ".join(f"{name} {taken} s" for name, taken in item["slowest"][:1])
        table.add_row(item["name"], item["status"], *seconds, slowest)
    console.print(table)
    lines = _not_proved(report["properties"]), _agreed(report), _bugs(report.get("seeded"))
    for line in chain.from_iterable(lines):
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _not_proved(items: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for item in items:
        for goal in item["not_proved"]:
            why = goal["reason"] or f"for example {_values(goal['values'])}"
            yield f"{goal['status']}: {item['name']}: {_told(goal)}: {why}"


def _agreed(report: Mapping[str, Any]) -> Iterator[str]:
    if "agreement" in report:
        one = report["agreement"]
        yield (
            f"translation and engine: {one['scans']:,} scans of {one['blocks']} blocks, at least"
            f" {one['least_of_a_block']} of each; {one['matiec']['says']};"
            f" disagreements: {len(one['disagreements'])}"
        )
        yield from one["disagreements"]


def _values(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())


def _bugs(seeded: Mapping[str, Any] | None) -> Iterator[str]:
    if seeded is None:
        return
    yield (
        f"seeded bugs: {seeded['as_expected']} of {seeded['tried']} break exactly what they should"
    )
    yield from seeded["defects"]
