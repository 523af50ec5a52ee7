"""A chain in words, and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rcx_harness.look.why.causes import Step, error_entry
from rcx_harness.look.why.chain import Chain
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
            there = ""
            if step.controller != chain.controller:
                there = f"controller {step.controller}: "
            yield f"  {number}. {there}{step.text}{_since(step)}"
        yield f"To go on: {chain.to_go_on}"
        if chain.cause.key in ("unknown", "not-recorded"):
            yield HOW_TO_RECORD


def _since(step: Step) -> str:
    """Return the end of a step's line: since when, and the section."""
    since = "" if step.since_us is None else f", since {step.since_us / 1e6:.3f} s"
    return since + (f"  [{step.section}]" if step.section else "")


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
