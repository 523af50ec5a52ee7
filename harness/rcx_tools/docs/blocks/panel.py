"""Generator of docs/reference/panel.html: a sheet with signals, codes, errors and alarms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import Any

from rcx_harness import spec
from rcx_harness.spec import Command, Signal
from rcx_tools.library import library
from structured_text.output.toml_files import load_toml

__all__ = ["panel_page"]

_STYLE = """\
@page { size: A4 portrait; margin: 9mm 10mm; }
* { box-sizing: border-box; }
body { font: 7.6pt/1.28 Arial, "DejaVu Sans", sans-serif; color: #000; background: #fff;
  margin: 0 auto; max-width: 190mm; }
h1 { font-size: 12pt; margin: 0 0 1mm; }
h2 { font-size: 8.6pt; margin: 2.2mm 0 0.6mm; border-bottom: 0.5pt solid #000; }
p { margin: 0 0 1mm; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: 0.1mm 1.2mm 0.1mm 0; }
th { font-weight: bold; }
tr + tr td { border-top: 0.25pt solid #999; }
td:first-child, code { white-space: nowrap; }
code { font: 7.4pt "DejaVu Sans Mono", Consolas, monospace; }
.fill { display: flex; gap: 6mm; margin: 1mm 0 1.5mm; }
.fill span { flex: 1; border-bottom: 0.5pt solid #000; padding-bottom: 3.4mm; }
.two { display: grid; grid-template-columns: 1fr 1fr; column-gap: 6mm; }
.codes { column-count: 4; column-gap: 4mm; }
.codes div { break-inside: avoid; display: flex; gap: 1.2mm; border-bottom: 0.25pt solid #ccc;
  line-height: 1.22; }
.codes b { display: block; margin-top: 0.8mm; break-after: avoid; }
.back { break-before: page; }
.small { font-size: 6.8pt; line-height: 1.2; }
.small code { font-size: 6.6pt; }
@media screen { body { padding: 8mm; font-size: 11px; } }
@media screen and (max-width: 700px) {
  body { padding: 3mm; }
  .two { grid-template-columns: 1fr; }
  .codes { column-count: 1; }
  .fill { flex-wrap: wrap; }
  .fill span { flex: 1 0 28%; }
}
@media screen and (prefers-color-scheme: dark) {
  html, body { background: #121a23; color: #dde5ee; }
  h2, .fill span { border-color: #dde5ee; }
}
"""

_STATUS = (
    ("0x0000", "ready: no command is being sent; the next command may be sent"),
    ("0x0100", "running: hold code and data"),
    ("0x0200", "normal end: take the response, then write code 0x0000"),
    ("0x4000", "abnormal end: alarm group in m+2, category in m+4; then code 0x0000"),
)
_AREA = (
    ("+0", "status", "command code"),
    ("+2 to +30", "response, or SOW(2) to SOW(15)", "command data, or SIW(2) to SIW(15)"),
    ("+32, +33", "dedicated outputs", "dedicated inputs"),
    ("+34 to +45", "SO2() to SO15(), octal", "SI2() to SI15(), octal"),
    ("+46, +47", "reserved", "reserved: 0"),
    ("+48 to +255", "SOW(24) to SOW(127), 256 bytes", "SIW(24) to SIW(127), 256 bytes"),
)
_CATEGORIES = {
    1: "Movement",
    2: "Definition, reference",
    3: "Arithmetic",
    4: "I/O ports",
    5: "Programs",
    6: "Data handling",
    7: "Utility",
    8: "Real time output",
}


def panel_page() -> str:
    """Return the sheet for the panel as HTML."""
    body = [*_front(), *_back()]
    return "\n".join(
        [
            "<!DOCTYPE html>",
            "<!-- generated from spec/ by `make docs`; do not edit -->",
            '<html lang="en">',
            '<head><meta charset="utf-8"><link rel="icon" href="data:,">',
            "<title>RCX3 over EtherNet/IP: panel sheet</title>",
            f"<style>\n{_STYLE}</style></head>",
            "<body>",
            *body,
            "</body>",
            "</html>",
            "",
        ]
    )


def _front() -> Iterator[str]:
    table = spec.signals()
    yield "<h1>YAMAHA RCX340/RCX320 over EtherNet/IP</h1>"
    yield (
        "<p>m is the first byte of the area that the PLC reads, n the first byte of the area that "
        "it writes. These signals are not a safety function; use the SAFETY connector.</p>"
    )
    blanks = ("Cell", "Controller's IP address", "m", "n", "Size", "RPI")
    yield f'<div class="fill">{"".join(f"<span>{escape(one)}</span>" for one in blanks)}</div>'
    yield "<h2>Controller to PLC: dedicated outputs</h2>"
    yield from _signals(table.output)
    yield "<h2>PLC to controller: dedicated inputs, at least 100 ms between two changes</h2>"
    yield from _signals(table.input)
    yield '<div class="two"><div>'
    yield "<h2>Areas</h2>"
    yield from _rows(("Byte", "from controller (m)", "to controller (n)"), _AREA)
    yield "</div><div>"
    yield "<h2>Remote status, word m</h2>"
    yield from _rows(("Status", "Meaning"), ((f"<code>{a}</code>", b) for a, b in _STATUS))
    yield "</div></div>"
    yield "<h2>Alarms that the EtherNet/IP manual names (4.202: a public list)</h2>"
    alarms = spec.alarms().values()
    rows = ((one.number, one.name, f"{one.cause} {one.remedy}") for one in alarms)
    yield from _rows(("Alarm", "Name", "Cause and remedy"), rows)


def _signals(signals: Sequence[Signal]) -> Iterator[str]:
    rows = ((one.signal, f"({one.address}).{one.bit}", one.title, one.meaning) for one in signals)
    yield from _rows(("Signal", "Address", "Name", "Meaning"), rows)


def _back() -> Iterator[str]:
    yield '<h2 class="back">Remote commands: word n, and the block that sends it</h2>'
    yield "<p>R is the robot: 0 or 1 to 4. FB_RemoteCommand sends any command as words.</p>"
    yield '<div class="codes small">'
    category = None
    for command in spec.commands().values():
        if command.category != category and command.category:
            category = command.category
            yield f"<b>{escape(_CATEGORIES[category])}</b>"
        yield f"<div><code>{command.shown[2:]}</code><span>{escape(_sender(command))}</span></div>"
    yield "</div>"
    yield "<h2>ErrorID of the blocks</h2>"
    errors = load_toml(spec.folder() / "errors.toml")["error"]
    yield '<div class="small">'
    yield from _rows(("ErrorID", "Name", "Remedy"), map(_error, errors))
    yield "</div>"
    yield "<p>docs/reference/errors.md has the causes in full; the page of a block in "
    yield "docs/reference/blocks lists the errors of this block.</p>"


def _sender(command: Command) -> str:
    """Return the block that sends a command. If it sends several commands, add the command."""
    if not command.code:
        return "status reset (FB_WriteArea)"
    block = next(one for one in library().blocks.values() if command in one.commands)
    return f"{block.name}: {command.name}" if len(block.commands) > 1 else block.name


def _error(one: dict[str, Any]) -> tuple[str, ...]:
    """Return code, name and remedy of an error."""
    return (f"<code>16#{one['id']:04X}</code>", one["name"], one["remedy"])


def _rows(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of an HTML table. A cell that begins with a tag is already HTML."""
    yield f"<table><tr>{''.join(f'<th>{escape(one)}</th>' for one in head)}</tr>"
    for row in rows:
        cells = (one if one.startswith("<") else escape(one) for one in row)
        yield f"<tr>{''.join(f'<td>{one}</td>' for one in cells)}</tr>"
    yield "</table>"
