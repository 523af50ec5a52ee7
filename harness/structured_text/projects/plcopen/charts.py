"""Sequential Function Charts of PLCopen XML.

Supported are steps, transitions, divergences and convergences, jumps and action blocks. A condition
is an inline expression, names a transition of the POU, or is connected to networks in the chart. An
action is inline, or names an action or a Boolean variable of the POU. Transitions and actions are
in Structured Text, LD or FBD.

Source: PLCopen TC6 XML 2.01, sfcObjects.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.check import DiagramError
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.diagrams.sfc.check import ChartError, check
from structured_text.projects.diagrams.sfc.model import (
    QUALIFIERS,
    TIMED,
    Action,
    Association,
    Chart,
    Step,
    Transition,
)
from structured_text.projects.model import Foreign, Lines
from structured_text.projects.plcopen.conditions import Diagrams
from structured_text.projects.plcopen.networks import Drawn
from structured_text.projects.xml import Element

__all__ = ["read_chart"]

_PASSED = (
    *("selectionDivergence", "selectionConvergence"),
    *("simultaneousDivergence", "simultaneousConvergence"),
)
_KNOWN = ("step", "transition", "jumpStep", "actionBlock", *_PASSED)
_IGNORED = ("comment", "vendorElement", "addData", "documentation")

#: A function that returns the lines of an element with text.
_Text = Callable[[Element], Lines]


def read_chart(
    body: Element,
    actions: Mapping[str, Lines | Foreign],
    transitions: Mapping[str, Lines | Foreign],
    text: _Text,
    diagrams: Diagrams,
) -> Chart | Foreign:
    """Return the chart of an `<SFC>`, or the reason why it is not read.

    `actions` and `transitions` have the bodies that the POU declares, by name in upper case; the
    actions are translated. `diagrams` translates the diagrams in the chart.
    """
    try:
        chart = _Reader(body, actions, transitions, text, diagrams).chart()
        check(chart)
    except (ChartError, DiagramError) as error:
        hint = f" ({error.hint})" if error.hint else ""
        return Foreign("SFC", error.at, f"{error.message}{hint}")
    return chart


class _Reader:
    def __init__(
        self,
        body: Element,
        actions: Mapping[str, Lines | Foreign],
        transitions: Mapping[str, Lines | Foreign],
        text: _Text,
        diagrams: Diagrams,
    ) -> None:
        self._body, self._bodies, self._named, self._text = body, actions, transitions, text
        self._diagrams = diagrams
        self._ids = {one.get("localId"): one for one in body.children if one.get("localId")}
        self._actions: dict[str, Action] = {}

    def chart(self) -> Chart:
        for one in self._body.children:
            if one.name == "macroStep":
                text = f"the macro step {one.get('name')} is not supported"
                raise ChartError(text, one.at, "draw its steps into the chart")
        blocks = self._blocks()
        steps = [self._step(one, blocks.get(id(one), ())) for one in self._all("step")]
        targets = self._targets()
        order = {step.name.upper(): number for number, step in enumerate(steps)}
        found: list[tuple[int, float, Transition]] = []
        for one in self._all("transition"):
            made = self._transition(one, tuple(targets.get(id(one), ())))
            found.append((order.get(made.sources[0].upper(), 0), _x(one), made))
        found.sort(key=lambda one: one[:2])
        transitions = tuple(one for _, _, one in found)
        self._diagrams.finish()
        if self._diagrams.blocks:
            steps = self._with_blocks(steps)
        before = tuple(self._diagrams.before)
        return Chart(tuple(steps), transitions, tuple(self._actions.values()), before)

    def _with_blocks(self, steps: list[Step]) -> list[Step]:
        """Return the steps; the initial step starts the action with the blocks of conditions."""
        name, number = "ComputeBlocks", 2
        taken = {step.name.upper() for step in steps} | set(self._actions) | set(self._bodies)
        while name.upper() in taken:
            name, number = f"ComputeBlocks{number}", number + 1
        lines = tuple(self._diagrams.blocks)
        self._actions[name.upper()] = Action(name, lines, lines[0].at)
        start = Association(name, "S", at=lines[0].at)
        return [
            replace(step, associations=(*step.associations, start)) if step.initial else step
            for step in steps
        ]

    def _all(self, name: str) -> list[Element]:
        return [one for one in self._body.children if one.name == name]

    # --- connections ---

    def _inputs(self, element: Element) -> Iterator[Element]:
        """Yield the elements that an element is connected to at its upper side."""
        for point in element.all("connectionPointIn"):
            for one in point.all("connection"):
                above = self._ids.get(one.get("refLocalId"))
                if above is not None:
                    yield above

    def _above(self, element: Element, seen: tuple[int, ...] = ()) -> Iterator[Element]:
        """Yield the steps and transitions above an element, through divergences."""
        for one in self._inputs(element):
            if one.name in _PASSED and id(one) not in seen:
                yield from self._above(one, (*seen, id(one)))
            elif one.name == "jumpStep" and seen:
                continue  # CODESYS connects a branch that ends with a jump to the convergence, too
            elif one.name not in _PASSED:
                yield one

    def _targets(self) -> dict[int, list[str]]:
        """Return the names of the steps below each transition."""
        found: dict[int, list[str]] = {}
        for one in (*self._all("step"), *self._all("jumpStep")):
            name = one.get("name") if one.name == "step" else one.get("targetName")
            for above in self._above(one):
                if above.name != "transition":
                    text = f"the step {name} is connected to a {above.name} and not a transition"
                    raise ChartError(text, one.at, "put a transition between two steps")
                found.setdefault(id(above), []).append(name)
        return found

    # --- elements ---

    def _step(self, element: Element, associations: tuple[Association, ...]) -> Step:
        name = element.get("name")
        if not re.fullmatch(r"[^\W\d]\w*", name):
            raise ChartError(f"{name!r} is not the name of a step", element.at, "rename it")
        if any(map(_is_action, _descendants(element.all("addData")))):
            raise ChartError(
                f"the step {name} has an entry, exit or main action of the tool",
                element.at,
                "write it as an action block",
            )
        initial = element.get("initialStep") in ("true", "1")
        return Step(name, initial, associations, element.at)

    def _blocks(self) -> dict[int, tuple[Association, ...]]:
        """Return the associations of each step."""
        found: dict[int, tuple[Association, ...]] = {}
        for block in self._all("actionBlock"):
            steps = [one for one in self._inputs(block) if one.name == "step"]
            if not steps:
                text = "an action block is not connected to a step"
                raise ChartError(text, block.at, "connect it, or remove it")
            for step in steps:
                old = found.get(id(step), ())
                made = tuple(self._associations(block, step.get("name"), len(old)))
                found[id(step)] = (*old, *made)
        return found

    def _associations(self, block: Element, step: str, before: int) -> Iterator[Association]:
        for number, one in enumerate(block.all("action"), before + 1):
            qualifier = one.get("qualifier", "N").upper() or "N"
            if qualifier not in QUALIFIERS:
                text = f"{qualifier} in the step {step} is not a qualifier"
                raise ChartError(text, one.at, f"use one of {', '.join(QUALIFIERS)}")
            time = one.get("duration")
            if qualifier in TIMED and not time:
                text = f"an action with {qualifier} in the step {step} has no time"
                raise ChartError(text, one.at, "give it a duration")
            reference, inline = one.first("reference"), one.first("inline")
            if reference is not None:
                name = reference.get("name")
                self._refer(name, one)
            elif inline is not None:
                name = f"{step}_Inline{number}"
                drawn = inline.first("LD") or inline.first("FBD")
                what = f"an action of the step {step}"
                body = self._diagrams.statements(drawn) if drawn else self._inline(inline, what)
                self._actions[name.upper()] = Action(name, body, one.at)
            else:
                text = f"an action of the step {step} has neither a name nor statements"
                raise ChartError(text, one.at, "give it a name")
            yield Association(name, qualifier, time if qualifier in TIMED else "", one.at)

    def _refer(self, name: str, at: Element) -> None:
        """Add the action of a name, unless the name belongs to a variable."""
        body = self._bodies.get(name.upper())
        if isinstance(body, Foreign):
            raise ChartError(f"the action {name} {body.says}", body.at, "")
        if body is not None:
            self._actions.setdefault(name.upper(), Action(name, body, at.at))

    def _inline(self, element: Element, what: str) -> Lines:
        found = [one for one in element.children if one.name not in _IGNORED]
        if len(found) != 1 or found[0].name != "ST":
            language = found[0].name if found else "no language"
            hint = "write it in Structured Text"
            raise ChartError(f"{what} is in {language} and is not read", element.at, hint)
        return self._text(found[0])

    def _transition(self, element: Element, targets: tuple[str, ...]) -> Transition:
        above = list(self._above(element))
        steps = [one.get("name") for one in above if one.name == "step"]
        if not steps or len(steps) != len(above):
            text = "a transition is not connected to a step above it"
            raise ChartError(text, element.at, "connect it to a step")
        if not targets:
            text = f"the transition behind {', '.join(steps)} leads to no step"
            raise ChartError(text, element.at, "connect it to a step or a jump")
        priority = element.get("priority")
        made = Transition(
            tuple(steps),
            tuple(dict.fromkeys(targets)),
            (),
            int(priority) if priority.isdigit() and int(priority) else None,
            at=element.at,
        )
        what = f"the condition of the transition {made.label}"
        lines, name = self._condition(element, what)
        condition = _expression(lines)
        if not condition:
            raise ChartError(f"{what} is empty", element.at, "write TRUE if it always fires")
        return replace(made, condition=condition, name=name)

    def _condition(self, element: Element, what: str) -> tuple[Lines, str]:
        condition = element.first("condition")
        if condition is None:
            return (), ""
        reference, inline = condition.first("reference"), condition.first("inline")
        if inline is not None:
            drawn = inline.first("LD") or inline.first("FBD")
            if drawn is None:
                return self._inline(inline, what), ""
            name = inline.get("name")
            return self._result(self._diagrams.read(drawn), name, condition), name
        if reference is not None:
            name = reference.get("name")
            body = self._named.get(name.upper())
            if isinstance(body, Drawn):
                return self._result(body.diagram, name, condition), name
            if isinstance(body, Foreign):
                raise ChartError(f"the transition {name} {body.says}", body.at, "")
            # A name that is not a transition of the POU is a Boolean variable.
            return (body, name) if body is not None else ((Line(name, condition.at),), "")
        if any(condition.below("connection")):
            variable = self._diagrams.connected(element, condition)
            return (Line(variable, condition.at),), ""
        return (), ""

    def _result(self, diagram: Diagram, name: str, condition: Element) -> Lines:
        """Return the condition of a transition that is assigned in its own diagram."""
        return (Line(self._diagrams.result(diagram, name, condition.at), condition.at),)


def _expression(lines: Lines) -> Lines:
    """Return the lines of a condition without := before it and ; behind it."""
    found = list(lines)
    while found and not re.sub(r"^\s*:=", "", found[0].text).strip():
        del found[0]
    while found and not re.sub(r";\s*$", "", found[-1].text).strip():
        found.pop()
    if found:
        found[0] = replace(found[0], text=re.sub(r"^\s*:=", "", found[0].text))
        found[-1] = replace(found[-1], text=re.sub(r"\s*;\s*$", "", found[-1].text))
    return tuple(found)


def _x(element: Element) -> float:
    position = element.first("position")
    try:
        return float(position.get("x", "0")) if position is not None else 0.0
    except ValueError:
        return 0.0


def _descendants(elements: Iterable[Element]) -> Iterator[Element]:
    """Yield the elements and all elements below them."""
    for element in elements:
        yield element
        yield from _descendants(element.children)


def _is_action(element: Element) -> bool:
    """Return whether the name or an attribute of an element is about an action."""
    return any("action" in text.lower() for text in (element.name, *element.attributes.values()))
