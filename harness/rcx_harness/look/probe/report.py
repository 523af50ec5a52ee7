"""The report of a probe, with the evidence for each rule (TOML and Markdown)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

from rcx_harness.look.probe.asker import Finding
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.look.probe.run import Outcome
from rcx_harness.spec import folder
from rcx_harness.spec.rules import Rule, rules
from structured_text.output.toml_files import load_toml, toml_value

__all__ = ["Subject", "Verdict", "as_markdown", "as_toml", "unasked", "verdicts"]


@dataclass(frozen=True)
class Subject:
    """The person, the day and the device of a probe, as entered by the person.

    Attributes:
        robot: Type of controller and robot, such as `RCX340 with YK400XE`; may be empty.
    """

    host: str
    robot: str
    by: str
    date: str


@dataclass(frozen=True)
class Verdict:
    """The result of a probe for one assumed rule.

    Attributes:
        verdict: `confirmed`, `confirmed in part`, `refuted` or `not asked`.
        findings: Findings with their questions.
        open: Keys of the rule that no finding decides.
        reason: Why the rule was not examined; empty if it was examined.
    """

    rule: Rule
    verdict: str
    findings: tuple[tuple[str, Finding], ...]
    open: tuple[str, ...]
    reason: str


@lru_cache(maxsize=1)
def unasked() -> Mapping[str, str]:
    """Return the assumed rules that no question decides. Each rule is mapped to the reason."""
    table: list[dict[str, Any]] = load_toml(folder() / "unasked.toml")["unasked"]
    return {rule: entry["reason"] for entry in table for rule in entry["rules"]}


def verdicts(outcome: Outcome) -> list[Verdict]:
    """Return a verdict for each assumed rule, in the order of spec/rules.toml."""
    return [_verdict(rule, outcome) for rule in rules() if rule.basis == "assumed"]


def _verdict(rule: Rule, outcome: Outcome) -> Verdict:
    found = tuple(
        (name, one)
        for name, several in outcome.findings.items()
        for one in several
        if one.rule == rule.id
    )
    known = {one.knob for _, one in found if one.verdict != "open"}
    still = tuple(knob for knob in rule.knobs if knob not in known)
    kinds = {one.verdict for _, one in found}
    if "refuted" in kinds:
        return Verdict(rule, "refuted", found, still, "")
    if "confirmed" in kinds:
        whole = not still and "open" not in kinds
        return Verdict(rule, "confirmed" if whole else "confirmed in part", found, still, "")
    return Verdict(rule, "not asked", found, still, _reason(rule, outcome))


def _reason(rule: Rule, outcome: Outcome) -> str:
    if rule.id in unasked():
        return unasked()[rule.id]
    mine = [one for one in questions() if rule.id in one.decides]
    reasons = [outcome.skipped[one.id] for one in mine if one.id in outcome.skipped]
    return reasons[0] if reasons else f"question {', '.join(one.id for one in mine)} not chosen"


def as_toml(outcome: Outcome, subject: Subject) -> str:
    """Return the report of a probe as TOML, for programs."""
    head = {
        "format": "rcx-probe/1",
        **asdict(subject),
        "identity": outcome.identity,
        "firmware": _firmware(outcome),
        "ended": outcome.ended,
    }
    lines = [*_rows(head)]
    for one in verdicts(outcome):
        rule: dict[str, Any] = {"id": one.rule.id, "verdict": one.verdict}
        if one.reason:
            rule["reason"] = one.reason
        if one.findings and one.open:
            rule["open"] = one.open
        lines += ["", "[[rule]]", *_rows(rule)]
        for question, found in one.findings:
            row: dict[str, Any] = {"question": question}
            row |= {"knob": found.knob} if found.knob else {}
            values = "between" if found.between else "values"
            row |= {"verdict": found.verdict, values: found.values}
            row |= {"assumed": found.expected, "evidence": found.text}
            lines += ["", "[[rule.finding]]", *_rows(row)]
    return "\n".join(lines) + "\n"


def _rows(table: Mapping[str, Any]) -> Iterator[str]:
    for key, value in table.items():
        yield f"{key} = {toml_value(_rounded(value))}"


def _rounded(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_rounded, value))
    return round(value, 3) if isinstance(value, float) else value


def as_markdown(outcome: Outcome, subject: Subject) -> str:
    """Return the report of a probe as Markdown, for readers."""
    every = verdicts(outcome)
    count = {kind: sum(one.verdict == kind for one in every) for kind in _KINDS}
    lines = [
        f"# Probe of {subject.robot or 'a controller'} at {subject.host}",
        "",
        f"By {subject.by or 'nobody named'}, {subject.date or 'no date given'}. "
        + _firmware(outcome),
        "",
        *(f"- {line}" for line in outcome.identity),
        "",
        ", ".join(f"{number} {kind}" for kind, number in count.items())
        + f", of {len(every)} rules that are assumed.",
    ]
    if outcome.ended:
        lines += ["", f"**It ended before its last question: {outcome.ended}.**"]
    for kind in _KINDS:
        mine = [one for one in every if one.verdict == kind]
        if mine:
            lines += ["", f"## {kind.capitalize()}", "", *_table(kind, mine)]
    return "\n".join(lines) + "\n"


_KINDS = ("refuted", "confirmed", "confirmed in part", "not asked")


def _table(kind: str, verdicts_: Sequence[Verdict]) -> Iterator[str]:
    if kind == "not asked":
        yield "| Rule | Why |\n|---|---|"
        for one in verdicts_:
            yield f"| `{one.rule.id}` | {_cell(one.reason)} |"
        return
    yield "| Rule | Key | Assumed | Found | Evidence |\n|---|---|---|---|---|"
    for one in verdicts_:
        for _, finding in one.findings:
            key = f"`{finding.knob}`" if finding.knob else ""
            yield (
                f"| `{one.rule.id}` | {key} | {_shown(finding.expected)} | {_found(finding)} | "
                f"{_cell(finding.text)} |"
            )
        if one.open:
            names = ", ".join(f"`{name}`" for name in one.open)
            yield f"| `{one.rule.id}` | {names} | | not asked | |"


def _found(finding: Finding) -> str:
    if finding.between:
        low, high = finding.values
        return f"more than {max(0.0, low):g}, at most {high:g}"
    return " or ".join(map(_shown, finding.values))


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ", ".join(map(_shown, value)) or "none"
    return str(value) if value != "" else "none"


def _firmware(outcome: Outcome) -> str:
    found = {one.knob: one.values[0] for several in outcome.findings.values() for one in several}
    if "host_version" not in found:
        return "Its versions were not read."
    return (
        f"Host 0x{found['host_version']:04X} revision 0x{found.get('host_revision', 0):04X}, "
        f"FPGA 0x{found.get('fpga_version', 0):04X}, "
        f"driver 0x{found.get('driver_version', 0):04X}."
    )


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
