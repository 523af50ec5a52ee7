"""The translation of a chart to statements of Structured Text.

A scan has four parts, as in the standard's evaluation rules. The times of steps are read. All
transitions are evaluated with the steps that are active at this moment. The steps before
transitions that fire become inactive, then the steps behind them become active, so that a step is
left and entered at most once in a scan. Finally the action controls are computed, then actions are
executed.

If several transitions from one step are true, only the first fires: in order of priority, then from
left to right. The initial step is active before the first scan.

Source: IEC 61131-3, 2.6.3 to 2.6.5; action control: figures 15 and 16.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from structured_text.language.source import Line
from structured_text.projects.diagrams.sfc.model import Action, Association, Chart, Step, Transition
from structured_text.projects.diagrams.sfc.names import Names, replaced

__all__ = ["translate"]

#: Preset of the timers of steps. The time of a step stays at this value.
_LONGEST = "T#10d"


def translate(
    chart: Chart, names: Names, *, final_scan: bool = True
) -> tuple[tuple[Line, ...], tuple[Line, ...]]:
    """Return the section with the variables of a chart, and its statements.

    With `final_scan`, an action is executed once more when its control has become FALSE. The
    standard permits both forms (table 45a); matiec has no final scan.
    """
    made = _Translation(chart, names, final_scan)
    lines = tuple(made.lines())
    texts = ["  VAR", *(f"    {text}" for text in made.variables()), "  END_VAR"]
    return tuple(Line(text, chart.steps[0].at) for text in texts), lines


class _Translation:
    def __init__(self, chart: Chart, names: Names, final_scan: bool) -> None:
        self._names, self._final = names, final_scan
        self._steps = [step.name for step in chart.steps]
        self._actions = list(
            dict.fromkeys(one.action for step in chart.steps for one in step.associations)
        )
        self._chart = chart
        self._declared: dict[str, str] = {}
        self._with_pulse: set[str] = set()
        self._controlled: set[str] = set()
        flags = Names("")
        replaced("\n".join(line.text for line in _texts(chart)), self._steps, (), flags)
        self._timed = {
            step.name
            for step in chart.steps
            if flags.has("Time", step.name)
            or any(one.qualifier in ("L", "D", "DS") for one in step.associations)
        }

    # --- parts of a scan ---

    def lines(self) -> Iterator[Line]:
        chart = self._chart
        for step in chart.steps:
            initial = "TRUE" if step.initial else "FALSE"
            self._declared[self._step(step.name)] = f"BOOL := {initial}"
        if self._timed:
            yield from self._elapsed()
        yield from self._substituted(chart.before)
        yield from self._evaluated()
        yield from self._evolved()
        for name in self._actions:
            yield from _of(f"action {name}", *self._control(name))
        yield from self._pulses()
        yield from self._executed()

    def _timer_calls(self) -> Iterator[Line]:
        for step in self._chart.steps:
            if step.name in self._timed:
                timer = self._names.of("Timer", step.name)
                active = self._step(step.name)
                text = f"{timer}(IN := {active}, PT := {_LONGEST});"
                yield Line(text, step.at, network=f"step {step.name}")

    def _elapsed(self) -> Iterator[Line]:
        yield Line("(* Times of the active steps *)", self._chart.steps[0].at)
        yield from self._timer_calls()
        for step in self._chart.steps:
            if step.name in self._timed:
                timer, time = self._names.of("Timer", step.name), self._time(step.name)
                self._declared[timer] = "TON"
                self._declared[time] = "TIME := T#0s"
                yield from _of(
                    f"step {step.name}",
                    Line(f"IF {self._step(step.name)} THEN", step.at),
                    Line(f"  {time} := {timer}.ET;", step.at),
                    Line("END_IF;", step.at),
                )

    def _evaluated(self) -> Iterator[Line]:
        """Yield the evaluation of all transitions, those with a lower priority number first."""
        numbered = list(enumerate(self._chart.transitions, 1))
        numbered.sort(key=lambda one: (one[1].priority is None, one[1].priority or 0))
        before: list[tuple[int, Transition]] = []
        for number, one in numbered:
            fires = self._fires(number)
            self._declared[fires] = "BOOL := FALSE"
            rivals = [n for n, other in before if _share(one.sources, other.sources)]
            active = [self._step(name) for name in one.sources]
            guards = [*active, *(f"NOT {self._fires(n)}" for n in sorted(rivals))]
            lines = [
                Line(f"(* Transition {number}: {_comment(one.label)} *)", one.at),
                Line(f"{fires} := FALSE;", one.at),
                Line(f"IF {' AND '.join(guards)} THEN", one.at),
            ]
            condition = list(self._substituted(one.condition))
            first = f"  {fires} := "
            begin = condition[0].text.lstrip()
            indent = len(condition[0].text) - len(begin)
            shift = condition[0].shift + indent - len(first)
            condition[0] = Line(f"{first}{begin}", condition[0].at, shift)
            last = condition[-1]
            if "//" not in last.text:
                condition[-1] = replace(last, text=f"{last.text.rstrip()};")
            lines += condition
            if "//" in last.text:  # the semicolon would be in the comment
                lines.append(Line("  ;", last.at))
            lines.append(Line("END_IF;", one.at))
            yield from _of(f"transition {number}", *lines)
            before.append((number, one))

    def _evolved(self) -> Iterator[Line]:
        transitions = list(enumerate(self._chart.transitions, 1))
        if transitions:
            yield Line(
                "(* Steps that are left, then steps that are entered *)", transitions[0][1].at
            )
        for number, one in transitions:
            lines = [Line(f"IF {self._fires(number)} THEN", one.at)]
            for name in one.sources:
                lines.append(Line(f"  {self._step(name)} := FALSE;", one.at))
            yield from _of(f"transition {number}", *lines, Line("END_IF;", one.at))
        yield from self._timer_calls()
        for number, one in transitions:
            lines = [Line(f"IF {self._fires(number)} THEN", one.at)]
            for name in one.targets:
                lines.append(Line(f"  {self._step(name)} := TRUE;", one.at))
                if self._canonical(name) in self._timed:
                    lines.append(Line(f"  {self._time(name)} := T#0s;", one.at))
            yield from _of(f"transition {number}", *lines, Line("END_IF;", one.at))
        yield from self._timer_calls()

    def _control(self, name: str) -> Iterator[Line]:
        """Yield the action control of an action."""
        found = [
            (number, step, one)
            for number, (step, one) in enumerate(self._associations(), 1)
            if one.action.upper() == name.upper()
        ]
        at = found[0][2].at
        said = ", ".join(f"{one.qualifier} in {step.name}" for _, step, one in found)
        yield Line(f"(* Action {name}: {_comment(said)} *)", at)
        resets = [self._step(step.name) for _, step, one in found if one.qualifier == "R"]
        reset = " OR ".join(resets)
        terms = []
        for number, step, one in found:
            if one.qualifier in ("S", "SD", "DS", "SL"):
                yield from self._stored(number, step, one, reset)
            term = self._term(number, step, one)
            if term:
                terms.append(term)
        control = self._names.of("Action", name)
        self._declared[control] = "BOOL := FALSE"
        every = list(dict.fromkeys(terms))
        value = " OR ".join(every) or "FALSE"
        if every and resets:
            value = f"({value})" if len(every) > 1 else value
            value += f" AND NOT ({reset})" if len(resets) > 1 else f" AND NOT {reset}"
        if every:
            self._controlled.add(name.upper())
        yield from _wrapped(f"{control} := {value};", at)

    def _stored(self, number: int, step: Step, one: Association, reset: str) -> Iterator[Line]:
        """Yield the memory of a stored action; R is dominant, as in the block RS."""
        stored, active = self._store(number, one), self._step(step.name)
        self._declared[stored] = "BOOL := FALSE"
        if one.qualifier == "DS":
            active = f"{active} AND {self._time(step.name)} >= {self._with_variables(one.time)}"
        if reset:
            yield Line(f"IF {reset} THEN", one.at)
            yield Line(f"  {stored} := FALSE;", one.at)
        yield Line(f"{'ELSIF' if reset else 'IF'} {active} THEN", one.at)
        yield Line(f"  {stored} := TRUE;", one.at)
        yield Line("END_IF;", one.at)
        if one.qualifier in ("SD", "SL"):
            timer = self._names.of("StoredTimer", f"{number}_{one.action}")
            self._declared[timer] = "TON"
            time = self._with_variables(one.time)
            yield Line(f"{timer}(IN := {stored}, PT := {time});", one.at)

    def _term(self, number: int, step: Step, one: Association) -> str:
        """Return the part of an action control that one association contributes; may be empty."""
        active, time = self._step(step.name), self._with_variables(one.time)
        timer = self._names.of("StoredTimer", f"{number}_{one.action}")
        kind, sign = one.qualifier, ">=" if "D" in one.qualifier else "<"
        if kind == "N":
            return active
        if kind == "P":
            return f"({active} AND NOT {self._previous(step.name)})"
        if kind in ("L", "D"):
            return f"({active} AND {self._time(step.name)} {sign} {time})"
        if kind in ("S", "DS"):
            return self._store(number, one)
        if kind == "SD":
            return f"{timer}.Q"
        if kind == "SL":
            return f"({self._store(number, one)} AND NOT {timer}.Q)"
        return ""

    def _pulses(self) -> Iterator[Line]:
        """Yield the edges of steps for P1 and P0, and the memories of all edges."""
        found: dict[str, list[str]] = {}
        for step, one in self._associations():
            if one.qualifier == "P1":
                edge = f"({self._step(step.name)} AND NOT {self._previous(step.name)})"
            elif one.qualifier == "P0":
                edge = f"({self._previous(step.name)} AND NOT {self._step(step.name)})"
            else:
                continue
            found.setdefault(one.action.upper(), []).append(edge)
        for name in self._actions:
            if edges := found.get(name.upper()):
                pulse = self._names.of("Pulse", name)
                self._declared[pulse] = "BOOL := FALSE"
                at = next(one.at for _, one in self._associations() if one.action == name)
                lines = _wrapped(f"{pulse} := {' OR '.join(dict.fromkeys(edges))};", at)
                yield from _of(f"action {name}", *lines)
        self._with_pulse = set(found)
        for step in self._chart.steps:
            if any(one.qualifier in ("P", "P1", "P0") for one in step.associations):
                previous = self._previous(step.name)
                self._declared[previous] = "BOOL := FALSE"
                line = Line(f"{previous} := {self._step(step.name)};", step.at)
                yield from _of(f"step {step.name}", line)

    def _executed(self) -> Iterator[Line]:
        bodies = {one.name.upper(): one for one in self._chart.actions}
        for name in self._actions:
            if name.upper() not in bodies:
                at = next(one.at for _, one in self._associations() if one.action == name)
                line = Line(f"{name} := {' OR '.join(self._on(name))};", at)
                yield from _of(f"action {name}", line)
        for action in self._chart.actions:
            if action.name.upper() in {name.upper() for name in self._actions}:
                yield from _of(f"action {action.name}", *self._body(action))

    def _on(self, name: str) -> list[str]:
        pulse = [self._names.of("Pulse", name)] if name.upper() in self._with_pulse else []
        return [self._names.of("Action", name), *pulse]

    def _body(self, action: Action) -> Iterator[Line]:
        name = next(one for one in self._actions if one.upper() == action.name.upper())
        on = self._on(name)
        last = self._names.of("Last", name)
        final = self._final and name.upper() in self._controlled
        if final:
            self._declared[last] = "BOOL := FALSE"
            on.append(last)
        yield Line(f"IF {' OR '.join(on)} THEN", action.at)
        body = list(self._substituted(action.body))
        for line in body or [Line(";", action.at)]:
            yield Line(f"  {line.text}".rstrip(), line.at, line.shift - 2)
        yield Line("END_IF;", action.at)
        if final:
            yield Line(f"{last} := {self._names.of('Action', name)};", action.at)

    # --- names and texts ---

    def variables(self) -> Iterator[str]:
        width = max(len(name) for name in self._declared)
        for name, kind in self._declared.items():
            yield f"{name:{width}} : {kind};"

    def _associations(self) -> Iterator[tuple[Step, Association]]:
        for step in self._chart.steps:
            for one in step.associations:
                yield step, one

    def _canonical(self, name: str) -> str:
        return next((one for one in self._steps if one.upper() == name.upper()), name)

    def _step(self, name: str) -> str:
        return self._names.of("Step", self._canonical(name))

    def _time(self, name: str) -> str:
        return self._names.of("Time", self._canonical(name))

    def _previous(self, name: str) -> str:
        return self._names.of("Previous", self._canonical(name))

    def _fires(self, number: int) -> str:
        return self._names.of("Transition", f"{number}")

    def _store(self, number: int, one: Association) -> str:
        return self._names.of("Stored", f"{number}_{one.action}")

    def _with_variables(self, text: str) -> str:
        return replaced(text, self._steps, self._actions, self._names)

    def _substituted(self, lines: tuple[Line, ...]) -> Iterator[Line]:
        # A comment may span several lines, so all lines are replaced in one text.
        texts = (
            self._with_variables("\n".join(line.text for line in lines)).split("\n")
            if lines
            else []
        )
        for line, text in zip(lines, texts, strict=True):
            yield replace(line, text=text)


def _texts(chart: Chart) -> Iterator[Line]:
    yield from chart.before
    for one in chart.transitions:
        yield from one.condition
    for action in chart.actions:
        yield from action.body
    for step in chart.steps:
        for association in step.associations:
            yield Line(association.time, association.at)


def _of(network: str, *lines: Line) -> Iterator[Line]:
    """Yield lines with the part of the chart that they were translated from."""
    for line in lines:
        yield replace(line, network=network)


def _share(one: tuple[str, ...], other: tuple[str, ...]) -> bool:
    return bool({name.upper() for name in one} & {name.upper() for name in other})


def _comment(text: str) -> str:
    return text.replace("*)", "* )").replace("(*", "( *")


def _wrapped(text: str, at: int) -> Iterator[Line]:
    """Yield a statement in lines of at most 96 characters, broken before OR."""
    parts = text.split(" OR ")
    line = parts[0]
    for part in parts[1:]:
        if len(line) + len(part) > 92:
            yield Line(line, at)
            line = f"  OR {part}"
        else:
            line += f" OR {part}"
    yield Line(line, at)
