"""A robot file with the results of a fit, based on the file with which the fit began."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory

from rcx_harness.look.compare.fit import Fit
from rcx_harness.robot import RobotConfig
from structured_text.errors import InputError
from structured_text.output.toml_files import toml_text, toml_value

__all__ = ["robot_file"]


def robot_file(fit: Fit, base: Path | None, of: str) -> str:
    """Return the text of the robot file.

    `base` is the robot file with which the search began. Its tables are copied. `of` is the name of
    the recording.
    """
    old = toml_text(base) if base is not None else ""
    before = RobotConfig.load(base) if base is not None else RobotConfig()
    changed = {
        entry.name: getattr(fit.config, entry.name)
        for entry in fields(RobotConfig)
        if getattr(fit.config, entry.name) != getattr(before, entry.name)
    }
    tables = re.search(r"^\s*\[", old, re.MULTILINE)
    head, table = (old[: tables.start()], old[tables.start() :]) if tables else (old, "")
    kept = [line for line in head.splitlines() if _key(line) not in changed]
    keys = [f"{key} = {toml_value(value)}" for key, value in changed.items()]
    text = "\n".join([*_comment(fit, of), *keys, "", *kept])
    text = text.rstrip() + "\n" + (f"\n{table}" if table else "")
    with TemporaryDirectory() as folder:
        written = Path(folder) / "robot.toml"
        written.write_text(text, encoding="utf-8")
        if RobotConfig.load(written) != fit.config:
            hint = "write each key that stands above the tables on one line"
            raise InputError(
                "the fitted values cannot be written into this file", file=base, hint=hint
            )
    return text


def _key(line: str) -> str:
    found = re.match(r"\s*([A-Za-z0-9_]+)\s*=", line)
    return found[1] if found else ""


def _comment(fit: Fit, of: str) -> Iterator[str]:
    yield f"# Proposed by rcx compare --fit: the properties that {of} shows of the controller."
    if fit.left:
        yield f"# {len(fit.left)} differences remain that no key explains."
    names = [one.key for one in fit.knobs if not one.found]
    yield "# The recording cannot decide these keys:"
    line = "#"
    for name in names:
        if len(line) + len(name) > 96:
            yield line + ","
            line = "#"
        line += f"{',' if line != '#' else ''} {name}"
    yield line
