"""Generator of probes.md: the questions of `rcx probe`, and the assumed rules that they decide."""

from __future__ import annotations

from collections.abc import Iterator

from rcx_harness.look.probe.catalogue import questions
from rcx_harness.look.probe.report import unasked
from rcx_harness.spec.rules import rules

__all__ = ["probes_page"]

_HEAD = """\
<!-- generated from the questions and spec/unasked.toml by `make docs`; do not edit -->

# Which question decides which assumed rule

The rules are those of [fidelity.md](../explanation/fidelity.md) that are assumed; how to ask is in
[probe.md](../how-to/probe.md).
"""


def probes_page() -> str:
    """Return probes.md as Markdown."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield _HEAD
    yield "## The questions\n"
    yield "| Question | Risk | What it asks | What it does |\n|---|---|---|---|"
    for one in questions():
        does = f"{one.does} You: {one.person}." if one.person else one.does or "References."
        yield f"| `{one.id}` | {one.risk.value} | {one.title} | {does} |"
    yield "\n## The rules\n"
    yield "| Rule | Question, and what it decides; or why there is none |\n|---|---|"
    for rule in rules():
        if rule.basis != "assumed":
            continue
        asked = [
            f"`{one.id}`"
            + (
                f" ({', '.join(f'`{key}`' for key in one.decides[rule.id])})"
                if one.decides[rule.id]
                else ""
            )
            for one in questions()
            if rule.id in one.decides
        ]
        yield f"| `{rule.id}` | {'; '.join(asked) or unasked()[rule.id]} |"
