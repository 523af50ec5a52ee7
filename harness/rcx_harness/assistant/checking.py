"""The tools `check` and `prove`."""

from __future__ import annotations

import json
from typing import Any

from rcx_harness.assistant.call import Answer, Call, word
from rcx_harness.verify.storm.written import forget

__all__ = ["check", "prove"]


def check(call: Call) -> Answer:
    """Check a program as `rcx check` does."""
    file = call.temporary / "check.json"
    words = ["check", *call.words("files"), f"--json={file}"]
    words += [*call.option("for", "for"), *call.option("dialect", "dialect")]
    ran = call.ran(words)
    found = json.loads(file.read_text(encoding="utf-8"))
    summary = str(found["summary"]) or "the sources have errors"
    data = {**found, "exit_code": ran.code, "summary": summary}
    lines = [_line(finding) for finding in found["findings"]]
    return Answer(data, "\n".join([*lines, summary]))


def _line(finding: dict[str, Any]) -> str:
    place = ":".join(str(finding[key]) for key in ("file", "line", "column") if finding[key])
    hint = f"; {finding['hint']}" if finding["hint"] else ""
    return f"{finding['level']}: {place}: {finding['text']}{hint}"


def prove(call: Call) -> Answer:
    """Prove the properties of a program as `rcx prove` does."""
    out, file = call.out(), call.temporary / "prove.json"
    forget(out)
    words = ["prove", *call.words("files"), f"--json={file}", f"--out={word(out)}"]
    words += [*call.option("dialect", "dialect"), *call.option("scan", "scan")]
    words += [*call.option("limit", "limit")]
    words += ["--no-robot"] if call.given.get("no_robot") else []
    words += ["--overflow"] if call.given.get("overflow") else []
    ran = call.ran(words)
    found = json.loads(file.read_text(encoding="utf-8"))
    rows = [
        {
            "name": row["name"],
            "says": row["says"],
            "at": row["at"],
            "status": row["status"],
            "assumes": row["assumes"],
            "note": row["note"],
            "replay": row["stimulus"],
            "command": row["command"],
        }
        for row in found["properties"]
    ]
    wanted = call.given.get("properties")
    if wanted:
        rows = [row for row in rows if _named(row, wanted)]
    lines = [f"{row['status']}: {row['at']} {row['says']}".replace(":  ", ": ") for row in rows]
    said = [line for line in ran.lines if not line.startswith("written: ")]
    summary = said[-1] if said else ""
    data = {"exit_code": ran.code, "inputs": found["inputs"], "properties": rows}
    return Answer({**data, "summary": summary}, "\n".join([*lines, summary]))


def _named(row: dict[str, Any], wanted: list[str]) -> bool:
    """Return whether a property belongs to a part of the answer that the caller wants."""
    text = f"{row['name']} {row['says']} {row['at']}".lower()
    return any(one.lower() in text for one in wanted)
