"""Write or check the generated files in docs/ and plc/lib, and command outputs in other pages.

`python -m rcx_tools.docs.pages` writes the files. `python -m rcx_tools.docs.pages --check` only
compares them, and exits with 1 if a file is not current. The command works on the repository, not
on an installed package.
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rcx_harness import spec
from rcx_harness.cli.app import COMMANDS
from rcx_tools.docs import blocks, examples, fidelity
from rcx_tools.docs.blocks.panel import panel_page
from rcx_tools.docs.cli import command_page, commands_index
from rcx_tools.docs.commands import commands_page
from rcx_tools.docs.diagnosis import diagnosis_page
from rcx_tools.docs.dialects import language_page
from rcx_tools.docs.editor_facts import editor_facts
from rcx_tools.docs.engines import engines_page
from rcx_tools.docs.moving import moving_svg
from rcx_tools.docs.probes import probes_page
from rcx_tools.docs.processes import process_chart, processes
from rcx_tools.docs.processes_svg import process_svg
from rcx_tools.docs.robot_language import robot_language_page
from rcx_tools.docs.robots import robots_page
from rcx_tools.docs.rooms import rooms_svg
from rcx_tools.docs.words import words_page
from rcx_tools.evidence.page import verification_page
from rcx_tools.library import files as library_files
from rcx_tools.library.alarm_texts import text_files
from rcx_tools.library.signals import signal_files
from rcx_tools.library.version import version_files
from structured_text.output.programs import environment
from structured_text.output.toml_files import load_toml

__all__ = ["PATIENCE_S", "Header", "every_page", "headers", "main", "pages"]

ROOT = Path(__file__).resolve().parents[3]

#: Interval of the progress reports [s], and number of pages between two reports.
PATIENCE_S, _STEP = 2.0, 50

_OUTPUT = re.compile(
    r"^(<!-- (?P<kind>output of|file): (?P<what>.+?) -->\n```[a-z]*\n)(?:(?!```).*\n)*(```)$",
    re.MULTILINE,
)
#: Handwritten pages in which only command outputs and files between fences are generated.
_PASTED = (
    "README.md",
    *(
        f"docs/tutorial/{part}.md"
        for part in ("1-first-program", "2-break-a-rule", "3-first-test", "4-real-robot")
    ),
)


@dataclass(frozen=True)
class Header:
    """The contents of the comment at the head of an ST file."""

    file: Path
    name: str
    purpose: str
    section: str
    tests: tuple[str, ...]

    @property
    def folder(self) -> str:
        """Return the folder of the file as a path below plc/lib."""
        return self.file.parent.relative_to(ROOT / "plc/lib").as_posix()


def headers() -> list[Header]:
    """Return the heads of all files in plc/lib, folder by folder."""
    return [_header(file) for file in sorted((ROOT / "plc/lib").rglob("*.st"))]


def _header(file: Path) -> Header:
    comment = file.read_text(encoding="utf-8").partition("*)")[0]
    lines = [re.sub(r"^\s*\(?\*", "", line).strip() for line in comment.splitlines()]
    first = lines.index("", 1) if "" in lines[1:] else len(lines)
    name, _, purpose = " ".join(lines[:first]).strip().partition(": ")
    section = re.search(r" \(((?:remote command )?(?:chapter|guide).*)\)(?=[.:])", purpose)
    if section:
        purpose = purpose.replace(section[0], "", 1)
    tests = re.findall(r"tests/[\w/]+\.py", comment)
    named = section or re.search(r"\(((?:guide|chapter) [\d.]+)\)", purpose)
    purpose = re.sub(r" \(not in the manual[^)]*\)", "", purpose)
    return Header(file, name, purpose, named[1] if named else "", tuple(tests))


def _link(path: str | Path) -> str:
    relative = Path(path).resolve().relative_to(ROOT) if Path(path).is_absolute() else Path(path)
    return f"[{relative.name}](../../{relative.as_posix()})"


def _page(title: str, source: str, body: Iterator[str]) -> str:
    head = f"<!-- generated from {source} by `make docs`; do not edit -->\n\n# {title}\n\n"
    return head + "\n".join(body) + "\n"


def _blocks() -> Iterator[str]:
    yield "The page of a block shows its pins, an example with ladder and chart, its errors and"
    yield "related blocks. Each block is one source file, which begins with a description of it."
    yield "[panel.html](panel.html) is a printed sheet for the panel, with all dedicated bits,"
    yield "codes and errors. [internal-blocks.md](internal-blocks.md) lists blocks that only other"
    yield "blocks call.\n"
    yield "In the column *Manual*, `chapter` is a chapter of the YAMAHA network board EtherNet/IP"
    yield "user's manual for RCX340 and RCX320, Ver. 1.31, and `guide` is a section of the remote"
    yield "command guide in the same document. `-` means: not in the manual.\n"
    yield "## I want to ...\n\n| Task | Blocks |\n|---|---|"
    for task, names in blocks.tasks().items():
        yield f"| {task} | {', '.join(map(_page_of, names))} |"
    yield from _table(internal=False)


def _internal_blocks() -> Iterator[str]:
    yield "Programs do not call these blocks, functions and types. They are the parts of the blocks"
    yield "in [blocks.md](blocks.md)."
    yield from _table(internal=True)


def _is_internal(head: Header) -> bool:
    return head.folder == "core" or head.name.startswith(("FB_Rcx", "FC_Rcx"))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _table(*, internal: bool) -> Iterator[str]:
    columns = ("Block", "Source", "What it does", "Manual", "Tests", "Chart")
    shown = [head for head in headers() if _is_internal(head) == internal]
    folders = sorted({head.folder for head in shown}, key=_place)
    for folder in folders:
        yield f"\n## {folder}\n\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}"
        for head in shown:
            if head.folder == folder:
                tests = ", ".join(_link(test) for test in head.tests)
                source = f"[ST](../../{head.file.relative_to(ROOT).as_posix()})"
                cells = (
                    _page_of(head.name),
                    source,
                    _capital(head.purpose),
                    head.section or "-",
                    tests,
                )
                yield f"| {' | '.join((*cells, _charts(head.name)))} |"


_FOLDERS = (
    *("area", "sequence", "command", "motion", "position", "points", "operator"),
    *("diagnosis", "core"),
)


def _place(folder: str) -> tuple[int, str]:
    """Return the sort key of a folder.

    Listed folders come first, then other folders, then the types.
    """
    top = folder.partition("/")[0]
    if top == "types":
        return len(_FOLDERS) + 1, folder
    return (_FOLDERS.index(top) if top in _FOLDERS else len(_FOLDERS)), folder


def _page_of(name: str) -> str:
    """Return the name of a block or type, with a link if it has a page."""
    if name.startswith("FC_"):
        return f"[{name}](blocks/functions.md#{name.lower()})"
    return f"[{name}](blocks/{name}.md)" if name.startswith("FB_") else name


def _charts(block: str) -> str:
    """Return links to the charts that show a block."""
    shown = [one for one in processes().values() if block in one.blocks]
    return ", ".join(
        f"[{one.title}](../explanation/processes.md#{_anchor(one.title)})" for one in shown
    )


def _anchor(title: str) -> str:
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


_PROCESSES = """\
This page shows which signals the library's blocks exchange with the controller, and in which
order: the timing charts of the manual's chapter 5, link loss, and remote commands. The charts are
drawn from runs with the virtual controller; a test draws them again and compares.

**Times of the PLC and of the controller.** The library decides when the PLC changes an input: at
least 100 ms + `Margin` after the last change, with any controller. The manual does not say how long
the controller takes to answer. The times shown are those of the virtual controller, see
[fidelity.md](fidelity.md); with a real controller only the order is the same.

To run a process yourself and change it:

    rcx run docs/explanation/charts/servo_on.st --stimulus docs/explanation/charts/servo_on.toml
    --for 1s

| Process | Manual | Blocks |
|---|---|---|"""


#: Endings of the file names of program and stimulus of a process.
_FILES = (".st", ".toml")


def _processes() -> Iterator[str]:
    heads = {head.name: head for head in headers()}
    yield _PROCESSES
    for process in processes().values():
        blocks = ", ".join(_link(heads[name].file) for name in process.blocks)
        yield f"| [{process.title}](#{_anchor(process.title)}) | {process.section} | {blocks} |"
    for process in processes().values():
        blocks = ", ".join(_link(heads[name].file) for name in process.blocks)
        tests = dict.fromkeys(test for name in process.blocks for test in heads[name].tests)
        yield f"\n## {process.title}\n\n{process.about.strip()}\n"
        yield f"![Timing chart: {process.title}](charts/{process.name}.svg)\n"
        yield "| Step | Change | What happens | at [ms] | since last [ms] |"
        yield "|---|---|---|---|---|"
        for step in process_chart(process.name).steps:
            cells = (step.number, step.change, step.text, step.at, step.since_last)
            yield f"| {' | '.join(map(str, cells))} |"
        yield f"\n```iecst\n{_body(process.program)}\n```\n"
        files = ", ".join(f"[{process.name}{end}](charts/{process.name}{end})" for end in _FILES)
        order = _link("tests/tools/docs/test_processes.py")
        yield f"- Blocks: {blocks}\n- Complete program, and its stimulus: {files}"
        yield f"- Tests: {', '.join(map(_link, tests))}; order and intervals: {order}"
        yield f"- Manual: {process.section}"


def _body(program: Path) -> str:
    """Return the statements of a program, without its declarations."""
    text = program.read_text(encoding="utf-8")
    body = text.rpartition("END_VAR\n")[2].partition("END_PROGRAM")[0].strip("\n")
    return "\n".join(line.removeprefix("  ") for line in body.splitlines())


def _errors() -> Iterator[str]:
    yield "`ErrorID` of the blocks: codes of this library. Alarms of the controller itself are"
    yield "shown as `AlarmGroup` and `AlarmCategory` and explained in the controller's manual.\n"
    yield "| ErrorID | Name | Cause | Remedy |\n|---|---|---|---|"
    for error in load_toml(spec.folder() / "errors.toml")["error"]:
        code = f"16#{error['id']:04X}"
        yield f"| `{code}` | {error['name']} | {error['cause']} | {error['remedy']} |"


def _signals() -> Iterator[str]:
    table = spec.signals()
    yield "The dedicated bits; bits and bytes that are not listed are reserved. m is the first byte"
    yield "of the area that the master reads, n the first byte of the area that it writes."
    for title, rows in (("Controller to PLC", table.output), ("PLC to controller", table.input)):
        yield f"\n## {title}\n\n| Signal | Address | Field | Meaning |\n|---|---|---|---|"
        for row in rows:
            yield f"| {row.signal} | ({row.address}).{row.bit} | `{row.name}` | {row.meaning} |"


def _pasted(path: str) -> str:
    """Return a page with current command outputs, and with the current texts of shown files."""

    def paste(match: re.Match[str]) -> str:
        if match["kind"] == "file":
            shown = (ROOT / match["what"]).read_text(encoding="utf-8").rstrip("\n")
        else:
            shown = _run(match["what"])
        return f"{match[1]}{shown}\n{match[4]}"

    return _OUTPUT.sub(paste, (ROOT / path).read_text(encoding="utf-8"))


def _run(command: str) -> str:
    """Run a command like a new user without matiec, and return its output."""
    hidden = ("RCX_MATIEC", "MAKEFLAGS", "MAKELEVEL", "MFLAGS")
    path = f"{ROOT / '.venv/bin'}:/usr/bin:/bin"
    clean = environment(without=hidden, PATH=path, COLUMNS="100", TERM="dumb")
    done = subprocess.run(
        command, shell=True, cwd=ROOT, env=clean, capture_output=True, text=True, check=False
    )
    # Exit code 1 is also a result. Stderr is left out, because on a busy machine it contains
    # progress messages.
    return (done.stdout + (done.stderr if done.returncode > 1 else "")).strip("\n")


def every_page() -> dict[str, Callable[[], str]]:
    """Return the generators of all files, by path in the repository."""
    return {**pages(), **blocks.files(), **examples.files()}


def pages() -> dict[str, Callable[[], str]]:
    """Return all generators except the slow ones: block pages and charts of the examples."""
    return {
        **library_files(),
        **text_files(),
        **signal_files(),
        **version_files(),
        "docs/reference/blocks.md": lambda: _page("Blocks", "the heads of plc/lib", _blocks()),
        "docs/reference/internal-blocks.md": lambda: _page(
            "Internal blocks", "the heads of plc/lib", _internal_blocks()
        ),
        "docs/reference/cli.md": lambda: _page("Command line", _CLI, commands_index()),
        **{f"docs/reference/cli/{name}.md": partial(_command, name) for name in COMMANDS},
        "docs/reference/commands.md": lambda: _page(
            "Remote commands", "spec/remote_commands.toml and spec/blocks.toml", commands_page()
        ),
        "docs/how-to/diagnosis.md": diagnosis_page,
        "harness/rcx_harness/editor/blocks.json": editor_facts,
        "docs/reference/engines.md": engines_page,
        "docs/reference/errors.md": lambda: _page("Errors", "spec/errors.toml", _errors()),
        "docs/reference/export-words.md": lambda: _page(
            "What each tool's Structured Text has",
            "harness/structured_text/export/words",
            words_page(),
        ),
        "docs/reference/language.md": lambda: language_page(ROOT / "docs/reference/language.md"),
        "docs/first.svg": moving_svg,
        "docs/explanation/fidelity.md": fidelity.fidelity_page,
        "docs/reference/panel.html": panel_page,
        "docs/reference/probes.md": probes_page,
        "docs/reference/robots.md": robots_page,
        "docs/reference/robot-language.md": robot_language_page,
        "docs/explanation/rooms.svg": partial(rooms_svg, "rcx_harness"),
        "docs/explanation/rooms_toolkit.svg": partial(rooms_svg, "structured_text"),
        "docs/explanation/processes.md": lambda: _page(
            "Processes and their timing charts", "docs/explanation/charts", _processes()
        ),
        "docs/explanation/verification.md": verification_page,
        "docs/reference/signals.md": lambda: _page(
            "Dedicated signals", "spec/signals.toml", _signals()
        ),
        **{f"docs/explanation/charts/{name}.svg": partial(_chart, name) for name in processes()},
        **{path: partial(_pasted, path) for path in _PASTED},
    }


_CLI = "the options in harness/rcx_harness/cli"


def _command(name: str) -> str:
    return _page(f"rcx {name}", _CLI, command_page(name))


def _chart(name: str) -> str:
    return process_svg(process_chart(name))


def main(arguments: list[str]) -> int:
    """Write the pages, or compare them with `--check`; return the exit code."""
    stale = []
    begin = time.monotonic()
    every = every_page()
    for number, (path, render) in enumerate(every.items(), 1):
        if time.monotonic() - begin > PATIENCE_S and number % _STEP == 0:
            print(f"{number}/{len(every)} pages, {path}", file=sys.stderr)
        file, text = ROOT / path, render().encode()
        if file.exists() and file.read_bytes() == text:
            continue
        stale.append(path)
        if "--check" not in arguments:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(text)
            print(f"wrote {path}")
    for path in blocks.leftovers(ROOT):
        stale.append(path)
        if "--check" not in arguments:
            (ROOT / path).unlink()
            print(f"removed {path}")
    if stale and "--check" in arguments:
        print(f"not current: {', '.join(stale)}; run `make docs`", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
