"""The served controllers in a terminal: a live table."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any, NoReturn

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view
from structured_text.output.console import draws

__all__ = ["screen", "show"]

_STYLES = {"green": "bold green", "red": "bold red", "off": "dim"}
_FULL_HEIGHT = 23  # number of lines of a controller with all its dedicated bits
_COMMANDS = 3
#: Characters for lamps that are on, and off.
_LAMPS, _PLAIN = ("●", "○"), ("*", ".")


async def show(hosts: Sequence[Host], every_s: float) -> NoReturn:
    """Show the table on standard output, and update it every `every_s` seconds."""
    console = Console()
    plain = not draws(console.encoding)
    with Live(console=console, auto_refresh=False, screen=False) as live:
        while True:
            live.update(screen(hosts, console.height - 4, ascii_only=plain), refresh=True)
            await asyncio.sleep(every_s)


def screen(hosts: Sequence[Host], height: int, *, ascii_only: bool = False) -> RenderableType:
    """Return the table for `height` lines; if there are few, only bits that are ON are shown."""
    full = len(hosts) * _FULL_HEIGHT <= height
    lamps = _PLAIN if ascii_only else _LAMPS
    return Group(*(_panel(view(number, host), full, lamps) for number, host in enumerate(hosts)))


def _panel(shown: dict[str, Any], full: bool, lamps: tuple[str, str]) -> Panel:
    head = Table.grid(padding=(0, 2))
    head.add_column(style="dim", no_wrap=True)
    head.add_column(ratio=1)
    head.add_row("connection", Text(shown["connection"]))
    for led in shown["leds"]:
        style = _STYLES[led["state"].split(",")[0].split()[0]]
        head.add_row(
            led["title"],
            Text.assemble((f"{lamps[0]} ", style), f"{led['state']} ({led['meaning']})"),
        )
    packets = shown["packets"]
    head.add_row(
        "figures",
        f"packets {packets['received']} in, {packets['sent']} out; "
        f"cycles {shown['cycles']}, skipped {shown['skipped']}; "
        f"commands {shown['executed']}; broken rules {shown['violation_count']}",
    )
    if packets["dropped"]:
        head.add_row("dropped", Text(packets["dropped"], "yellow"))
    if shown["alarms"]:
        head.add_row("alarms", Text(", ".join(shown["alarms"]), "bold red"))
    for one in shown["commands"][: _COMMANDS if full else 1]:
        head.add_row("command", Text(f"{one['request']}: {one['result'] or 'running'}"))
    for one in shown["violations"][:1]:
        head.add_row("rule broken", Text(f"{one['time']}: {one['text']}", "yellow"))
    bits = _all_bits(shown, lamps) if full else _bits_on(shown)
    running = "" if shown["running"] else " (ended)"
    title = f"{shown['name']}, {shown['size']} bytes{running}"
    return Panel(Group(head, bits), title=title, title_align="left")


def _all_bits(shown: dict[str, Any], lamps: tuple[str, str]) -> RenderableType:
    grid = Table.grid(padding=(0, 4))
    rows = max(len(shown["inputs"]), len(shown["outputs"]))
    for row in range(rows):
        cells = [side[row] if row < len(side) else None for side in _sides(shown)]
        grid.add_row(*(_bit(one, lamps) if one else Text() for one in cells))
    return grid


def _bits_on(shown: dict[str, Any]) -> RenderableType:
    return Text(" ".join(one["signal"] for side in _sides(shown) for one in side if one["on"]))


def _sides(shown: dict[str, Any]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    return shown["inputs"], shown["outputs"]


def _bit(one: dict[str, Any], lamps: tuple[str, str]) -> Text:
    lamp, style = (lamps[0], "bold") if one["on"] else (lamps[1], "dim")
    return Text(f"{lamp} {one['signal']} {one['title']}", style)
