"""The served controllers where no terminal is: plain lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcx_harness.output.throttle import Throttle
from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view

__all__ = ["Lines"]


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
