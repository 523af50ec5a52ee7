"""The tool `run`."""

from __future__ import annotations

import shlex
from typing import Any

from rcx_harness.assistant.call import Answer, Call, word
from rcx_harness.assistant.explaining import state_at_the_end
from rcx_harness.assistant.limits import MOST_VIRTUAL
from rcx_harness.trace import Scan, Violation, read_trace
from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.units import parse_us

__all__ = ["check_duration", "run"]

#: Greatest number of violations in the answer; the trace has all.
_MOST_VIOLATIONS = 100


def check_duration(name: str, text: str) -> None:
    """Raise InputError if a virtual time is longer than the limit."""
    if parse_us(text) > parse_us(MOST_VIRTUAL):
        hint = f"use at most {MOST_VIRTUAL}, or rcx run on a terminal"
        raise InputError(f"{name} is {text}, which is too long for a call", hint=hint)


def run(call: Call) -> Answer:
    """Run a program in a virtual cell as `rcx run` does."""
    check_duration("duration", call.given.get("duration", "5s"))
    words = call.words("files")
    words += [f"--robot={path.as_posix()}" for path in call.paths("robot")]
    words += [f"--properties={path.as_posix()}" for path in call.paths("properties")]
    for name in ("dialect", "scan", "seed", "size", "rpi", "jitter"):
        words += call.option(name, name)
    words += call.option("for", "duration")
    words += ["--engine=builtin"]
    words += ["--no-robot"] if call.given.get("no_robot") else []
    out = call.out()
    stimulus = call.given.get("stimulus")
    if stimulus is not None:
        replace_files({out / "stimulus.toml": stimulus.encode()})
        words += [f"--stimulus={word(out / 'stimulus.toml')}"]
    watched = call.given.get("watch") or []
    words += [f"--watch={name}" for name in watched]
    trace = out / "trace.jsonl"
    written = [f"--trace={word(trace)}"]
    if not call.given.get("no_robot"):
        written += [f"--chart={word(out / 'chart.svg')}"]
    ran = call.ran(["run", *words, *written])
    data = _result(call, trace)
    data |= {
        "exit_code": ran.code,
        "report": [line for line in ran.lines if not line.startswith("written: ")],
        "trace": trace.as_posix(),
        "replay": " ".join(["rcx run", *map(shlex.quote, words)]),
    }
    return Answer(data, "\n".join(data["report"]))


def _result(call: Call, trace: Any) -> dict[str, Any]:
    """Return the violations, the last values and the last state of a run, from its trace."""
    violations: list[dict[str, Any]] = []
    count, values = 0, dict[str, Any]()
    header, records = read_trace(trace)
    last_us = 0
    for record in records:
        last_us = record.t_us
        if isinstance(record, Violation):
            count += 1
            if len(violations) < _MOST_VIOLATIONS:
                row = {"t_us": record.t_us, "rule": record.rule, "text": record.text}
                violations.append(row)
        elif isinstance(record, Scan) and record.vars is not None:
            values = dict(record.vars)
    return {
        "end_us": last_us,
        "engine": header["engine"],
        "violation_count": count,
        "violations": violations,
        "watched": {name: str(value) for name, value in values.items()},
        "signals_on": state_at_the_end(trace),
    }
