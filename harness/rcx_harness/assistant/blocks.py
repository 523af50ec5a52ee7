"""The tools `list_blocks` and `block_page`: the blocks of the library, read from their sources."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness.assistant.call import Answer, Call
from rcx_harness.cell.sources import default_lib
from rcx_harness.spec import folder
from structured_text.errors import InputError, near
from structured_text.output.toml_files import load_toml

__all__ = ["Block", "Pin", "block_page", "blocks", "list_blocks", "page"]

_SECTION = re.compile(r"^  (VAR_\w+)\n(.*?)^  END_VAR", re.DOTALL | re.MULTILINE)
_PIN = re.compile(r"^    (\w+)\s*:\s*(.+?)(?:\s*:=\s*(.*?))?;\s*(?:\(\* (.*?) \*\))?$")
_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)
_ERROR = re.compile(r"WORD#16#(8(?!000)[0-9A-F]{3})\b")
_RESULT = re.compile(r"^FUNCTION \w+ : (\w+)", re.MULTILINE)
_MANUAL = re.compile(r" \(((?:remote command )?(?:chapter|guide)[^()]*)\)")
#: Sections of declarations, and their titles in a page.
_TITLES = {"VAR_IN_OUT": "In and out", "VAR_INPUT": "Inputs", "VAR_OUTPUT": "Outputs"}
_UNSAID = ("Generated from", "Tests:")


@dataclass(frozen=True)
class Pin:
    """A pin of a block, as it is declared."""

    section: str
    name: str
    type: str
    default: str
    comment: str


@dataclass(frozen=True)
class Block:
    """A block or a function of the library.

    Attributes:
        folder: Folder of the library, such as `motion`.
        purpose: What it does, in one line.
        section: Section of the manual, or empty.
        about: Further paragraphs of its head.
        result: Type of the result of a function, or empty.
        errors: ErrorIDs that its own code sets.
    """

    name: str
    folder: str
    purpose: str
    section: str
    about: tuple[str, ...]
    result: str
    pins: tuple[Pin, ...]
    errors: tuple[int, ...]
    text: str

    @property
    def internal(self) -> bool:
        """Return whether programs do not call it, because it is a part of other blocks."""
        return self.folder == "core"


@cache
def blocks() -> dict[str, Block]:
    """Return the blocks and functions of the library by name."""
    lib = default_lib()
    files = sorted(lib.rglob("F[BC]_*.st"), key=lambda file: file.stem)
    return {file.stem: _block(file, file.relative_to(lib).parts[0]) for file in files}


def _block(file: Path, name: str) -> Block:
    text = file.read_text(encoding="utf-8")
    first, *others = _head(text)
    purpose = first.partition(": ")[2] or first
    section = _MANUAL.search(purpose)
    if section:
        purpose = purpose.replace(section[0], "", 1)
    code = _COMMENT.sub(" ", text)
    result = _RESULT.search(code)
    return Block(
        file.stem,
        name,
        purpose[:1].upper() + purpose[1:],
        section[1] if section else "",
        tuple(one for one in others if not one.startswith(_UNSAID)),
        result[1] if result else "",
        tuple(_pins(text)),
        tuple(sorted({int(number, 16) for number in _ERROR.findall(code)})),
        text,
    )


def _head(text: str) -> list[str]:
    """Return the paragraphs of the comment at the head of a file."""
    comment = text.partition("*)")[0]
    lines = [re.sub(r"^\s*\(?\*", "", line).strip() for line in comment.splitlines()]
    paragraphs = re.split(r"\n\n+", "\n".join(lines).strip())
    return [part for one in paragraphs for part in re.split(r" (?=Tests: )", " ".join(one.split()))]


def _pins(text: str) -> Iterator[Pin]:
    for section, body in _SECTION.findall(text):
        if section not in _TITLES:
            continue
        for line in body.splitlines():
            if found := _PIN.match(line):
                yield Pin(section, *found.groups(default=""))


@cache
def _errors() -> dict[int, dict[str, Any]]:
    table = load_toml(folder() / "errors.toml")["error"]
    return {row["id"]: row for row in table}


def list_blocks(call: Call) -> Answer:
    """List the blocks of the library, with their pins and purposes."""
    wanted = str(call.given.get("search") or "").lower()
    every = call.given.get("internal", False)
    found = [
        {
            "name": block.name,
            "folder": block.folder,
            "purpose": block.purpose,
            "section": block.section,
            "returns": block.result,
            "inputs": [pin.name for pin in block.pins if pin.section != "VAR_OUTPUT"],
            "outputs": [pin.name for pin in block.pins if pin.section == "VAR_OUTPUT"],
        }
        for block in blocks().values()
        if (every or not block.internal)
        and wanted in f"{block.name} {block.folder} {block.purpose}".lower()
    ]
    lines = [f"{row['name']}: {row['purpose']}" for row in found]
    return Answer({"blocks": found}, "\n".join(lines) or "no block contains this text")


def block_page(call: Call) -> Answer:
    """Return the page of a block: what it does, its pins, its errors and its source."""
    name = call.given["name"]
    text = page(name)
    block = blocks()[name]
    pins = [
        {
            "section": pin.section,
            "name": pin.name,
            "type": pin.type,
            "default": pin.default,
            "meaning": pin.comment,
        }
        for pin in block.pins
    ]
    data = {"name": name, "purpose": block.purpose, "pins": pins, "page": text}
    return Answer(data, text, whole=True)


def page(name: str) -> str:
    """Return the page of a block as Markdown; raise InputError if there is no such block."""
    if name not in blocks():
        raise InputError(f"there is no block {name!r:.100}", hint=near(name, blocks()))
    block = blocks()[name]
    lines = [f"# {name}", "", f"{block.purpose}"]
    for paragraph in block.about:
        lines += ["", paragraph]
    if block.internal:
        lines += ["", "It is a part of other blocks. A program does not call it."]
    if block.section:
        lines += ["", f"Manual: {block.section}."]
    if block.result:
        lines += ["", f"Returns {block.result}."]
    for section, title in _TITLES.items():
        pins = [pin for pin in block.pins if pin.section == section]
        if pins:
            lines += [
                "",
                f"## {title}",
                "",
                "| Pin | Type | Default | Meaning |",
                "|---|---|---|---|",
            ]
            lines += [
                f"| {pin.name} | {pin.type} | {pin.default} | {pin.comment.replace('|', '/')} |"
                for pin in pins
            ]
    rows = [_errors()[number] for number in block.errors if number in _errors()]
    if rows:
        lines += ["", "## Errors that its own code reports", ""]
        lines += ["| ErrorID | Name | Cause | Remedy |", "|---|---|---|---|"]
        lines += [
            f"| 16#{row['id']:04X} | {row['name']} | {row['cause']} | {row['remedy']} |"
            for row in rows
        ]
    lines += ["", "## Source", "", "```iecst", block.text.rstrip(), "```", ""]
    return "\n".join(lines)
