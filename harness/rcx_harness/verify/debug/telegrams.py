"""The last telegrams of a controller, derived from its areas scan by scan."""

from __future__ import annotations

import struct
from typing import NamedTuple

from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.telegram import WORDS
from rcx_harness.spec.wire import ENDS, READY

__all__ = ["Telegram", "Telegrams", "words_of"]

#: Number of the latest telegrams that are saved for each controller.
_KEPT = 8
#: The code 0, which means that no command is set.
_NONE = b"\0\0"


def words_of(area: bytes) -> tuple[int, ...]:
    """Return the 16 words of a telegram in an area."""
    return struct.unpack(f"<{WORDS}H", area[: 2 * WORDS])


class Telegram(NamedTuple):
    """A remote command: the time of its code, its request words, and the current answer.

    `ended_us` is -1 until the command ends. `answer` has the words from m on.
    """

    t_us: int
    request: tuple[int, ...]
    answer: tuple[int, ...] = (READY,) * WORDS
    ended_us: int = -1

    @property
    def request_text(self) -> str:
        """Return a description of the request in words."""
        return request_text(self.request)

    @property
    def answer_text(self) -> str:
        """Return a text about the end of the command, or about its current state."""
        if self.answer[0] == READY:
            return "not answered yet"
        return response_text(self.request[0], self.answer)


class Telegrams:
    """The list of the last telegrams, derived from the areas of one controller.

    Attributes:
        so: The area that the PLC read last.
        si: The area that the PLC wrote last.
        last: The last telegrams; the newest is first.
    """

    def __init__(self, size: int) -> None:
        self.so = self.si = bytes(size)
        self.last: tuple[Telegram, ...] = ()

    def take(self, t_us: int, so: bytes, si: bytes) -> None:
        """Update the telegrams with the areas of the next scan."""
        # A command begins when its code changes to a value other than 0. Its answer is
        # updated in each scan until the status is an end status. The code of the previous scan
        # decides, because `so` was read before `si` was written.
        before, self.so, self.si = self.si[:2], so, si
        code, status = si[:2], int.from_bytes(so[:2], "little")
        if before != _NONE and self.last and self.last[0].ended_us < 0:
            ended = t_us if status in ENDS else -1
            newest = self.last[0]._replace(answer=words_of(so), ended_us=ended)
            self.last = (newest, *self.last[1:])
        if code not in (before, _NONE):
            self.last = (Telegram(t_us, words_of(si)), *self.last[: _KEPT - 1])

    def snapshot(self) -> object:
        """Return a snapshot of the telegrams."""
        return self.so, self.si, self.last

    def restore(self, snapshot: tuple[bytes, bytes, tuple[Telegram, ...]]) -> None:
        """Restore a snapshot of the telegrams."""
        self.so, self.si, self.last = snapshot
