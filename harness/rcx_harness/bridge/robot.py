"""The robot's side of the bridge: a cyclic connection that is opened again after every loss."""

from __future__ import annotations

from rcx_harness.bridge.core import Lost, RobotSeen
from rcx_harness.enip.originator.kept import KeptConnection

__all__ = ["RobotLink"]


class RobotLink(KeptConnection):
    """One exclusive-owner connection, as long as there is a robot."""

    def read(self) -> RobotSeen | Lost:
        """What has come from the robot."""
        received = self.received()
        return Lost(received) if isinstance(received, str) else RobotSeen(received.image)
