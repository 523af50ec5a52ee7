"""Small models: they quickly find errors that need many scans to appear."""

from __future__ import annotations

from dataclasses import replace

from rcx_tools.evidence.explore.model import DOWN, UP
from rcx_tools.evidence.explore.models import COMMANDS, JOG

__all__ = ["SMALL"]

ALONE = replace(
    COMMANDS,
    name="alone",
    title="one remote command, with any status and a link that stays",
    blocks=COMMANDS.blocks[:1],
    situations=COMMANDS.situations[:4],
)

STOPPED = replace(
    JOG,
    name="stopped",
    title="a jog that is stopped, a longer margin: the next command waits for SI(06)",
    blocks=tuple(replace(block, does=(DOWN, UP)) for block in JOG.blocks),
    situations=JOG.situations[:4],
    quiet=JOG.quiet[:2],
    pins=((True, True),),
    margin_ms=50,
)

SMALL = (ALONE, STOPPED)
