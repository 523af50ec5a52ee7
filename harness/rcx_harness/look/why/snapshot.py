"""Read a snapshot: values that a person has copied from an HMI or a watch table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rcx_harness.look.why.facts import Facts
from rcx_harness.spec import signals, whole_number
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.language.types import BlockType
from structured_text.output.toml_files import check_keys, line_of, load_toml

__all__ = ["facts_of_snapshot"]

_TABLES = ("signals", "words", "variables")
_WORDS = ("status", "code")


def facts_of_snapshot(file: Path, program: Program) -> Facts:
    """Read the facts of a snapshot of a program.

    Signals that are not in the table `signals` are taken from the RCX_REF among the variables.

    Raises:
        InputError: the file is not a snapshot, or a signal or variable does not exist.
    """
    table = load_toml(file)
    check_keys(table, _TABLES, file=file)
    for name in _TABLES:
        if not isinstance(table.get(name, {}), dict):
            raise InputError(f"'{name}' is not a table", file=file, hint=f"write [{name}]")
    facts = Facts()
    facts.controllers.add(1)
    for path, kind in program.walk():
        if isinstance(kind, BlockType):
            facts.blocks[path] = kind.name
    for path, value in table.get("variables", {}).items():
        _check(path, program, file)
        facts.take_path(path, _number(value))
    for name, value in table.get("signals", {}).items():
        facts.take(f"1:{_signal(name, value, file)}", bool(value))
    words = table.get("words", {})
    check_keys(words, _WORDS, "words", file)
    for name, value in words.items():
        facts.take(f"1:{name}", _word(name, _number(value), file))
    _from_reference(facts)
    return facts


def _check(path: str, program: Program, file: Path) -> None:
    try:
        program.type_of(path)
    except InputError as error:
        line = line_of(file, path)
        raise InputError(error.message, file=file, line=line, hint=error.hint) from None


def _signal(name: str, value: Any, file: Path) -> str:
    try:
        signal = signals().find(name).signal
    except InputError as error:
        raise InputError(
            error.message, file=file, line=line_of(file, name), hint=error.hint
        ) from None
    if type(value) is not bool:
        text = f"{name} is {value!r}, and not true or false"
        raise InputError(text, file=file, line=line_of(file, name))
    return signal


def _number(value: Any) -> Any:
    """Return the number of a text such as `16#8006`, as a watch table shows it."""
    if isinstance(value, Mapping):
        return {name: _number(member) for name, member in value.items()}
    if isinstance(value, str) and value.startswith("16#"):
        try:
            return whole_number(value)
        except ValueError:
            return value
    return value


def _word(name: str, value: Any, file: Path) -> int:
    if type(value) is not int or not 0 <= value <= 0xFFFF:
        raise InputError(
            f"{name} is {value!r}, and not a word",
            file=file,
            line=line_of(file, name),
            hint='write 0x0100 or "16#0100"',
        )
    return value


def _from_reference(facts: Facts) -> None:
    """Take signals and status from the RCX_REF among the variables, if there is only one."""
    paths = [path for path in facts.paths() if ".SO." in path or ".SI." in path]
    heads = {path.replace(".SI.", ".SO.").partition(".SO.")[0] for path in paths}
    heads |= {path[: -len(".Status")] for path in facts.paths() if path.endswith(".Status")}
    if len(heads) != 1:
        return
    head = heads.pop()
    for kind, listed in (("SO", signals().output), ("SI", signals().input)):
        for signal in listed:
            found = facts.changes(f"{head}.{kind}.{signal.name}")
            if found and type(found[0].value) is bool and not facts.changes(f"1:{signal.signal}"):
                facts.take(f"1:{signal.signal}", found[0].value)
    status = facts.changes(f"{head}.Status")
    if status and type(status[0].value) is int and not facts.changes("1:status"):
        facts.take("1:status", status[0].value)
