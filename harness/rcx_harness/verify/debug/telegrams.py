"""The last telegrams of a controller, as its areas show them, scan by scan."""

from __future__ import annotations

import struct
from typing import NamedTuple

from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.telegram import WORDS
from rcx_harness.spec.wire import ENDS, READY

__all__ = ["Telegram", "Telegrams", "words_of"]

#: Telegrams that are kept.
_KEPT = 8
#: No code.
_NONE = b"\0\0"


def words_of(area: bytes) -> tuple[int, ...]:
    """The 16 words of a telegram in an area."""
    return struct.unpack(f"<{WORDS}H", area[: 2 * WORDS])


class Telegram(NamedTuple):
    """A remote command: when its code went out, its words, and what came back so far.

    `ended_us` is -1 until its end has come; `answer` has the words from m on at that time.
    """

    t_us: int
    request: tuple[int, ...]
    answer: tuple[int, ...] = (READY,) * WORDS
    ended_us: int = -1

    @property
    def request_text(self) -> str:
        """What it asks for, in plain language."""
        return request_text(self.request)

    @property
    def answer_text(self) -> str:
        """How it ended, or what it does."""
        if self.answer[0] == READY:
            return "not answered yet"
        return response_text(self.request[0], self.answer)


class Telegrams:
    """What went over one controller's areas last.

    Attributes:
        so: The area that the PLC has read.
        si: The area that it has written.
        last: The last telegrams, the newest first.
    """

    def __init__(self, size: int) -> None:
        self.so = self.si = bytes(size)
        self.last: tuple[Telegram, ...] = ()

    def take(self, t_us: int, so: bytes, si: bytes) -> None:
        """The areas of the next scan."""
        before, self.so, self.si = self.si[:2], so, si
        code, status = si[:2], int.from_bytes(so[:2], "little")
        if before != _NONE and self.last and self.last[0].ended_us < 0:
            ended = t_us if status in ENDS else -1
            newest = self.last[0]._replace(answer=words_of(so), ended_us=ended)
            self.last = (newest, *self.last[1:])
        if code not in (before, _NONE):
            self.last = (Telegram(t_us, words_of(si)), *self.last[: _KEPT - 1])

    def snapshot(self) -> object:
        """The state, for `restore`."""
        return self.so, self.si, self.last

    def restore(self, snapshot: tuple[bytes, bytes, tuple[Telegram, ...]]) -> None:
        """Go back to what `snapshot` gave."""
        self.so, self.si, self.last = snapshot
