"""Write the generated pages of docs/ and the output blocks of README.md, or check them.

`python -m rcx_harness.docs` writes, `python -m rcx_harness.docs --check` only compares (exit 1
where a page is not current). It works on the repository, not on an installed package.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rcx_harness import spec
from rcx_harness.robot import fidelity

__all__ = ["Header", "headers", "main", "pages"]

ROOT = Path(__file__).resolve().parents[2]
_OUTPUT = re.compile(r"(<!-- output of: (?P<command>.+?) -->\n```[a-z]*\n).*?(\n```)", re.DOTALL)


@dataclass(frozen=True)
class Header:
    """What the comment at the head of an ST file says."""

    file: Path
    name: str
    purpose: str
    section: str
    tests: tuple[str, ...]


def headers() -> list[Header]:
    """The heads of all files in plc/lib, folder by folder."""
    return [_header(file) for file in sorted((ROOT / "plc/lib").rglob("*.st"))]


def _header(file: Path) -> Header:
    comment = file.read_text(encoding="utf-8").partition("*)")[0]
    lines = [line.strip(" (*") for line in comment.splitlines()]
    first = lines.index("", 1) if "" in lines[1:] else len(lines)
    name, _, purpose = " ".join(lines[:first]).strip().partition(": ")
    section = re.search(r" \(((?:remote command )?(?:chapter|guide).*)\)(?=[.:])", purpose)
    if section:
        purpose = purpose.replace(section[0], "", 1)
    tests = re.findall(r"tests/[\w/]+\.py", comment)
    return Header(file, name, purpose, section[1] if section else "", tuple(tests))


def _link(path: str | Path) -> str:
    relative = Path(path).resolve().relative_to(ROOT) if Path(path).is_absolute() else Path(path)
    return f"[{relative.name}](../{relative.as_posix()})"


def _page(title: str, source: str, body: Iterator[str]) -> str:
    head = f"<!-- generated from {source} by `make docs`; do not edit -->\n\n# {title}\n\n"
    return head + "\n".join(body) + "\n"


def _blocks() -> Iterator[str]:
    yield "One file per block; the interface in its head is the documentation."
    for folder in ("types", "area", "sequence", "command"):
        yield f"\n## {folder}\n\n| Block | What it does | Manual | Tests |\n|---|---|---|---|"
        for head in headers():
            if head.file.parent.name == folder:
                tests = ", ".join(_link(test) for test in head.tests)
                yield f"| {_link(head.file)} | {head.purpose} | {head.section} | {tests} |"


def _errors() -> Iterator[str]:
    yield "`ErrorID` of the blocks: the library's own codes. Alarms of the controller itself are"
    yield "shown as `AlarmGroup` and `AlarmCategory` and explained in the controller's manual.\n"
    yield "| ErrorID | Name | Cause | Remedy |\n|---|---|---|---|"
    for error in spec.load_toml(spec.folder() / "errors.toml")["error"]:
        code = f"16#{error['id']:04X}"
        yield f"| `{code}` | {error['name']} | {error['cause']} | {error['remedy']} |"


def _signals() -> Iterator[str]:
    table = spec.signals()
    yield "The dedicated bits; bits and bytes that are not listed are reserved. m is the first byte"
    yield "of the area that the master reads, n of the one it writes."
    for title, rows in (("Controller to PLC", table.output), ("PLC to controller", table.input)):
        yield f"\n## {title}\n\n| Signal | Address | Field | Meaning |\n|---|---|---|---|"
        for row in rows:
            yield f"| {row.signal} | ({row.address}).{row.bit} | `{row.name}` | {row.meaning} |"


def _commands() -> Iterator[str]:
    yield "The remote commands that the virtual controller executes today. `FB_RemoteCommand` sends"
    yield "these and any other code; R is the robot number, 0 to 4.\n"
    yield "| Code | Command | Block | Section |\n|---|---|---|---|"
    for command in spec.commands().values():
        code = f"0x{'R' if command.robot else '0'}{command.code:03X}"
        block = _link("plc/lib/command/FB_RemoteCommand.st")
        if command.code == 0:
            block = _link("plc/lib/area/FB_Handshake.st")
        yield f"| `{code}` | {command.title} | {block} | guide {command.section} |"


def _readme() -> str:
    text = (ROOT / "README.md").read_text(encoding="utf-8")

    def paste(match: re.Match[str]) -> str:
        return match[1] + _run(match["command"]) + match[3]

    return _OUTPUT.sub(paste, text)


def _run(command: str) -> str:
    """Output of a command as a newcomer without matiec sees it."""
    hidden = ("RCX_MATIEC", "MAKEFLAGS", "MAKELEVEL", "MFLAGS")
    clean = {key: value for key, value in os.environ.items() if key not in hidden}
    clean |= {"PATH": f"{ROOT / '.venv/bin'}:/usr/bin:/bin", "COLUMNS": "100", "TERM": "dumb"}
    done = subprocess.run(
        command, shell=True, cwd=ROOT, env=clean, capture_output=True, text=True, check=False
    )
    return (done.stdout + done.stderr).strip("\n")


def pages() -> dict[str, Callable[[], str]]:
    """Every generated file by its path in the repository, with what writes it."""
    return {
        "docs/blocks.md": lambda: _page("Blocks", "the heads of plc/lib", _blocks()),
        "docs/commands.md": lambda: _page(
            "Remote commands", "spec/remote_commands.toml", _commands()
        ),
        "docs/errors.md": lambda: _page("Errors", "spec/errors.toml", _errors()),
        "docs/fidelity.md": fidelity.fidelity_page,
        "docs/signals.md": lambda: _page("Dedicated signals", "spec/signals.toml", _signals()),
        "README.md": _readme,
    }


def main(arguments: list[str]) -> int:
    """Write the pages, or with `--check` compare them; return the exit code."""
    stale = []
    for path, render in pages().items():
        file, text = ROOT / path, render()
        if file.exists() and file.read_text(encoding="utf-8") == text:
            continue
        stale.append(path)
        if "--check" not in arguments:
            file.write_text(text, encoding="utf-8")
            print(f"wrote {path}")
    if stale and "--check" in arguments:
        print(f"not current: {', '.join(stale)}; run `make docs`", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
