"""The translation of a Sequential Function Chart of Logix to Structured Text.

A scan executes the actions of the active steps, and then evaluates the transitions below them. The
steps below a transition that is TRUE are executed in the next scan. The bits of steps and actions
are members of their tags, so that other routines can read them.

Source: Rockwell 1756-PM006, sequential function charts, for a controller that executes the current
active steps only, and does not scan a step again when it is left.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from structured_text.errors import InputError
from structured_text.language.source import Line
from structured_text.projects.model import Lines, in_comment
from structured_text.projects.rockwell.body import translated
from structured_text.projects.rockwell.charts.model import Action, Chart, Step, Transition
from structured_text.projects.rockwell.data import Data, First
from structured_text.projects.rockwell.expression_reader import (
    ExpressionReader,
    tokens_of,
)
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.operands import OperandReader
from structured_text.projects.rockwell.prescan import jumps_in

__all__ = ["translated_chart"]

_INDENT = "  "
_LONGEST = 92
#: The preset of the timers of steps and actions, which only measure.
_MOST = 2147483647
#: Members of tags that other statements may read or write.
_KNOWN = {
    "SFC_STEP": {"X", "T", "DN", "PRE", "FS", "COUNT"},
    "SFC_STOP": {"X", "COUNT"},
    "SFC_ACTION": {"A", "Q", "PRE"},
}
_STORED = ("S", "SD", "DS", "SL")
#: Options of a controller for all charts, with the value that is supported: its default.
_OPTIONS = {
    "SFCExecutionControl": ("CurrentActive", "the execution control"),
    "SFCLastScan": ("DontScan", "the last scan of active steps"),
}
_RESTARTS = ("MostRecent", "InitialStep")


def translated_chart(chart: Chart, body: Body, options: Mapping[str, str]) -> Lines:
    """Return the statements of a chart, or raise LadderError that names the element.

    `options` has the attributes of the controller. Without them, its defaults are assumed.
    """
    for name, (value, said) in _OPTIONS.items():
        if options.get(name, value) != value:
            text = f"{said} of charts is {options[name]!r:.40}, only {value} is supported"
            raise LadderError(text, chart.at, "change it in the properties of the controller")
    restart = options.get("SFCRestartPosition", _RESTARTS[0])
    if restart not in _RESTARTS:
        text = f"the restart position of charts is {restart!r:.40}"
        raise LadderError(text, chart.at, f"use one of {', '.join(_RESTARTS)}")
    made = _Translation(chart, body)
    lines = tuple(made.lines())
    if restart == "InitialStep":
        body.first.append(First(tuple(made.restarted())))
    return lines


@dataclass
class _Translation:
    chart: Chart
    body: Body
    #: The texts of tags, by their names in upper case.
    tags: dict[str, str] = field(default_factory=dict)
    #: Timers of steps, by their tags; and variables with X of the last execution.
    timers: dict[str, str] = field(default_factory=dict)
    befores: dict[str, str] = field(default_factory=dict)
    #: The statements of each action, translated.
    bodies: dict[str, Lines] = field(default_factory=dict)

    # --- tags -----------------------------------------------------------------------------

    def _check_tags(self) -> None:
        seen: set[str] = set()
        for step in self.chart.steps:
            kind = "SFC_STOP" if step.stop else "SFC_STEP"
            self._know(step.tag, kind, f"the {'stop' if step.stop else 'step'}", step.at)
            if step.tag.upper() in seen:
                text = f"two steps have the tag {step.tag}"
                raise LadderError(text, step.at, "give each step a tag of its own")
            seen.add(step.tag.upper())
            for action in step.actions:
                self._know(action.tag, "SFC_ACTION", "the action", action.at)
        for one in self.chart.transitions:
            data = self.body.routine.tags.get(one.tag.upper())
            if one.tag.upper() in self.tags:
                text = f"two elements have the tag {one.tag}"
                raise LadderError(text, one.at, "give each element a tag of its own")
            if data == Data("BOOL") and one.tag.upper() not in self.body.routine.aliases:
                self.tags[one.tag.upper()] = self._read(one.tag, one.at)[0]
            else:
                self.tags[one.tag.upper()] = self.body.variable(f"Fires_{one.tag.strip('_')}")

    def _know(self, tag: str, kind: str, what: str, at: int) -> None:
        text, data = self._read(tag, at)
        if data.type.upper() != kind or data.sizes:
            raise LadderError(f"{what} {tag} is not a tag of the type {kind}", at, "declare it")
        for member in self._used(tag):
            if member not in _KNOWN[kind]:
                message = f"{what} {tag}: its member {member} is used, and is not supported"
                raise LadderError(message, at, f"supported are {', '.join(sorted(_KNOWN[kind]))}")
        self.tags[tag.upper()] = text

    def _read(self, tag: str, at: int) -> tuple[str, Data]:
        return OperandReader(tag, at, self.body.routine).tag()

    def _used(self, tag: str) -> set[str]:
        """Return the members of a tag that the routines of the file mention, in upper case."""
        return self.body.routine.types.used.get(tag.upper(), set())

    def _x(self, tag: str) -> str:
        return f"{self.tags[tag.upper()]}.X"

    # --- parts of a scan ------------------------------------------------------------------

    def lines(self) -> Iterator[Line]:
        chart = self.chart
        self._check_tags()
        for step in chart.steps:
            self._add_variables(step)
        yield from self._begun()
        for step in chart.steps:
            yield from _of(f"step {step.tag}", step.at, self._measured(step))
        for name in self._actions():
            yield from self._executed(name)
        for step in chart.steps:
            yield from _of(f"step {step.tag}", step.at, self._remembered(step))
        for one in chart.transitions:
            yield from self._evaluated(one)
        for one in chart.transitions:
            yield from self._left(one)
        for one in chart.transitions:
            yield from _of(f"transition {one.tag}", one.at, self._entered(one))

    def _add_variables(self, step: Step) -> None:
        if step.stop:
            return
        qualifiers = {action.qualifier for action in step.actions}
        used = self._used(step.tag)
        if {"T", "DN"} & used or {"L", "D", "DS"} & qualifiers:
            self.timers[step.tag] = self._timer(step.tag)
        if "FS" in used or {"P", "P1"} & qualifiers:
            self.befores[step.tag] = self.body.variable(f"Was_{step.tag}", kept=True)

    def _timer(self, name: str) -> str:
        self.body.routine.needs.add("FBD_TIMER")
        return self.body.variable(f"Time_{name}", "FBD_TIMER", kept=True)

    def _begun(self) -> Iterator[Line]:
        """Yield the activation of the initial step: at the start, no step is active."""
        initial = next(step for step in self.chart.steps if step.initial)
        active = " OR ".join(self._x(step.tag) for step in self.chart.steps)
        texts = [
            "(* The chart begins with its initial step *)",
            *_wrapped(f"IF NOT ({active}) THEN"),
            f"  {self._x(initial.tag)} := TRUE;",
            *(f"  {text}" for text in self._counted(initial)),
            "END_IF;",
        ]
        yield from _of(f"step {initial.tag}", initial.at, texts)

    def _counted(self, step: Step) -> Iterator[str]:
        tag = self.tags[step.tag.upper()]
        if "COUNT" in self._used(step.tag):
            yield f"{tag}.Count := {tag}.Count + 1;"

    def _measured(self, step: Step) -> Iterator[str]:
        """Yield the time of a step, and its bit for the first scan."""
        tag = self.tags[step.tag.upper()]
        if step.tag in self.timers:
            timer = self.timers[step.tag]
            yield f"{timer}(TimerEnable := {tag}.X, PRE := {_MOST});"
            yield f"IF {tag}.X THEN"
            yield f"  {tag}.T := {timer}.ACC;"
            yield f"  {tag}.DN := {tag}.T >= {tag}.PRE;"
            yield "END_IF;"
        if "FS" in self._used(step.tag):
            yield f"{tag}.FS := {tag}.X AND NOT {self.befores[step.tag]};"

    def _remembered(self, step: Step) -> Iterator[str]:
        if "FS" in self._used(step.tag):
            yield f"{self.tags[step.tag.upper()]}.FS := FALSE;"
        if step.tag in self.befores:
            yield f"{self.befores[step.tag]} := {self._x(step.tag)};"

    # --- actions --------------------------------------------------------------------------

    def _actions(self) -> dict[str, list[tuple[Step, Action]]]:
        """Return the actions by their tags in upper case, each with the steps that have it."""
        found: dict[str, list[tuple[Step, Action]]] = {}
        for step in self.chart.steps:
            for action in step.actions:
                found.setdefault(action.tag.upper(), []).append((step, action))
        return found

    def _executed(self, name: str) -> Iterator[Line]:
        """Yield the bit Q of an action, and its statements."""
        some = self._actions()[name]
        first = some[0][1]
        network = f"action {first.tag}"
        tag = self.tags[name]
        said = ", ".join(f"{action.qualifier} in {step.tag}" for step, action in some)
        texts = [f"(* Action {in_comment(first.tag)}: {said} *)"]
        terms = []
        for step, action in some:
            stored = self._stored(step, action, some)
            texts += stored[0]
            if stored[1]:
                terms.append(stored[1])
        resets = [self._x(step.tag) for step, action in some if action.qualifier == "R"]
        value = " OR ".join(terms) or "FALSE"
        if terms and resets:
            value = f"({value})" if len(terms) > 1 else value
            value += "".join(f" AND NOT {reset}" for reset in resets)
        texts += _wrapped(f"{tag}.Q := {value};")
        texts += self._shown(some)
        yield from _of(network, first.at, texts)
        body = self._body(name)
        if body and terms:
            yield from _of(network, first.at, [f"IF {tag}.Q THEN"])
            yield from _indented(body, network)
            yield from _of(network, first.at, ["END_IF;"])

    def _stored(
        self, step: Step, action: Action, some: Sequence[tuple[Step, Action]]
    ) -> tuple[list[str], str]:
        """Return the statements and the condition that an association contributes."""
        active, tag = self._x(step.tag), self.tags[action.tag.upper()]
        time = f"{self.tags[step.tag.upper()]}.T"
        kind = action.qualifier
        if kind in ("N", "R", "P0"):
            return [], active if kind == "N" else ""
        if kind in ("P", "P1"):
            return [], f"{active} AND NOT {self.befores[step.tag]}"
        if kind in ("L", "D"):
            return [], f"{active} AND {time} {'<' if kind == 'L' else '>='} {tag}.PRE"
        resets = [self._x(other.tag) for other, one in some if one.qualifier == "R"]
        stored = self.body.variable(f"Stored_{action.tag}_{step.tag}", kept=True)
        sets = active if kind != "DS" else f"{active} AND {time} >= {tag}.PRE"
        lines = []
        if resets:
            lines += [*_wrapped(f"IF {' OR '.join(resets)} THEN"), f"  {stored} := FALSE;"]
        lines += [f"{'ELSIF' if resets else 'IF'} {sets} THEN", f"  {stored} := TRUE;", "END_IF;"]
        if kind in ("S", "DS"):
            return lines, stored
        timer = self._timer(f"{action.tag}_{step.tag}")
        lines.append(f"{timer}(TimerEnable := {stored}, PRE := {_MOST});")
        sign = ">=" if kind == "SD" else "<"
        return lines, f"{stored} AND {timer}.ACC {sign} {tag}.PRE"

    def _shown(self, some: Sequence[tuple[Step, Action]]) -> Iterator[str]:
        """Yield the tags that show the bit Q of an action."""
        tag = self.tags[some[0][1].tag.upper()]
        if "A" in self._used(some[0][1].tag):
            yield f"{tag}.A := {tag}.Q;"
        for action in dict.fromkeys(action for _, action in some if action.indicator):
            text, data = self._read(action.indicator, action.at)
            if data != Data("BOOL"):
                message = f"the action {action.tag}: its indicator {text} is not a BOOL"
                raise LadderError(message, action.at, "use a tag of the type BOOL")
            yield f"{text} := {tag}.Q;"

    def _body(self, name: str) -> Lines:
        """Return the translated statements of an action; they belong to one of its steps."""
        if name not in self.bodies:
            given = [action for _, action in self._actions()[name] if action.body]
            lines: Lines = ()
            if given:
                routine = self.body.routine
                before = len(routine.notes)
                try:
                    lines = translated(given[0].body, routine)
                except InputError as error:
                    text = f"the action {given[0].tag}: {error.message}"
                    raise LadderError(text, error.line or given[0].at, error.hint) from None
                self.body.notes += routine.notes[before:]
                self.body.first += jumps_in(tokens_of(given[0].body))
                self.body.first += [First((line,)) for line in routine.take_cleared()]
            if len(given) > 1:
                text = f"two steps have statements for the action {given[0].tag}"
                raise LadderError(text, given[1].at, "give each action a tag of its own")
            self.bodies[name] = lines
        return self.bodies[name]

    # --- transitions ----------------------------------------------------------------------

    def _evaluated(self, one: Transition) -> Iterator[Line]:
        network, fires = f"transition {one.tag}", self.tags[one.tag.upper()]
        rivals = [f"NOT {self.tags[tag.upper()]}" for tag in dict.fromkeys(one.rivals)]
        guards = " AND ".join([*(self._x(tag) for tag in one.sources), *rivals])
        way = f"{', '.join(one.sources)} -> {', '.join(one.targets)}"
        texts = [
            *_wrapped(f"(* Transition {one.tag}: {in_comment(way)} *)", " "),
            f"{fires} := FALSE;",
            *_wrapped(f"IF {guards} THEN", " AND "),
            *_wrapped(f"  {fires} := {self._condition(one)};", " AND "),
            "END_IF;",
        ]
        yield from _of(network, one.at, texts)

    def _condition(self, one: Transition) -> str:
        place = f"the condition of the transition {one.tag}"
        tokens = tokens_of(one.condition)
        if not tokens:
            raise LadderError(f"{place} is empty", one.at, "write 1 if it is always TRUE")
        if tokens[0].word == "JSR":
            text = f"{place} calls a routine, which is not supported"
            raise LadderError(text, tokens[0].at, "write the condition as an expression")
        try:
            return _Condition(tokens, one.condition[-1].at, self.body.routine).text()
        except InputError as error:
            raise LadderError(
                f"{place}: {error.message}", error.line or one.at, error.hint
            ) from None

    def _left(self, one: Transition) -> Iterator[Line]:
        """Yield what happens when a transition is TRUE to the steps above it."""
        network = f"transition {one.tag}"
        texts = [f"IF {self.tags[one.tag.upper()]} THEN"]
        pulses = []
        for tag in one.sources:
            texts.append(f"  {self._x(tag)} := FALSE;")
            step = next(step for step in self.chart.steps if step.tag.upper() == tag.upper())
            for action in step.actions:
                some = self._actions()[action.tag.upper()]
                if action.qualifier in ("P", "P0"):
                    pulses.append(action)
                elif len(some) == 1 and action.qualifier in ("N", "L", "D", "P1"):
                    texts.append(f"  {self.tags[action.tag.upper()]}.Q := FALSE;")
                    texts += [f"  {text}" for text in self._shown(some)]
        yield from _of(network, one.at, texts)
        for action in pulses:
            yield from _indented(self._body(action.tag.upper()), f"action {action.tag}")
        yield from _of(network, one.at, ["END_IF;"])

    def _entered(self, one: Transition) -> Iterator[str]:
        yield f"IF {self.tags[one.tag.upper()]} THEN"
        for tag in one.targets:
            step = next(step for step in self.chart.steps if step.tag.upper() == tag.upper())
            plain = self.tags[tag.upper()]
            yield f"  {plain}.X := TRUE;"
            yield from (f"  {text}" for text in self._counted(step))
            if step.tag in self.timers:
                yield f"  {plain}.T := 0;"
                yield f"  {plain}.DN := FALSE;"
                yield f"  {self.timers[step.tag]}(TimerEnable := FALSE, PRE := {_MOST});"
            if step.tag in self.befores:
                yield f"  {self.befores[step.tag]} := FALSE;"
        yield "END_IF;"

    def restarted(self) -> Iterator[str]:
        """Yield the statements of the prescan for a chart that restarts at its initial step."""
        for step in self.chart.steps:
            yield f"{self._x(step.tag)} := FALSE;"
            if "COUNT" in self._used(step.tag):
                yield f"{self.tags[step.tag.upper()]}.Count := 0;"


class _Condition(ExpressionReader):
    """The reader of a condition; a semicolon may be behind it."""

    def text(self) -> str:
        text = self._condition()
        self._take(";")
        token = self._peek()
        if token.kind != "end":
            raise self._error(f"{token.text!r} is not expected here", token)
        return text


def _of(network: str, at: int, texts: Iterator[str] | Sequence[str]) -> Iterator[Line]:
    for text in texts:
        yield Line(f"{_INDENT}{text}", at, network=network)


def _indented(lines: Lines, network: str) -> Iterator[Line]:
    for line in lines:
        yield replace(line, text=f"{_INDENT}{line.text}", network=network)


def _wrapped(text: str, sign: str = " OR ") -> list[str]:
    """Return a text in several lines if it is long, broken before an operator."""
    first, *others = text.split(sign)
    lines, line = [], first
    for part in others:
        if len(line) + len(sign) + len(part) > _LONGEST:
            lines.append(line)
            line = f"  {sign.lstrip()}{part}" if sign.strip() else f"  {part}"
        else:
            line += f"{sign}{part}"
    return [*lines, line]
