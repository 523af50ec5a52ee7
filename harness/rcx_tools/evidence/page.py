"""Text of verification.md, from the figures in verification.json."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcx_harness.spec.rules import rules
from rcx_tools.evidence.checks import CHECKS, Check
from rcx_tools.evidence.results import ROOT

__all__ = ["KEPT", "is_met", "verification_page"]

#: Name of the file with the figures of the page.
KEPT = ROOT / "docs/explanation/verification.json"

_HEAD = """\
<!-- generated from docs/explanation/verification.json by `make verification`; do not edit -->

# What is proved, what is tested, what is assumed

Each figure has a command that anyone can run. `make verification` runs the commands whose sources
have changed, and writes this page. The file `out/verification.json` contains all figures.
"""

_MORE = """\
## Also tested

- `make test-all` runs all tests, including the cases of `make contract` and small runs of the other
  checks. The names of tests are sentences of the manual; [blocks.md](../reference/blocks.md) and
  [commands.md](../reference/commands.md) lead from each block to its tests and to the manual.
- The telegrams of all remote commands are compared with the manual's own worked examples.
- FB_MoveTable runs with 7 faults, of 1 and of 15 scans, before each scan of a table. Whenever a
  telegram is on the wire, the displayed row is the row that runs. If the table is continued, each
  row is executed once and in order:(../../tests/motion/test_move_table_faults.py).
- `make lint` checks that every PLC named in the README can compile the Structured Text.
- `make fuzz` sends broken and hostile frames to the EtherNet/IP adapter.

## Assumed

- **No real controller has been connected.** Everything here is about the blocks, and the virtual
  controller that was written from the manual.
- The virtual controller follows {manual} rules from the manual{others}; {assumed} more
  are assumed, since the manual is silent or ambiguous: [fidelity.md](fidelity.md) lists them.
- The PLC exchanges the robot's area as a whole, between two scans, and `Margin` is as large as
  [scan-model.md](scan-model.md) requires.
- The compiler of the PLC follows the standard in the portable part of the language, which the
  library uses. The checks run on the built-in engine, or on matiec if it is installed; the proofs
  and the campaign compare both.
"""

#: Labels of the sources of rules that are neither from the manual nor assumed.
_OTHERS = {"public": "from public sources", "measured": "measured at a real controller"}


def verification_page(kept: Path = KEPT) -> str:
    """Return verification.md as Markdown. Checks that have not been run are marked."""
    figures: Mapping[str, Any] = {"library": "", "checks": {}}
    if kept.is_file():
        figures = json.loads(kept.read_text(encoding="utf-8"))
    return "\n".join(_lines(figures)) + "\n"


def _lines(figures: Mapping[str, Any]) -> Iterator[str]:
    checks = figures["checks"]
    yield _HEAD
    yield f"The figures are those of library state `{figures['library']}`.\n"
    yield "| Check | Kind | Result | Command |\n|---|---|---|---|"
    for check in CHECKS:
        link = f"[{check.title}](#{check.title.lower().replace(' ', '-')})"
        yield f"| {link} | {check.kind} | {_result(figures, check)} | `{check.command}` |"
    for kind in ("proved", "tested"):
        for check in (one for one in CHECKS if one.kind == kind):
            yield f"\n## {check.title}\n\n**{kind.capitalize()}.** {check.about}\n"
            yield f"Run it: `{check.command}`. {_sentence(figures, check)}."
            if check.name in checks:
                yield from _table([["Figure", "Value"], *checks[check.name]["rows"]])
                for table in checks[check.name].get("tables", ()):
                    yield from _table(table)
    count = Counter(rule.basis for rule in rules())
    yield ""
    others = "".join(f", {count[b]} {t}" for b, t in _OTHERS.items() if count[b])
    more = _MORE.format(manual=count["manual"], others=others, assumed=count["assumed"])
    yield more.rstrip("\n")


def _table(lines: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a Markdown table. The first line contains the headings."""
    heads, *others = lines
    yield f"\n| {' | '.join(heads)} |\n|{'---|' * len(heads)}"
    for line in others:
        yield f"| {' | '.join(line)} |"


def _sentence(figures: Mapping[str, Any], check: Check) -> str:
    told = _result(figures, check).replace("**", "")
    return told[0].upper() + told[1:]


def _result(figures: Mapping[str, Any], check: Check) -> str:
    if check.name not in figures["checks"]:
        return "not run"
    result = figures["checks"][check.name]
    told = "met" if result["met"] else "**not met**"
    if result["library"] != figures["library"]:
        told += f" by library state `{result['library'] or 'unknown'}`"
    return told


def is_met(figures: Mapping[str, Any], check: Check) -> bool:
    """Return whether the check was met, for the same state of the library as the figures."""
    result = figures["checks"].get(check.name)
    return bool(result and result["met"] and result["library"] == figures["library"])
