"""The option `--no-robot`: a program runs alone on a bench instead of in a cell."""

from __future__ import annotations

from collections.abc import Iterable

from rcx_harness.cell.stimulus import KEYS
from structured_text.bench import stimulus
from structured_text.errors import InputError

__all__ = ["Stimulus", "refuse"]

#: The options that concern a robot, its network, or the faults and charts of a cell.
_OF_ROBOTS = (
    *("link", "size", "m", "n", "robot", "rpi", "jitter", "timeout", "phases", "on_loss"),
    *("realtime", "panel", "connect", "yes", "input_instance", "output_instance"),
    *("config_instance", "config_data", "address", "positions", "seed", "faults"),
)
#: Maps a field to the name of its option, if the two names differ.
_NAMES = {"address": "from"}


class _Entry(stimulus.Entry):
    @classmethod
    def refuse(cls, key: str) -> None:
        if key in KEYS:
            hint = "leave out the key, or leave out --no-robot"
            raise InputError(f"{key!r} needs a robot, and the program runs without one", hint=hint)
        super().refuse(key)


class Stimulus(stimulus.Stimulus):
    """The entries of a stimulus file for a program without a robot."""

    entry = _Entry


def refuse(typed: Iterable[str]) -> None:
    """Raise InputError if an option that the user has typed concerns a robot."""
    for name in typed:
        if name in _OF_ROBOTS:
            option = f"--{_NAMES.get(name, name).replace('_', '-')}"
            hint = f"leave out {option}, or leave out --no-robot"
            raise InputError(f"{option} needs a robot, and the program runs without one", hint=hint)
