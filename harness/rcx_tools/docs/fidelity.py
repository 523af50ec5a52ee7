"""Generator of fidelity.md: rules and assumptions that the virtual controller follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields

from rcx_harness.robot.config import SECTIONS, RobotConfig
from rcx_harness.spec.rules import Rule, rules

__all__ = ["fidelity_page"]

_HEAD = """\
# What the virtual controller knows, and what it assumes

Written by the harness from `spec/rules.toml`; do not edit.
The manual is that of the YAMAHA network board EtherNet/IP for RCX340/RCX320, Ver. 1.31.

There are four classes of rules: from the manual, from a public source, measured at a real
controller, or assumed because the manual is silent or ambiguous. A rule that is inferred from a
name counts as assumed. {measured}

A setting is a key of the robot file (`--robot`). Its default is in brackets; delays are in ms,
either fixed or as `[shortest, longest]`.
An assumed rule without a setting is a simplification of the model.
"""

_NOTHING_MEASURED = "Nothing here has been measured at a real controller yet."
_SOME_MEASURED = "A measurement is valid for the controllers and firmware that its row names."

#: The classes of rules: basis, letter before the number, heading, and title of the column.
_CLASSES = (
    ("manual", "M", "From the manual", "Section"),
    ("public", "P", "From a public source", "Source"),
    ("measured", "R", "Measured at a real controller", "By whom, which firmware"),
    ("assumed", "A", "Assumed", "Settings"),
)

_SECTIONS_HEAD = """\
## Keys of the robot file by section

As `RobotConfig` groups them; in the file all of them stand side by side.
"""


def fidelity_page() -> str:
    """Return fidelity.md as Markdown."""
    defaults = {
        entry.name: getattr(RobotConfig(), entry.name)
        for entry in fields(RobotConfig)
        if entry.default is not MISSING
    }
    measured = any(rule.basis == "measured" for rule in rules())
    lines = [_HEAD.format(measured=_SOME_MEASURED if measured else _NOTHING_MEASURED)]
    for basis, letter, title, names in _CLASSES:
        lines.append(f"## {title}\n")
        mine = [rule for rule in rules() if rule.basis == basis]
        if mine:
            both = basis in ("public", "measured")
            heads = ["#", "Rule", names, *(["Settings"] if both else [])]
            lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
            lines += [_row(f"{letter}{n}", rule, defaults) for n, rule in enumerate(mine, 1)]
        else:
            lines.append("None yet.")
        lines.append("")
    lines += [_SECTIONS_HEAD, "| Section | What it is | Keys |", "|---|---|---|"]
    for section in SECTIONS:
        keys = ", ".join(_knob(entry.name, defaults.get(entry.name)) for entry in fields(section))
        lines.append(f"| `{section.__name__}` | {section.__doc__} | {keys} |")
    return "\n".join(lines) + "\n"


def _row(number: str, rule: Rule, defaults: Mapping[str, object]) -> str:
    knobs = ", ".join(_knob(name, defaults.get(name)) for name in rule.knobs) or "none"
    last = {"manual": rule.section, "assumed": knobs}.get(rule.basis, f"{rule.source} | {knobs}")
    return f"| {number} `{rule.id}` | {rule.text} | {last} |"


def _knob(name: str, default: object) -> str:
    if default is None or name in ("axes", "programs"):
        return f"`{name}`"
    if isinstance(default, bool):
        return f"`{name}` ({str(default).lower()})"
    if isinstance(default, tuple):
        return f"`{name}` ({', '.join(map(str, default))})"
    if isinstance(default, int) and name.endswith(("_version", "_revision")):
        return f"`{name}` (0x{default:04X})"
    if isinstance(default, float):
        return f"`{name}` ({default:g})"
    return f"`{name}` ({default or 'none'})"
