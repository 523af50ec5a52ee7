"""The findings of `rcx check`, as text, as JSON and as SARIF 2.1.0.

Source of the format: OASIS, Static Analysis Results Interchange Format (SARIF) 2.1.0.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from structured_text.errors import InputError, in_network, shown_column
from structured_text.language.portability import LintFinding

__all__ = ["JSON_BEGINNING", "RULES", "SARIF_BEGINNING", "Finding", "as_json", "as_sarif"]

#: The kinds of findings, each with the sentence that explains it.
RULES = {
    "error": "The source violates the language: it cannot be compiled.",
    "portability": "A construct that other compilers refuse, or a rule of the library.",
    "call-order": "A block of a robot outside of FB_ReadArea and FB_WriteArea, or called twice.",
    "process-image": "The program writes to a process image that a block of the library owns.",
    "first-mistake": "Legal Structured Text that leaves the robot without a function.",
    "one-engine": "A construct that only the built-in engine runs.",
    "matiec-fault": "A known fault of matiec that changes the meaning of this program.",
    "robot-program": "A mistake in a robot program or in a file with all data of a controller.",
    "refused": "The PLC tool of --for refuses the construct.",
    "may-be-refused": "No public document says whether the PLC tool of --for accepts it.",
}
#: The level in SARIF by the level of a finding.
_LEVELS = {"error": "error", "rule": "error", "warning": "warning"}
JSON_BEGINNING = '{"findings": '
SARIF_BEGINNING = '{"$schema": '
_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


@dataclass(frozen=True)
class Finding:
    """A finding of `rcx check`.

    Attributes:
        level: `error` (exit code 2), `rule` (a broken rule, exit code 1) or `warning`.
        rule: One of `RULES`.
        text: What is wrong; in a drawing, the rung or network comes first.
        file: The file; empty if the finding has none.
        line: Line in the file, from 1; 0 if the finding has none.
        column: Column in the line, from 1; 0 if the finding has none.
        hint: What to do; may be empty.
    """

    level: str
    rule: str
    text: str
    file: str = ""
    line: int = 0
    column: int = 0
    hint: str = ""

    @classmethod
    def of_error(cls, error: InputError, rule: str = "error", level: str = "error") -> Finding:
        """Return the finding for an error in a source."""
        text = in_network(error.line, error.message)
        place = (error.file or "", error.line or 0, error.column or 0)
        return cls(level, rule, text, *place, error.hint)

    @classmethod
    def of_lint(cls, finding: LintFinding, rule: str) -> Finding:
        """Return the finding for a broken rule or a warning."""
        level = "rule" if finding.strict else "warning"
        line, column = finding.at
        text = in_network(line, finding.text)
        return cls(level, rule, text, str(finding.file), line, shown_column(column) or 0)


def as_json(findings: Sequence[Finding], summary: str) -> str:
    """Return the findings as one object of JSON: `findings` and the last line, `summary`."""
    rows = json.dumps([asdict(finding) for finding in findings], indent=1, ensure_ascii=False)
    text = json.dumps(summary, ensure_ascii=False)
    return f'{JSON_BEGINNING}{rows}, "summary": {text}}}\n'


def as_sarif(findings: Sequence[Finding], folder: Path) -> str:
    """Return the findings as a SARIF log with one run.

    Files below `folder` are named relative to it, as code scanning of GitHub and GitLab requires;
    other files by their whole path.
    """
    used = [name for name in RULES if any(finding.rule == name for finding in findings)]
    log = {
        "$schema": _SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "rcx check",
                        "version": version("rcx-harness"),
                        "rules": [
                            {"id": name, "shortDescription": {"text": RULES[name]}} for name in used
                        ],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "results": list(_results(findings, used, folder)),
            }
        ],
    }
    # The first bytes are always the same, so that a file of another program is recognized.
    return "{" + json.dumps(log, indent=1, ensure_ascii=False)[1:].lstrip() + "\n"


def _results(
    findings: Iterable[Finding], rules: Sequence[str], folder: Path
) -> Iterable[dict[str, Any]]:
    for finding in findings:
        text = f"{finding.text}; {finding.hint}" if finding.hint else finding.text
        result: dict[str, Any] = {
            "ruleId": finding.rule,
            "ruleIndex": rules.index(finding.rule),
            "level": _LEVELS[finding.level],
            "message": {"text": text},
        }
        if finding.file:
            place: dict[str, Any] = {"artifactLocation": {"uri": _uri(finding.file, folder)}}
            if finding.line:
                place["region"] = {"startLine": finding.line}
            if finding.line and finding.column:
                place["region"]["startColumn"] = finding.column
            result["locations"] = [{"physicalLocation": place}]
        yield result


def _uri(file: str, folder: Path) -> str:
    """Return the reference to a file, with forward slashes and escaped characters."""
    path, base = Path(os.path.abspath(file)), Path(os.path.abspath(folder))  # without `..`
    if path.is_relative_to(base):
        return quote(path.relative_to(base).as_posix())
    return path.as_uri()
