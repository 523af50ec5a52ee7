"""A robot file with the results of a fit, based on the file with which the fit began."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rcx_harness.look.compare.fit import Fit
from rcx_harness.robot import RobotConfig
from structured_text.errors import InputError
from structured_text.output.toml_files import toml_text

__all__ = ["robot_file"]


def robot_file(fit: Fit, base: Path | None, of: str) -> str:
    """Return the text of the robot file.

    `base` is the robot file with which the search began; its tables are copied. `of` names the
    recording.
    """
    old = toml_text(base) if base is not None else ""
    before = RobotConfig.load(base) if base is not None else RobotConfig()
    changed = {
        entry.name: getattr(fit.config, entry.name)
        for entry in fields(RobotConfig)
        if getattr(fit.config, entry.name) != getattr(before, entry.name)
    }
    head, table, rest = _split(old)
    kept = [line for line in head.splitlines() if _key(line) not in changed]
    text = "\n".join([*_comment(fit, of), *map(_line, changed.items()), "", *kept])
    text = text.rstrip() + "\n" + (f"\n{table}{rest}" if table else "")
    with TemporaryDirectory() as folder:
        written = Path(folder) / "robot.toml"
        written.write_text(text, encoding="utf-8")
        if RobotConfig.load(written) != fit.config:
            hint = "write each key that stands above the tables on one line"
            raise InputError("what was found cannot be put into it", file=base, hint=hint)
    return text


def _split(text: str) -> tuple[str, str, str]:
    """Return the text before the first table, the rest, and an empty text."""
    found = re.search(r"^\s*\[", text, re.MULTILINE)
    return (text[: found.start()], text[found.start() :], "") if found else (text, "", "")


def _key(line: str) -> str:
    found = re.match(r"\s*([A-Za-z0-9_]+)\s*=", line)
    return found[1] if found else ""


def _comment(fit: Fit, of: str) -> Iterator[str]:
    yield f"# Proposed by rcx compare --fit from {of}: what it shows of the controller."
    if fit.left:
        yield f"# {len(fit.left)} differences are left that no key expresses."
    names = [one.key for one in fit.knobs if not one.found]
    yield "# That recording cannot decide:"
    line = "#"
    for name in names:
        if len(line) + len(name) > 96:
            yield line + ","
            line = "#"
        line += f"{',' if line != '#' else ''} {name}"
    yield line


def _line(item: tuple[str, Any]) -> str:
    return f"{item[0]} = {_toml(item[1])}"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return repr(value)
