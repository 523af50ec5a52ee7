"""What the cell asks of the network: two images and the way between them."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from rcx_harness.spec.wire import SIZE

__all__ = ["DirectLink", "Link", "RealLink"]


@runtime_checkable
class Link(Protocol):
    """The two assemblies of the adapter, as seen from the scanner and from the robot.

    Images are exactly `size` bytes. Nothing here knows of time: the cell decides when a packet
    is produced and when it arrives.
    """

    name: str
    size: int

    def scanner_write(self, image: bytes) -> None:
        """A packet from the master arrives: assembly 150 is `image` from now on."""

    def scanner_read(self) -> bytes:
        """What the master receives now: assembly 100."""

    def robot_read(self) -> bytes:
        """What the controller finds in assembly 150."""

    def robot_write(self, image: bytes) -> None:
        """The controller puts its outputs into assembly 100."""

    def close(self) -> None:
        """End the connection and free what it holds."""


@runtime_checkable
class RealLink(Link, Protocol):
    """A link whose packets travel by themselves, in real time."""

    def make_network(self, *, matched: bool) -> tuple[Any, Any]:
        """The agenda and the network of a cell on this link.

        Args:
            matched: Do master and robot agree on the area's size?
        """


class DirectLink:
    """Both images in one process, no network at all.

    Args:
        size: Bytes of each area, 48 or 256.
    """

    name = "direct"

    def __init__(self, size: int = SIZE) -> None:
        self.size = size
        self._to_robot = bytes(size)
        self._to_master = bytes(size)

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150."""
        self._to_robot = bytes(image)

    def scanner_read(self) -> bytes:
        """Return assembly 100."""
        return self._to_master

    def robot_read(self) -> bytes:
        """Return assembly 150."""
        return self._to_robot

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100."""
        self._to_master = bytes(image)

    def close(self) -> None:
        """Nothing to free."""
