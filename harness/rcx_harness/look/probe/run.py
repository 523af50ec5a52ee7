"""The course of a probe: it asks the questions, and ends safely in every case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness.look.probe.asker import Asker, Finding, SkipError
from rcx_harness.look.probe.line import LostError, NetworkLine, NotConnectedError
from rcx_harness.look.probe.question import Question, Risk
from rcx_harness.spec.wire import READY
from rcx_harness.trace import Trace
from structured_text.errors import InputError

__all__ = ["Outcome", "Person", "probe"]


@dataclass
class Outcome:
    """The result of a probe.

    Attributes:
        findings: Findings by question, in the order of the questions.
        skipped: Maps a question to the reason why it was skipped or has decided nothing.
        ended: Reason why the probe ended before its last question. Empty if the probe is complete.
    """

    identity: Sequence[str] = ()
    findings: dict[str, list[Finding]] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    ended: str = ""


@dataclass(frozen=True)
class Person:
    """The person who operates the probe.

    Attributes:
        confirms: Function that is called before each question; returns False to skip it.
        does: Function that is called with an action at the cell and the name of its event; returns
            False if the action was not done.
        tell: Function that is called with each line of output.
    """

    confirms: Callable[[Question], bool]
    does: Callable[[str, str], bool]
    tell: Callable[[str], None]


def probe(
    line: NetworkLine, asked: Sequence[Question], person: Person, trace: Path | None = None
) -> Outcome:
    """Ask all questions. Between two questions and at the end all inputs are OFF.

    Ctrl-C or a lost connection ends the probe: the inputs go OFF, the connection is closed, and the
    outcome contains all findings so far.

    `person` confirms each question; `trace` is the file for the evidence.
    """
    outcome = Outcome(identity=list(line.identity))
    header = {"by": "rcx probe", "size": line.size, "only": "changes"}
    written = Trace(header, trace, new=True, keep=0) if trace is not None else None
    ask = Asker(line, person.does, written)
    try:
        ask.open()
        if ask.status != READY:
            raise SkipError(f"it shows the remote status 16#{ask.status:04X} without a command")
        for question in asked:
            if person.confirms(question):
                _ask(ask, question, outcome, person)
            else:
                outcome.skipped[question.id] = "not confirmed"
    except KeyboardInterrupt:
        outcome.ended = "stopped by Ctrl-C"
    except SkipError as reason:
        outcome.ended = str(reason)
    except NotConnectedError as error:
        outcome.ended = f"no connection: {error}"
    except LostError as error:
        outcome.ended = f"the connection is lost: {error}"
    finally:
        try:
            line.close()
        finally:
            if written is not None:
                written.close()
    for question in asked:
        if question.id not in outcome.findings and question.id not in outcome.skipped:
            outcome.skipped[question.id] = outcome.ended or "not asked"
    return outcome


def _ask(ask: Asker, question: Question, outcome: Outcome, person: Person) -> None:
    before = len(ask.findings)
    ask.begin(question.decides)
    try:
        if question.risk < Risk.MOTION and ask.on("SO02"):
            raise SkipError("the servos are ON although SI(00) is OFF")
        question.ask(ask)
    except SkipError as reason:
        outcome.skipped[question.id] = str(reason)
    except InputError as error:
        outcome.skipped[question.id] = error.message
    finally:
        found = ask.findings[before:]
        if found:
            outcome.findings[question.id] = found
    ask.rest()
    for one in found:
        shown = f"{one.rule}{f', {one.knob}' if one.knob else ''}"
        person.tell(f"  {one.verdict:<9}  {shown}: {one.text}")
    if question.id in outcome.skipped:
        person.tell(f"  open       {outcome.skipped[question.id]}")
