"""The report on mutants: figures, and the survivors with their reasons."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.mutants.mutant import Mutant
from structured_text.output.files import replace_files
from structured_text.output.toml_files import line_of, load_toml

__all__ = ["Judged", "Reasons", "figures", "write_rows"]


@dataclass(frozen=True)
class Judged:
    """A mutant, and whether a test has found it; `by` is the test, or the reason in words."""

    mutant: Mutant
    killed: bool
    by: str


#: The fields of a row in the table of known survivors.
_ROW = ("block", "line", "becomes", "reason")


class Reasons:
    """The table of known survivors, by block, changed lines and their new text.

    A block may be a pattern with `*`, so that one row covers several blocks.

    Raises:
        InputError: The file is not TOML, or a row is incomplete.
    """

    def __init__(self, file: Path) -> None:
        rows = load_toml(file).get("survivor", []) if file.exists() else []
        for number, row in enumerate(rows, 1):
            if not isinstance(row, dict) or not all(isinstance(row.get(key), str) for key in _ROW):
                hint = f"write {', '.join(_ROW)}, each as a text"
                line, text = (
                    line_of(file, "survivor", number),
                    f"[[survivor]] {number} is incomplete",
                )
                raise InputError(text, file=file, line=line, hint=hint)
        self._reasons: dict[tuple[str, str, str], str] = {}
        self._used: set[tuple[str, str, str]] = set()
        for row in rows:
            self._reasons[row["block"], row["line"].strip(), row["becomes"].strip()] = row["reason"]

    def of(self, mutant: Mutant) -> str:
        """Return the reason why a mutant survives; empty if the table has no row for the mutant."""
        for key, reason in self._reasons.items():
            if _fits(key, mutant):
                self._used.add(key)
                return reason
        return ""

    def idle(self, killed: Sequence[Mutant]) -> list[str]:
        """Return the obsolete rows of the table: a test kills the mutant that they explain."""
        idle = [key for key in self._reasons if key not in self._used]
        return [
            f"{key[0]}: {key[2]}" for key in idle if any(_fits(key, mutant) for mutant in killed)
        ]

    def lost(self, mutants: Sequence[Mutant], blocks: Collection[str]) -> list[str]:
        """Return the rows of these blocks that match none of the mutants.

        `mutants` must contain every mutant of these blocks.
        """
        return [
            f"{key[0]}: {key[2]}"
            for key in self._reasons
            if key[0] in blocks and not any(_fits(key, mutant) for mutant in mutants)
        ]


def _fits(key: tuple[str, str, str], mutant: Mutant) -> bool:
    return key[1:] == (mutant.before, mutant.after) and fnmatchcase(mutant.pou, key[0])


def figures(
    judged: Sequence[Judged],
    reasons: Reasons,
    folder: Callable[[str], str],
    whole: Collection[str] = (),
) -> dict[str, Any]:
    """Return the figures of a run.

    `folder` returns the group of a file. `whole` has the POUs for which all mutants were made and
    not only a sample.
    """
    survivors = [one.mutant for one in judged if not one.killed]
    rows = [
        {
            "block": mutant.pou,
            "file": mutant.file,
            "line": mutant.line,
            "operator": mutant.operator,
            "before": mutant.before,
            "after": mutant.after,
            "reason": reasons.of(mutant),
        }
        for mutant in survivors
    ]
    return {
        **_score(judged),
        "score_by_folder": _grouped(judged, lambda one: folder(one.mutant.file)),
        "score_by_operator": _grouped(judged, lambda one: one.mutant.operator),
        "survivors_with_a_reason": sum(bool(row["reason"]) for row in rows),
        "rows_without_a_survivor": reasons.idle([one.mutant for one in judged if one.killed]),
        "rows_without_a_mutant": reasons.lost([one.mutant for one in judged], whole),
        "survivors": rows,
    }


def _score(judged: Sequence[Judged]) -> dict[str, Any]:
    killed = sum(one.killed for one in judged)
    score = round(100.0 * killed / len(judged), 2) if judged else 0.0
    return {"mutants": len(judged), "killed": killed, "score": score}


def _grouped(judged: Sequence[Judged], key: Any) -> dict[str, dict[str, Any]]:
    groups: dict[str, list[Judged]] = {}
    for one in judged:
        groups.setdefault(key(one), []).append(one)
    return {name: _score(groups[name]) for name in sorted(groups)}


def write_rows(file: Path, survivors: Sequence[Mapping[str, Any]]) -> None:
    """Write the survivors without a reason as rows for a table of reasons, without duplicates."""
    rows = [
        "\n".join(
            (
                "[[survivor]]",
                f"block = {json.dumps(row['block'])}",
                f"line = {json.dumps(row['before'], ensure_ascii=False)}",
                f"becomes = {json.dumps(row['after'], ensure_ascii=False)}",
                'reason = ""',
                "",
            )
        )
        for row in survivors
        if not row["reason"]
    ]
    replace_files({file: "\n".join(dict.fromkeys(rows)).encode()})
