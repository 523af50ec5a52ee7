"""The user's properties in an exploration. The memory of a property is a part of each state."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

from rcx_harness.verify.properties import Areas, Declared, followed
from structured_text.engines.base import Program
from structured_text.errors import InputError

__all__ = ["Demanded"]


class Demanded:
    """The properties of a program. The exploration restores their memory for each state."""

    def __init__(
        self,
        program: Program,
        declared: Sequence[Declared],
        scan_us: int,
        areas: Areas | None = None,
    ) -> None:
        for one in declared:
            if callable(one.that) or callable(one.after):
                hint = "write it as [[always]] or [[eventually]] in a TOML file"
                text = f"{one.name}: properties in Python cannot be explored"
                raise InputError(text, file=one.file, hint=hint)
        self._program, self._scan_us = program, scan_us
        self._followed = followed(program, declared, areas=areas)

    def state(self, now_us: int = 0) -> Hashable:
        """Return the memory of all properties after a scan at the time `now_us`."""
        return tuple(one.memory(now_us) for one in self._followed)

    def go_to(self, state: Any, now_us: int) -> None:
        """Restore the memory of all properties. The next scan is at the time `now_us`."""
        before_us = now_us - self._scan_us
        for one, memory in zip(self._followed, state, strict=True):
            one.remember(memory, before_us)

    def scan(self, now_us: int) -> list[str]:
        """Return the properties that a scan broke, with the messages of `rcx run --properties`."""
        return [
            f"property: {one.declared.kind}: {one.told(self._program)}"
            for one in self._followed
            if one.scan(now_us)
        ]
