"""`--no-robot`: a program alone on a bench, in place of a cell."""

from __future__ import annotations

from collections.abc import Iterable

from rcx_harness.cell.stimulus import KEYS
from structured_text.bench import stimulus
from structured_text.errors import InputError

__all__ = ["Stimulus", "refuse"]

#: Options that say something of a robot, its network, or what is drawn for them.
_OF_ROBOTS = (
    *("link", "size", "m", "n", "robot", "rpi", "jitter", "timeout", "phases", "on_loss"),
    *("realtime", "panel", "connect", "yes", "input_instance", "output_instance"),
    *("config_instance", "config_data", "address", "positions", "seed", "faults"),
)
#: Options by their fields, where these have other names.
_NAMES = {"address": "from"}


class _Entry(stimulus.Entry):
    @classmethod
    def refuse(cls, key: str) -> None:
        if key in KEYS:
            hint = "leave the key out, or --no-robot"
            raise InputError(f"{key!r} is for a robot, and there is none", hint=hint)
        super().refuse(key)


class Stimulus(stimulus.Stimulus):
    """The entries of a stimulus file for a program without a robot."""

    entry = _Entry


def refuse(typed: Iterable[str]) -> None:
    """Refuse typed options, given by the names of their fields, that concern a robot."""
    for name in typed:
        if name in _OF_ROBOTS:
            option = f"--{_NAMES.get(name, name).replace('_', '-')}"
            hint = f"leave out {option}, or --no-robot"
            raise InputError(f"{option} is for a robot, and there is none", hint=hint)
