"""PLCopen TC6 XML: its declarations, bodies, devices and tasks."""

from structured_text.projects.plcopen.read import KINDS, SECTIONS, read_plcopen, written_by

__all__ = ["KINDS", "SECTIONS", "read_plcopen", "written_by"]
