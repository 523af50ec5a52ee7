"""The text of docs/fidelity.md: what the virtual controller knows, and what it assumes."""

from __future__ import annotations

from dataclasses import MISSING, fields

from rcx_harness.robot.config import SECTIONS, RobotConfig
from rcx_tools.docs.rules import rules

__all__ = ["fidelity_page"]

_HEAD = """\
# What the virtual controller knows, and what it assumes

Written by the harness from `spec/rules.toml`; do not edit.
The manual is that of the YAMAHA network board EtherNet/IP for RCX340/RCX320, Ver. 1.31.
Nothing here has been compared with a real controller.
"""

_ASSUMED_HEAD = """\
## Assumed

The manual is silent or open to two readings. A knob is a key of the robot file (`--robot`);
its default is in brackets, delays are in ms, fixed or as `[shortest, longest]`.
A rule without a knob is a simplification of the model.
"""

_SECTIONS_HEAD = """\
## Keys of the robot file by section

As `RobotConfig` groups them; in the file all of them stand side by side.
"""


def fidelity_page() -> str:
    """The page as Markdown."""
    defaults = {
        entry.name: getattr(RobotConfig(), entry.name)
        for entry in fields(RobotConfig)
        if entry.default is not MISSING
    }
    lines = [_HEAD, "## From the manual\n", "| # | Rule | Section |", "|---|---|---|"]
    for number, rule in enumerate((r for r in rules() if r.from_manual), 1):
        lines.append(f"| M{number} `{rule.id}` | {rule.text} | {rule.section} |")
    lines += ["", _ASSUMED_HEAD, "| # | Rule | Knobs |", "|---|---|---|"]
    for number, rule in enumerate((r for r in rules() if not r.from_manual), 1):
        knobs = [_knob(name, defaults.get(name)) for name in rule.knobs]
        lines.append(f"| A{number} `{rule.id}` | {rule.text} | {', '.join(knobs) or 'none'} |")
    lines += ["", _SECTIONS_HEAD, "| Section | What it is | Keys |", "|---|---|---|"]
    for section in SECTIONS:
        keys = ", ".join(_knob(entry.name, defaults.get(entry.name)) for entry in fields(section))
        lines.append(f"| `{section.__name__}` | {section.__doc__} | {keys} |")
    return "\n".join(lines) + "\n"


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
