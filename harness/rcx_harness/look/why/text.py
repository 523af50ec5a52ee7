"""A chain in words, and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rcx_harness.look.why.chain import Chain
from rcx_harness.look.why.causes import error_entry
from structured_text.output.units import format_word

__all__ = ["HOW_TO_RECORD", "as_json", "lines"]

HOW_TO_RECORD = (
    "unknown causes need more variables: rcx run ... --trace FILE "
    "--watch 'Main.*,Main.*.Busy,Main.*.Active,Main.*.ErrorID'"
)


def lines(found: Sequence[Chain]) -> Iterable[str]:
    """Yield the lines that explain the chains of all controllers."""
    several = len(found) > 1
    for chain in found:
        head = f"controller {chain.controller}: " if several else ""
        yield head + _headline(chain)
        for number, step in enumerate(chain.steps, 1):
            since = "" if step.since_us is None else f" since {step.since_us / 1e6:.3f} s"
            section = f"  [{step.section}]" if step.section else ""
            there = ""
            if step.controller != chain.controller:
                there = f"controller {step.controller}: "
            yield f"  {number}. {there}{step.text},{since}{section}".replace(",  [", "  [").rstrip(
                ","
            )
        yield f"To go on: {chain.to_go_on}"
        if chain.cause.key == "unknown":
            yield HOW_TO_RECORD


def _headline(chain: Chain) -> str:
    key = chain.cause.key
    if key == "unknown":
        return "The cause is not known."
    if not chain.cause.stands:
        return "Nothing waits."
    name = f"{format_word(chain.error)} {error_entry(chain.error)['name']}" if chain.error else key
    return f"It stands: {name}."


def as_json(file: str, t_us: int | None, found: Sequence[Chain]) -> dict[str, Any]:
    """Return the chains for the option --json."""
    return {
        "file": file,
        "t_us": t_us,
        "stands": any(chain.cause.stands for chain in found),
        "chains": [
            {
                "controller": chain.controller,
                "cause": chain.cause.key,
                "error": format_word(chain.error) if chain.error else None,
                "who": chain.cause.who,
                "section": chain.cause.section,
                "stands": chain.cause.stands,
                "to_go_on": chain.to_go_on,
                "steps": [step._asdict() for step in chain.steps],
            }
            for chain in found
        ],
    }
