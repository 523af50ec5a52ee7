"""The comparison of requests with executions: once each, or at most once after some errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rcx_harness.spec.wire import ABNORMAL_END, NORMAL_END
from rcx_tools.evidence.campaign.station import Execution
from structured_text.output.units import format_us

__all__ = ["Comparison", "Request", "hexed"]

#: ErrorIDs after which the command may have been executed or not: link lost, CPU_OK lost, no end,
#: turn lost, command lost.
_UNKNOWN = (0x8001, 0x8002, 0x8011, 0x8013, 0x8014)
_ABNORMAL = 0x8020


@dataclass
class Request:
    """A request: one rising edge of Execute (or Enable) that a command block has accepted.

    Attributes:
        block: Name of the instance.
        words: The telegram that it must send, n to n + 30.
        start_us: Time of the rising edge.
        level: Whether the block has Enable. The end of such a block does not show whether the
            command was executed.
        end_us: Time at which the block showed the end. None if there was no end.
        error_id: ErrorID at the end; 0 means Done.
        shown: Outputs of the block that contain the response, with their values at the end.
    """

    block: str
    words: tuple[int, ...]
    start_us: int
    level: bool = False
    end_us: int | None = None
    error_id: int = 0
    shown: dict[str, Any] | None = None
    alarm: tuple[int, int] = (0, 0)

    @property
    def certain(self) -> bool:
        """Return whether the command was certainly executed: Done, or an abnormal end."""
        ended = self.end_us is not None and not self.level
        return ended and self.error_id in (0, _ABNORMAL)

    @property
    def possible(self) -> bool:
        """Return whether the command may have been executed."""
        return self.end_us is None or self.level or self.error_id in _UNKNOWN

    def __str__(self) -> str:
        end = "no end"
        if self.end_us is not None:
            what = f"16#{self.error_id:04X}" if self.error_id else "Done"
            end = f"{what} at {format_us(self.end_us)}"
        return f"{self.block} of {format_us(self.start_us)} ({end})"


class Comparison:
    """Comparison of requests with executions.

    Args:
        shown: Function that returns the expected outputs of a block for the words m to m + 30.
        found: Function that is called with each finding: its kind, and a sentence.
    """

    def __init__(
        self,
        shown: Callable[[str, Sequence[int]], Mapping[str, Any]],
        found: Callable[[str, str], None],
    ) -> None:
        self._shown, self._found = shown, found

    def of(self, requests: Sequence[Request], executions: Sequence[Execution]) -> None:
        """Compare all requests of a period with all its executions."""
        # Certain requests are matched first, because each needs a particular execution: the last
        # execution with the same telegram before the end of the request. Each uncertain request may
        # then match one of the remaining executions. An execution without a request was either
        # repeated or never requested.
        left = list(executions)
        for request in requests:
            if request.certain:
                self._match_certain(request, left)
        unsure = [one for one in requests if one.possible and not one.certain]
        for execution in left:
            owner = next(
                (
                    one
                    for one in unsure
                    if one.words == execution.words and one.start_us <= execution.t_us
                ),
                None,
            )
            if owner is None:
                self._stray(execution, requests)
            else:
                unsure.remove(owner)

    def _match_certain(self, request: Request, left: list[Execution]) -> None:
        assert request.end_us is not None
        found = [
            one
            for one in left
            if one.words == request.words and request.start_us <= one.t_us <= request.end_us
        ]
        if not found:
            self._found("not executed", f"{request} was never executed: {hexed(request.words)}")
            return
        own = found[-1]  # only one command runs at a time, so the last execution belongs to it
        left.remove(own)
        status = NORMAL_END if request.error_id == 0 else ABNORMAL_END
        if own.end is None or own.end[0] != status:
            shown = "nothing" if own.end is None else f"16#{own.end[0]:04X}"
            self._found("wrong end", f"{request}, but the controller answered {shown}")
        elif request.error_id:
            if request.alarm != own.end[1:3]:
                text = f"{request} shows the alarm {request.alarm}, not {own.end[1:3]}"
                self._found("wrong data", text)
        elif request.shown != (wanted := self._shown(request.block, own.end)):
            self._found("wrong data", f"{request} shows {request.shown}, not {wanted}")

    def _stray(self, execution: Execution, requests: Sequence[Request]) -> None:
        same = [one for one in requests if one.words == execution.words]
        kind = "executed twice" if any(one.certain for one in same) else "executed unasked"
        asked = f": {', '.join(map(str, same[:3]))}" if same else ""
        text = f"{hexed(execution.words)} at {format_us(execution.t_us)}{asked}"
        self._found(kind, text)


def hexed(words: Sequence[int]) -> str:
    """Return words as hexadecimal text, without zero words at the end."""
    last = max((k for k, word in enumerate(words) if word), default=0)
    return " ".join(f"{word:04X}" for word in words[: last + 1])
