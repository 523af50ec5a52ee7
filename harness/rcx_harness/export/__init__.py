"""The library and a user's program in the file formats of PLC tools."""

from rcx_harness.export.targets import TARGETS, Target, export

__all__ = ["TARGETS", "Target", "export"]
