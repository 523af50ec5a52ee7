"""The connection path of a Forward Open as bytes: key, application paths, and what is between.

Segments are those of CIP volume 1, appendix C: logical (0x20, 0x24, 0x2C, 8 or 16 bits wide),
electronic key (0x34), network (0x43, 0x50: production inhibit time) and simple data (0x80).
"""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.enip.codec.cip import ElectronicKey, Refusal, Status, decode_key
from rcx_harness.enip.codec.connection_status import ExtendedStatus

__all__ = ["ConnectionPath", "PathRefusal", "decode_connection_path"]

_CLASS, _INSTANCE, _CONNECTION_POINT = 0x20, 0x24, 0x2C
_SIXTEEN_BIT = 0x01
_KEY, _KEY_FORMAT, _KEY_END = 0x34, 0x04, 10
_INHIBIT_MS, _INHIBIT_US, _INHIBIT_US_WORDS = 0x43, 0x50, 2
_DATA = 0x80


class PathRefusal(Refusal):
    """A segment that is not understood (extended status 0x315).

    Args:
        remaining: Words of the path from that segment to the end.
    """

    def __init__(self, remaining: int) -> None:
        super().__init__(Status.CONNECTION_FAILURE, (ExtendedStatus.SEGMENT_IN_PATH,))
        self.remaining = remaining


@dataclass(frozen=True)
class ConnectionPath:
    """What a connection path names.

    Attributes:
        key: Which device the originator means.
        class_id: Class of all application paths.
        numbers: Instances and connection points in their order: configuration if there are three,
            consuming, producing; or the one instance of an explicit connection.
        configuration: Data for the configuration instance.
        inhibit_us: Production inhibit time in microseconds, 0 without one.
    """

    key: ElectronicKey | None
    class_id: int
    numbers: tuple[int, ...]
    configuration: bytes = b""
    inhibit_us: int = 0

    def application(self) -> tuple[int, tuple[int, ...]]:
        """The part that a Forward Close must name again."""
        return self.class_id, self.numbers


def decode_connection_path(path: bytes) -> ConnectionPath:
    """Take a connection path apart.

    Args:
        path: Padded path, an even number of bytes.

    Raises:
        PathRefusal: a segment that is not understood, in a wrong place or cut off; or no class.
        Refusal: the application paths are of several classes.
    """
    key: ElectronicKey | None = None
    class_id: int | None = None
    numbers: list[int] = []
    configuration = b""
    inhibit_us = 0
    at = 0
    while at < len(path):
        kind, length = path[at] & ~_SIXTEEN_BIT, _length(path, at)
        body = path[at + 2 : at + length]
        if path[at] == _KEY and at == 0:
            key = decode_key(body)
        elif kind == _CLASS:
            number = _number(path, at)
            if class_id not in (None, number):
                raise Refusal(Status.CONNECTION_FAILURE, (ExtendedStatus.INCONSISTENT_PATHS,))
            class_id = number
        elif kind in (_INSTANCE, _CONNECTION_POINT) and class_id is not None:
            numbers.append(_number(path, at))
        elif path[at] == _INHIBIT_MS:
            inhibit_us = 1000 * path[at + 1]
        elif path[at] == _INHIBIT_US:
            inhibit_us = int.from_bytes(body, "little")
        elif path[at] == _DATA:
            configuration = body
        else:
            raise _refused(path, at)
        at += length
    if class_id is None:
        raise _refused(path, len(path))
    return ConnectionPath(key, class_id, tuple(numbers), configuration, inhibit_us)


def _length(path: bytes, at: int) -> int:
    """Bytes of the segment at `at`, which lies wholly within the path."""
    segment, second = path[at], path[at + 1]
    if segment & ~_SIXTEEN_BIT in (_CLASS, _INSTANCE, _CONNECTION_POINT):
        length = 4 if segment & _SIXTEEN_BIT else 2
    elif segment == _KEY and second == _KEY_FORMAT:
        length = _KEY_END
    elif segment == _INHIBIT_MS:
        length = 2
    elif segment == _DATA or (segment == _INHIBIT_US and second == _INHIBIT_US_WORDS):
        length = 2 + 2 * second
    else:
        raise _refused(path, at)
    if at + length > len(path):
        raise _refused(path, at)
    return length


def _number(path: bytes, at: int) -> int:
    if path[at] & _SIXTEEN_BIT:
        return int.from_bytes(path[at + 2 : at + 4], "little")
    return path[at + 1]


def _refused(path: bytes, at: int) -> PathRefusal:
    return PathRefusal((len(path) - at) // 2)
