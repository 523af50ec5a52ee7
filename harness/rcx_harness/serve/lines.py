"""The log of served controllers as plain lines, for output that is not a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rcx_harness.serve.host import Host
from rcx_harness.serve.status import Event
from structured_text.output.throttle import Throttle

__all__ = ["Lines"]

#: Maximum number of different sentences that are remembered. A refused master tries again every few
#: seconds, so a sentence is printed once and then only counted.
_REFUSALS = 50


@dataclass
class _Log:
    """The state of the log of one controller."""

    throttle: Throttle = field(default_factory=Throttle)
    refusals: Throttle = field(default_factory=lambda: Throttle(burst=1))
    refused: set[str] = field(default_factory=set)
    ended: bool = False


class Lines:
    """The log of all controllers: a line for each event, limited by `Throttle`."""

    def __init__(self, hosts: Sequence[Host]) -> None:
        self._logs = [(host, _Log()) for host in hosts]

    def new(self) -> list[str]:
        """Return a line for each new event, with its own time, in the order of the events."""
        lines = []
        for host, log in self._logs:
            while host.events:
                event = host.events.popleft()
                lines += [_line(host, event.t_us, text) for text in _passed(log, event)]
            now_us = host.status.t_us
            held = log.throttle.flush(now_us) + log.refusals.flush(now_us)
            lines += [_line(host, now_us, text) for text in held]
            if host.ended.is_set() and not log.ended:
                log.ended = True
                lines.append(_line(host, now_us, "the controller's process has ended"))
        return lines


def _passed(log: _Log, event: Event) -> list[str]:
    if event.kind != "refused":
        return log.throttle.let_pass(event.kind, [event.text], event.t_us)
    if len(log.refused) < _REFUSALS:
        log.refused.add(event.text)
    kind = event.text if event.text in log.refused else event.kind
    return log.refusals.let_pass(kind, [event.text], event.t_us)


def _line(host: Host, t_us: int, text: str) -> str:
    return f"{host.name} {t_us / 1e6:10.3f} s  {text}"
