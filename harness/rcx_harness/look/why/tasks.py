"""What the tasks of robot programs wait for."""

from __future__ import annotations

import re

from rcx_harness.look.why.causes import Step
from rcx_harness.look.why.conditions import SHORT_US, Found, of_moment
from rcx_harness.look.why.facts import Moment
from rcx_harness.look.why.recorded import input_of

__all__ = ["program_wait"]

_INPUT = re.compile(r"\bSI[WD]?\d*\(\d*\)")


def program_wait(moment: Moment) -> Found | None:
    """Return the chain of the robot program that has been in a WAIT statement for some time."""
    since = moment.own_since("tasks")
    for program, line, state, statement in moment.own("tasks") or ():
        words = statement.upper().split()
        if state != "running" or words[:1] != ["WAIT"] or words[1:2] == ["ARM"]:
            continue
        if moment.t_us is not None and since is not None and moment.t_us - since < SHORT_US:
            continue
        text = f"the robot program {program} waits in line {line}: {statement}"
        step = Step(text, f"{program}:{line}", since, "robot-language.md", moment.controller)
        return of_moment(moment, "robot-program-waits", step, *_inputs(moment, statement))
    return None


def _inputs(moment: Moment, statement: str) -> list[Step]:
    """Return the present values of the inputs of a statement, which the PLC writes."""
    area = moment.own("inputs") or b""
    steps = []
    for name in dict.fromkeys(_INPUT.findall(statement.upper())):
        value = input_of(area, name)
        if value is not None:
            text = f"the PLC writes {name} = {value}"
            steps.append(Step(text, name, None, "ch. 1, 4", moment.controller))
    return steps
