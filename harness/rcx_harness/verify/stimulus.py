"""Runs that were found as stimulus files, which `rcx run` replays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

__all__ = ["Moment", "text_of_moments"]


class Moment(NamedTuple):
    """What changes at a time.

    Attributes:
        t_us: From the start of the run.
        values: New values of variables, as in TOML, by path.
        areas: What the PLC reads from now on, and its scanner's status, by controller.
    """

    t_us: int
    values: Mapping[str, str]
    areas: Mapping[int, tuple[bytes, bool]]


def text_of_moments(moments: Iterable[Moment], about: str = "") -> str:
    """The stimulus file; `about` is the comment at its beginning."""
    lines = [f"# {line}" for line in about.splitlines()]
    for moment in moments:
        keys: dict[int, list[str]] = {1: []}
        if moment.values:
            pairs = [f'"{name}" = {value}' for name, value in moment.values.items()]
            keys[1].append(f"set = {{ {', '.join(pairs)} }}")
        for controller, (content, connected) in sorted(moment.areas.items()):
            entry = keys.setdefault(controller, [])
            entry.append(f'area = "{_hex(content)}"')
            entry += [] if connected else ["connected = false"]
            entry += [f"controller = {controller}"] if controller > 1 else []
        for entry in filter(None, keys.values()):
            lines += ["", "[[at]]", f'time = "{_time(moment.t_us)}"', *entry]
    return "\n".join(lines).lstrip("\n") + "\n"


def _time(t_us: int) -> str:
    return f"{t_us}us" if t_us % 1000 else f"{t_us // 1000}ms"


def _hex(content: bytes) -> str:
    """In words of the area; what is 0 to the end is left out."""
    used = max((k + 1 for k, byte in enumerate(content) if byte), default=1)
    return content[: used + used % 2].hex(" ", 2)
