"""The served controllers in the terminal: a live table, or plain lines where it is none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from rcx_harness.output.throttle import Throttle
from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view

__all__ = ["Lines", "screen"]

_STYLES = {"green": "bold green", "red": "bold red", "off": "dim"}
_FULL_HEIGHT = 23  # lines of a controller with all its dedicated bits
_COMMANDS = 3
#: Lamps that are on, and off.
_LAMPS, _PLAIN = ("●", "○"), ("*", ".")


class Lines:
    """What has happened since the last look, a plain line each; of a flood only some (`Throttle`).

    Args:
        hosts: The controllers.
    """

    def __init__(self, hosts: Sequence[Host]) -> None:
        self._hosts = hosts
        self._before: list[dict[str, Any]] = [{} for _ in hosts]
        self._throttles = [Throttle() for _ in hosts]

    def new(self) -> list[str]:
        """Connections, LEDs, alarms, commands at their end, broken rules, skipped cycles."""
        lines = []
        for number, host in enumerate(self._hosts):
            before, now = self._before[number], _told(number, host)
            self._before[number] = now
            now_us = host.status.t_us
            head = f"{host.name} {now_us / 1e6:10.3f} s"
            throttle = self._throttles[number]
            for kind, texts in _changes(before, now).items():
                lines += [f"{head}  {text}" for text in throttle.let_pass(kind, texts, now_us)]
        return lines


def screen(hosts: Sequence[Host], height: int, *, ascii_only: bool = False) -> RenderableType:
    """The table for a terminal of `height` lines; with little room only the bits that are ON."""
    full = len(hosts) * _FULL_HEIGHT <= height
    lamps = _PLAIN if ascii_only else _LAMPS
    return Group(*(_panel(view(number, host), full, lamps) for number, host in enumerate(hosts)))


def _told(number: int, host: Host) -> dict[str, Any]:
    shown = view(number, host)
    ended = [one for one in host.status.commands if one.result]
    return {
        "connection": shown["connection"],
        "leds": ", ".join(f"{led['title']} {led['state']}" for led in shown["leds"]),
        "alarms": shown["alarms"],
        "commands": [(one.t_us, f"{one.request}: {one.result}") for one in ended],
        "violations": [(one.t_us, one.text) for one in host.status.violations],
        "skipped": shown["skipped"],
        "running": shown["running"],
    }


def _changes(before: dict[str, Any], now: dict[str, Any]) -> dict[str, list[str]]:
    """What is new, by its kind."""
    lines = {key: [now[key]] * (now[key] != before.get(key)) for key in ("connection", "leds")}
    known = before.get("alarms", [])
    lines["alarms"] = [
        *(f"alarm {text}" for text in now["alarms"] if text not in known),
        *(f"no longer: alarm {text}" for text in known if text not in now["alarms"]),
    ]
    for key, word in (("commands", "command"), ("violations", "rule broken")):
        old = before.get(key, [])
        lines[key] = [f"{word}: {one[1]}" for one in now[key] if one not in old]
    skipped = now["skipped"] - before.get("skipped", 0)
    cycles = "1 cycle" if skipped == 1 else f"{skipped} cycles"
    lines["skipped"] = [f"{cycles} of 5 ms skipped: this computer was busy"] * bool(skipped)
    ended = not now["running"] and before.get("running", True)
    lines["running"] = ["the controller's process has ended"] * ended
    return lines


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
