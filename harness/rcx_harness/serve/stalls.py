"""Warnings about processes of the served controllers that give no sign of life."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness.serve.host import Host
from rcx_harness.serve.watchdog import LIMIT_US, Watchdog

__all__ = ["Stalls"]


class Stalls:
    """The reports about controller processes that stop responding or respond again."""

    def __init__(self, hosts: Sequence[Host]) -> None:
        self._hosts = hosts
        self._watchdogs = [Watchdog() for _ in hosts]
        # by controller: number of reports, and time of the last report
        self._heard = [(0, 0) for _ in hosts]
        self._stalled: list[tuple[str, ...]] = [() for _ in hosts]

    def new(self, now_us: int) -> list[str]:
        """Return a line for each change since the last call."""
        lines = []
        for number, host in enumerate(self._hosts):
            if host.reports != self._heard[number][0]:
                self._heard[number] = (host.reports, now_us)
            watchdog = self._watchdogs[number]
            since_us = watchdog.silent_since_us or 0
            found = watchdog.look(self._heard[number][1], now_us)
            host.silent = watchdog.silent_since_us is not None
            if found is Watchdog.Finding.SILENT:
                lines.append(_still(host, "its process"))
            elif found is Watchdog.Finding.BACK:
                passed = f"after {(now_us - since_us) / 1e6:.1f} s"
                lines.append(f"controller {host.name}: its process continues {passed}")
            before, now = self._stalled[number], host.status.stalled
            self._stalled[number] = now
            lines += [_still(host, part) for part in now if part not in before]
            lines += [
                f"controller {host.name}: {part} continues" for part in before if part not in now
            ]
        return lines


def _still(host: Host, part: str) -> str:
    seconds = f"{LIMIT_US / 1e6:g} s"
    return (
        f"controller {host.name}: {part} has given no sign of life for {seconds}; it was stopped, "
        "or this computer is too busy"
    )
