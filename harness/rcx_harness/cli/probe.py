"""`rcx probe`: questions to a real controller, each confirmed by a person."""

from __future__ import annotations

import os
import sys
from datetime import date as calendar
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import check_ipv4, check_port, interval_us
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.look.probe.line import NetworkLine
from rcx_harness.look.probe.question import Question, Risk
from rcx_harness.look.probe.report import Subject, as_markdown, as_toml, unasked, verdicts
from rcx_harness.look.probe.run import Outcome, Person
from rcx_harness.look.probe.run import probe as run_probe
from rcx_harness.spec.rules import rules
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError
from structured_text.output.files import NewFiles

__all__ = ["probe"]

_SAFETY = """\
SAFETY. This program becomes the master of a real robot.
- Disconnect the PLC from it first, and stay outside the fence. Nobody is inside.
- The hard-wired emergency stop is in your reach, and you know the cell.
- What you are told before each step is what happens if the controller is as assumed. It may not be:
  that is what is asked. Expect every axis to move at every step but those that only read.
- Ctrl-C ends it: all inputs go OFF, SI(00) among them, and the connection is closed. That is no
  emergency stop."""
_ENDINGS = (".toml", ".md", ".jsonl")


def probe(
    host: Annotated[str, typer.Argument(help="Address of the controller.")] = "",
    plain_list: Annotated[
        bool, typer.Option("--list", help="Print the questions and the rules, then end.")
    ] = False,
    risk: Annotated[
        int, typer.Option(help="Highest risk: 1 reading only, 2 no motion, 3 motion.")
    ] = 1,
    only: Annotated[
        list[str] | None, typer.Option(help="Only this question; may be repeated.")
    ] = None,
    yes_reading: Annotated[
        bool,
        typer.Option(
            "--yes-reading", help="Ask all questions that only read, without confirmation."
        ),
    ] = False,
    out: Annotated[
        Path,
        typer.Option(help="Name of the report and its evidence; .toml, .md and .jsonl are added."),
    ] = Path("probe"),
    by: Annotated[str, typer.Option(help="Your name, for the report.")] = "",
    robot: Annotated[
        str, typer.Option(help="The controller and robot, such as 'RCX340, YK400XE'.")
    ] = "",
    date: Annotated[
        str, typer.Option(help="Today's date for the report, such as 2030-12-31.")
    ] = "",
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE,
    rpi: Annotated[str, typer.Option(help="Packet interval.")] = "10ms",
    port: Annotated[int, typer.Option(help="TCP port of the controller.")] = PORT,
    address: Annotated[str, typer.Option("--from", help="Local address for the connection.")] = "",
) -> None:
    """Check the assumptions of the virtual controller at a real one; you confirm each step.

    Steps are sorted by risk: reading only, no motion with the servos off, motion. The command
    writes a report that you can send. It lists each rule as confirmed, refuted or not asked, with
    the observation. Nothing moves before you confirm the step.

    Exit code: 0; 1 if a rule was refuted or the probe ended early; 130 after Ctrl-C; 2 on bad
    input.
    """
    asked = _chosen(risk, only or [], yes_reading)
    if plain_list:
        _list(questions() if not only else asked)
        return
    if not host:
        raise InputError(
            "HOST is missing", hint="write rcx probe 192.168.0.10, or rcx probe --list"
        )
    check_size(size)
    check_port("--port", port)
    if address:
        check_ipv4("--from", address)
    rpi_us = interval_us("--rpi", rpi)
    _check_date(date)
    files = [out.with_name(out.name + ending) for ending in _ENDINGS]
    another = "name another file with --out"
    if os.path.lexists(files[2]):
        raise InputError("already exists", file=files[2], hint=another)
    interactive = not yes_reading
    if interactive and not sys.stdin.isatty():
        hint = "use --yes-reading to ask only the questions that only read"
        raise InputError("each step must be confirmed at a terminal, and there is none", hint=hint)
    with NewFiles(files[:2], another) as reports:
        print(_SAFETY, flush=True)
        if interactive and not _agreed('Type "yes" if all of this is so: ', "yes"):
            raise InputError("nothing was done")
        person = _AT_TERMINAL if interactive else _NOBODY
        subject = Subject(host, robot, by, date)
        try:
            line = NetworkLine(host, size, rpi_us, port, address)
            outcome = run_probe(line, asked, person, files[2])
        except EnipError as error:
            raise InputError(error.message, hint=error.hint) from None
        reports.write(as_toml(outcome, subject), as_markdown(outcome, subject))
    _sum_up(outcome, files)


def _chosen(risk: int, only: list[str], yes_reading: bool) -> list[Question]:
    if not 1 <= risk <= max(Risk):
        raise InputError(
            f"--risk {risk} is not a risk", hint="use 1 (reading), 2 (no motion), 3 (motion)"
        )
    if yes_reading and risk > Risk.READING:
        raise InputError("--yes-reading is for --risk 1 only", hint="leave one of them out")
    known = {one.id: one for one in questions()}
    for name in only:
        if name not in known:
            raise InputError(f"no question is called {name!r}", hint="see rcx probe --list")
        if known[name].risk > risk:
            hint = f"allow it with --risk {known[name].risk}: {known[name].risk.text}"
            raise InputError(f"{name} can do more than --risk {risk} allows", hint=hint)
    return [one for one in questions() if one.risk <= risk and (not only or one.id in only)]


def _check_date(text: str) -> None:
    if text:
        try:
            calendar.fromisoformat(text)
        except ValueError:
            raise InputError(
                f"--date {text!r:.40} is not a date", hint="write 2030-12-31"
            ) from None


def _list(asked: list[Question]) -> None:
    for risk in Risk:
        mine = [one for one in asked if one.risk is risk]
        if mine:
            print(f"{risk.value}  {risk.text}")
        for one in mine:
            print(f"   {one.id:<22} {one.title}")
            decides = [
                f"{rule} ({', '.join(knobs)})" if knobs else rule
                for rule, knobs in one.decides.items()
            ]
            print(f"   {'':<22} decides {'; '.join(decides)}")
    print("not asked")
    texts = {one.id: one for one in rules()}
    for rule, reason in unasked().items():
        if rule in texts:
            print(f"   {rule:<22} {reason}")


def _agreed(text: str, word: str) -> bool:
    try:
        return input(text).strip().lower() == word
    except EOFError:
        return False


def _confirms(question: Question) -> bool:
    print(f"\n{question.id}: {question.title}")
    print(f"  Risk {question.risk.value}, {question.risk.text}.")
    if question.does:
        print(f"  {question.does}")
    if question.person:
        print(f"  You are asked to {question.person}.")
    if question.risk is Risk.MOTION:
        return _agreed('  Type "move" to do this step; anything else leaves it out: ', "move")
    return _agreed("  Do it? [y/N] ", "y")


def _does(text: str, event: str) -> bool:
    del event
    return not _agreed(f"  {text} Then Enter (n: I will not). ", "n")


_AT_TERMINAL = Person(_confirms, _does, lambda line: print(line, flush=True))
_NOBODY = Person(
    lambda question: question.risk is Risk.READING and not question.person,
    lambda text, event: False,
    lambda line: print(line, flush=True),
)


def _sum_up(outcome: Outcome, files: list[Path]) -> None:
    every = verdicts(outcome)
    print()
    for kind in ("confirmed", "confirmed in part", "refuted", "not asked"):
        print(f"{sum(one.verdict == kind for one in every):4}  {kind}")
    print(f"written: {', '.join(map(str, files))}")
    if outcome.ended:
        print(f"rcx: {outcome.ended}; all inputs are OFF", file=sys.stderr)
        raise typer.Exit(130 if "Ctrl-C" in outcome.ended else 1)
    if any(one.verdict == "refuted" for one in every):
        raise typer.Exit(1)
