"""The chart of a routine in an L5X: steps, transitions, branches and links.

Source: Rockwell 1756-RM084, sequential function chart routines.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from structured_text.language.source import Line
from structured_text.projects.rockwell.charts.model import (
    QUALIFIERS,
    Action,
    Chart,
    Step,
    Transition,
)
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.xml import Element

__all__ = ["read_chart"]

_IGNORED = ("TextBox", "Attachment", "Description", "CustomProperties")
_ENDS = ("Step", "Stop")


def read_chart(content: Element) -> Chart:
    """Return the chart of a `SFCContent`, or raise LadderError that names the element."""
    return _Reader(content).chart()


class _Reader:
    def __init__(self, content: Element) -> None:
        self._content = content
        self._elements: dict[str, Element] = {}
        self._branch_of: dict[str, Element] = {}
        self._below: dict[str, list[str]] = {}
        self._above: dict[str, list[str]] = {}
        for one in content.children:
            if one.name == "DirectedLink":
                self._link(one.get("FromID"), one.get("ToID"))
                continue
            if one.name in ("SbrRet", "Sbr", "Ret"):
                text = f"the element {one.name} with parameters of the routine is not supported"
                raise LadderError(text, one.at, "pass the values by tags")
            if one.name not in (*_ENDS, "Transition", "Branch", *_IGNORED):
                text = f"the element {one.name:.40} is not known"
                raise LadderError(text, one.at, "remove it, or write the routine as text")
            if one.name not in _IGNORED:
                self._add(one.get("ID"), one)
            if one.name == "Branch":
                for leg in one.all("Leg"):
                    self._add(leg.get("ID"), leg)
                    self._branch_of[leg.get("ID")] = one
                    ends = (one.get("ID"), leg.get("ID"))
                    diverges = one.get("BranchFlow") == "Diverge"
                    self._link(*(ends if diverges else reversed(ends)))

    def _add(self, key: str, element: Element) -> None:
        if key in self._elements:
            text = f"two elements have the number {key}"
            raise LadderError(text, element.at, "export the routine again")
        self._elements[key] = element

    def _link(self, source: str, target: str) -> None:
        self._below.setdefault(source, []).append(target)
        self._above.setdefault(target, []).append(source)

    def _all(self, *names: str) -> list[Element]:
        return [one for one in self._content.children if one.name in names]

    def chart(self) -> Chart:
        """Return the chart."""
        for key, others in self._below.items():
            for end in (key, *others):
                if end not in self._elements:
                    text = f"a link ends at the element {end!r:.20}, which is not in the chart"
                    raise LadderError(text, self._content.at, "draw the link again")
        for one in self._all("Branch"):
            if one.get("Priority") not in ("", "Default"):
                text = f"a selection with the priority {one.get('Priority')!r:.20} is not supported"
                raise LadderError(text, one.at, "order its branches from left to right")
        steps = tuple(self._step(one) for one in self._all(*_ENDS))
        initial = [step for step in steps if step.initial]
        if len(initial) != 1:
            at = initial[1].at if initial else self._content.at
            text = f"a chart has exactly one initial step, this chart has {len(initial)}"
            raise LadderError(text, at, "make one step the initial step")
        found = {one.tag.upper(): one for one in map(self._transition, self._all("Transition"))}
        ordered: dict[str, Transition] = {}
        for made in found.values():  # a transition is evaluated behind those that are left of it
            for tag in (*made.rivals, made.tag):
                ordered.setdefault(tag.upper(), found[tag.upper()])
        return Chart(steps, tuple(ordered.values()), self._content.at)

    def _step(self, element: Element) -> Step:
        tag = _tag(element)
        for name in ("Preset", "LimitHigh", "LimitLow"):
            if element.get(f"{name}UsesExpr") == "true":
                text = f"the step {tag}: the expression for {name} is not supported"
                raise LadderError(text, element.at, "assign the value in an action")
        actions = tuple(_action(one, tag) for one in element.all("Action"))
        initial = element.get("InitialStep") == "true"
        if element.name == "Stop" and self._below.get(element.get("ID")):
            raise LadderError(f"something follows the stop {tag}", element.at, "remove the link")
        return Step(tag, initial, element.name == "Stop", actions, element.at)

    def _transition(self, element: Element) -> Transition:
        tag, key = _tag(element), element.get("ID")
        sources = list(self._ends(key, self._above, "Converge", tag))
        targets = list(self._ends(key, self._below, "Diverge", tag))
        if not sources or not targets:
            way = "above" if not sources else "below"
            text = f"the transition {tag} has no step {way} it"
            raise LadderError(text, element.at, "connect it to a step")
        for one in sources:
            if one.name != "Step":
                text = f"the transition {tag} follows a {one.name.lower()}, not a step"
                raise LadderError(text, element.at, "put a step between them")
        for one in targets:
            if one.name not in _ENDS:
                text = f"the transition {tag} leads to another {one.name.lower()}, not to a step"
                raise LadderError(text, element.at, "put a step between them")
        condition = _lines(element.all("Condition", "STContent", "Line"))
        if element.all("Condition", "RLLContent") or element.all("Condition", "FBDContent"):
            text = f"the condition of the transition {tag} is not in Structured Text"
            raise LadderError(text, element.at, "write it as text")
        return Transition(
            tag,
            tuple(_tag(one) for one in sources),
            tuple(_tag(one) for one in targets),
            tuple(condition),
            tuple(self._rivals(element, sources)),
            element.at,
        )

    def _ends(
        self, key: str, links: dict[str, list[str]], flow: str, tag: str
    ) -> Iterator[Element]:
        """Yield the elements above or below a transition, through its branches.

        Only a simultaneous branch joins several steps; a selection has transitions in its legs.
        """
        waiting, seen = list(links.get(key, ())), {key}
        while waiting:
            end = waiting.pop(0)
            if end in seen:
                continue
            seen.add(end)
            element = self._elements[end]
            if element.name not in ("Branch", "Leg"):
                yield element
                continue
            branch = self._branch_of.get(end, element)
            simultaneous = branch.get("BranchType") == "Simultaneous"
            if simultaneous != (branch.get("BranchFlow") == flow):
                text = f"the transition {tag} is connected to a branch that does not fit"
                raise LadderError(text, branch.at, "put a step between them")
            waiting[:0] = links.get(end, ())

    def _rivals(self, element: Element, sources: Sequence[Element]) -> Iterator[str]:
        """Yield the transitions that are evaluated before this one: from left to right."""
        for step in sources:
            for other in self._first_below(step.get("ID")):
                if other is element:
                    break
                yield _tag(other)

    def _first_below(self, key: str) -> Iterator[Element]:
        """Yield the transitions below a step, in the order of the legs."""
        waiting, seen = list(self._below.get(key, ())), {key}
        while waiting:
            end = waiting.pop(0)
            if end in seen:
                continue
            seen.add(end)
            element = self._elements[end]
            if element.name == "Transition":
                yield element
            elif element.name in ("Branch", "Leg"):
                waiting[:0] = self._below.get(end, ())


def _action(element: Element, step: str) -> Action:
    tag = element.get("Operand").strip()
    place = f"the action {tag} of the step {step}"
    given = element.get("Qualifier")
    if given not in QUALIFIERS:
        text = f"{place} has the qualifier {given!r:.40}, which is not known"
        raise LadderError(text, element.at, f"use one of {', '.join(QUALIFIERS)}")
    if not tag:
        raise LadderError(f"an action of the step {step} has no tag", element.at, "complete it")
    if element.get("PresetUsesExpr") == "true":
        text = f"{place}: the expression for the preset is not supported"
        raise LadderError(text, element.at, "assign the value in another action")
    for one in element.all("Body"):
        for content in one.children:
            if content.name != "STContent":
                text = f"{place} is not in Structured Text"
                raise LadderError(text, content.at, "write it as text")
    body = _lines(element.all("Body", "STContent", "Line"))
    indicator = element.get("IndicatorTag").strip()
    return Action(tag, QUALIFIERS[given], tuple(body), indicator, element.at)


def _lines(elements: Sequence[Element]) -> list[Line]:
    return [line for one in elements for line in one.lines() if line.text.strip()]


def _tag(element: Element) -> str:
    tag = element.get("Operand").strip()
    if not tag:
        text = f"a {element.name.lower()} has no tag"
        raise LadderError(text, element.at, "complete it in its tool")
    return tag
