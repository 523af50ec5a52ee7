"""The robot's side of the bridge: a cyclic connection that reopens after every loss."""

from __future__ import annotations

from rcx_harness.bridge.core import Lost, RobotSeen
from rcx_harness.enip.originator.persistent_connection import PersistentConnection

__all__ = ["RobotLink"]


class RobotLink(PersistentConnection):
    """The exclusive-owner connection to the robot."""

    def read(self) -> RobotSeen | Lost:
        """Return the latest area from the robot, or the reason of its loss."""
        received = self.received()
        return Lost(received) if isinstance(received, str) else RobotSeen(received.image)
