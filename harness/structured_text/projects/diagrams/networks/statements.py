"""The statements of a translation, and the values that wait for the statement that uses them.

A value that is used once stands in the statement that uses it, unless a statement before that
changes a variable that the value reads. Then a variable keeps the value.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from structured_text.projects.diagrams.networks.check import DiagramError, named, wrong
from structured_text.projects.diagrams.networks.expressions import (
    Call,
    Expression,
    Infix,
    Key,
    Not,
    Text,
    Use,
    keys_in,
    parts_of,
    roots,
    size,
    written,
)
from structured_text.projects.diagrams.networks.model import Block, Element
from structured_text.projects.diagrams.networks.types import Types
from structured_text.projects.diagrams.sfc.names import Names

__all__ = ["ANYTHING", "OUTSIDE", "Jumped", "Made", "Statements"]

#: Marks in the variables that are read or written. OUTSIDE: variables that other POUs can change.
#: ANYTHING: a function may read or change variables outside of it.
OUTSIDE, ANYTHING = "*outside", "*anything"

#: A condition with more variables than this gets a variable if it is used more than once.
_SHORT = 2
#: The value of a block with more variables than this always gets a variable.
_LONG = 12

Written = Callable[[Expression], str]


@dataclass
class Made:
    """A statement, or several under one condition.

    Attributes:
        element: The element that it was made for.
        lines: The texts with the lines in the file.
        condition: The condition of an IF around the lines; empty for none.
        otherwise: The texts of the ELSE branch.
        writes: The variables that it changes, in upper case.
    """

    element: Element
    lines: list[tuple[str, int]]
    condition: str = ""
    otherwise: list[tuple[str, int]] = field(default_factory=list)
    writes: frozenset[str] = frozenset()


@dataclass
class Jumped:
    """A jump to a label under a condition."""

    element: Element
    label: str
    condition: Expression
    text: str
    inverse: str


class Statements:
    """Collects statements. `users` returns the identities of the users of a value."""

    def __init__(self, names: Names, types: Types, users: Callable[[Key], Sequence[str]]) -> None:
        self._names, self._types, self._users = names, types, users
        self.variables: dict[str, str] = {}
        self._added: set[str] = set()
        self.made: list[Made | Jumped] = []
        self._bound: dict[Key, Expression] = {}
        self._waiting: dict[Key, Element] = {}
        self._guards: dict[Key, Expression] = {}
        self._left: dict[Key, set[str]] = {}
        self._kept: dict[Key, str] = {}
        self._owners: dict[str, Element] = {}
        self._counts: dict[tuple[str, str], int] = {}
        self._edges: dict[tuple[str, str], tuple[str, frozenset[str]]] = {}

    # --- variables ---

    def variable(self, kind: str, name: str, declared: str) -> str:
        """Return a new variable that is named after a kind and a name."""
        plain = re.sub(r"\W+", "_", name).strip("_")
        count = self._counts[kind, plain] = self._counts.get((kind, plain), 0) + 1
        found = self._names.of(kind, f"{plain}_{count}" if count > 1 else plain)
        self.variables[found] = declared
        self._added.add(found.upper())
        return found

    def _variable_for(self, key: Key, element: Element) -> str:
        if key not in self._kept:
            kind = "Power"
            if isinstance(element, Block):
                kind = re.sub(r"\W", "", element.instance or element.type).capitalize() or "Value"
                kind += {"": "", "ENO": "Eno"}.get(key[1], "")
            self._kept[key] = self.variable(kind, str(element.network), "")
            self._owners[self._kept[key]] = element
        return self._kept[key]

    def _declare(self, key: Key, element: Element, kind: str) -> str:
        name = self._variable_for(key, element)
        if not kind or kind.startswith("ANY"):
            raise _unknown(element)
        start = ""
        if key[1] == "ENO" and isinstance(element, Block) and element.instance:
            start = " := TRUE"  # the initial value of ENO of a block
        self.variables[name] = kind + start
        return name

    def check_types(self) -> None:
        """Raise DiagramError if a variable has no type."""
        for name, element in self._owners.items():
            if not self.variables[name]:
                raise _unknown(element)

    # --- values ---

    def use(self, key: Key, kind: str) -> Use:
        """Return the use of a value with a type."""
        return Use(key, kind)

    def kind_of(self, key: Key) -> str:
        """Return the type of a value that was computed before; else empty."""
        return self._bound[key].type if key in self._bound else ""

    def is_kept(self, key: Key) -> bool:
        """Return whether the value has a variable."""
        return key in self._kept

    def waits(self, key: Key) -> bool:
        """Return whether a value was computed and is in no variable."""
        return key in self._waiting

    def result(self, key: Key, element: Element, kind: str) -> str:
        """Return the variable that a call writes a value to."""
        return self._declare(key, element, kind)

    def settle(self, key: Key, variable: Text) -> None:
        """Note the variable that has a value from now on."""
        self._bound[key] = variable
        self._waiting.pop(key, None)

    def is_bound(self, key: Key) -> bool:
        """Return whether the value was computed before."""
        return key in self._bound

    def bind(
        self,
        key: Key,
        element: Element,
        value: Expression,
        guard: Expression | None = None,
        users: Sequence[str] | None = None,
        otherwise: str = "",
    ) -> None:
        """Give an output its value; with a `guard`, it has this value only under a condition.

        `users` are the identities of the elements that use the value, if the lines do not show it.
        `otherwise` is the value of its variable if the guard is FALSE; if empty, it is kept.
        """
        users = tuple(dict.fromkeys(self._users(key) if users is None else users))
        if not users and key not in self._kept:
            return
        self._left[key] = set(users)
        if guard is not None:
            self._guards[key] = guard
        if key in self._kept:
            # The value was read before. Values that wait may read it as it was in the last scan.
            name = self._declare(key, element, value.type)
            self._keep_before(frozenset((name.upper(),)))
            self._store(key, element, name, value, otherwise)
            return
        self._bound[key] = value
        self._waiting[key] = element
        is_long = isinstance(element, Block) and self._total(value) > _LONG
        if is_long or (len(users) > 1 and not self._is_short(value)):
            self.keep(key, otherwise)

    def _is_short(self, value: Expression) -> bool:
        value = self._resolved(value)
        if isinstance(value, Infix) and (value.op not in ("AND", "OR") or value.type != "BOOL"):
            return False
        parts = map(self._resolved, parts_of(value))
        simple = all(isinstance(part, (Text, Not)) for part in parts)
        return not isinstance(value, Call) and simple and size(value) <= _SHORT

    def _total(self, value: Expression) -> int:
        """Return the number of variables and literals in the text of a value."""
        if isinstance(value, Use):
            return self._total(self._bound[value.key]) if value.key in self._waiting else 1
        return sum(map(self._total, parts_of(value))) or 1

    def _resolved(self, value: Expression) -> Expression:
        while isinstance(value, Use) and value.key in self._bound:
            value = self._bound[value.key]
        return value

    def keep(self, key: Key, otherwise: str = "") -> str:
        """Keep a value in a variable from now on, and return the variable."""
        if key not in self._waiting:
            found = self._bound.get(key)
            return found.text if isinstance(found, Text) else self._kept[key]
        element = self._waiting.pop(key)
        value = self._bound[key]
        name = self._declare(key, element, value.type)
        self._store(key, element, name, value, otherwise)
        return name

    def cut(self, value: Expression) -> None:
        """Keep a waiting sum or product of a type with less than 32 bits in a variable."""
        while isinstance(value, Use) and isinstance(inner := self._bound.get(value.key), Use):
            value = inner
        if isinstance(value, Use) and value.key in self._waiting:
            found = self._bound[value.key]
            narrow = self._types.base(found.type) in ("SINT", "INT", "USINT", "UINT")
            if isinstance(found, Infix) and found.op in ("+", "-", "*") and narrow:
                self.keep(value.key)

    def _store(
        self, key: Key, element: Element, name: str, value: Expression, otherwise: str = ""
    ) -> None:
        """Add the assignment of a value to its variable."""
        guard = self._guards.get(key)
        when = self.written(guard) if guard is not None else ""
        when = "" if when == "TRUE" else when
        changed = frozenset((name.upper(),))
        self._append(
            Made(
                element,
                [(f"{name} := {self.written(value)};", element.at)],
                when,
                [(f"{name} := {otherwise};", element.at)] if when and otherwise else [],
                changed,
            ),
            changed,
        )
        self._bound[key] = Text(name, value.type)

    def written(self, value: Expression) -> str:
        """Return the text of a value at this place."""
        return written(value, self._bound_or_kept)

    def _bound_or_kept(self, use: Use) -> Expression:
        if use.key not in self._bound:
            return Text(self._kept[use.key], use.type)
        return self._bound[use.key]

    def remember(self, key: Key, element: Element) -> None:
        """Let a value be read before it is computed: then it is the one of the last scan."""
        self._variable_for(key, element)

    def reads(self, value: Expression) -> frozenset[str]:
        """Return the variables that a value reads, in upper case, with marks."""
        if isinstance(value, Use):
            return self.reads(self._bound_or_kept(value))
        if isinstance(value, Text):
            return self.marked(self.named(value.text))
        found: frozenset[str] = frozenset()
        for part in parts_of(value):
            found |= self.reads(part)
        if isinstance(value, Call) and value.outside:
            found |= {OUTSIDE, ANYTHING}
        return found

    def named(self, text: str) -> frozenset[str]:
        """Return the variables in a text in upper case; those of global lists with the list."""
        return frozenset(
            name if self._types.is_list(name.partition(".")[0]) else name.partition(".")[0]
            for name in roots(text)
        )

    def target(self, text: str) -> frozenset[str]:
        """Return the variable that an assignment to a text changes."""
        found = re.match(r"\s*([^\W\d]\w*(?:\s*\.\s*[^\W\d]\w*)?)", text)
        return self.named(re.sub(r"\s", "", found[1])) if found else frozenset()

    def marked(self, names: frozenset[str]) -> frozenset[str]:
        """Return names, with a mark if other POUs can change one of them."""
        own = all(self._types.is_own(name) or name in self._added for name in names)
        return names if own else names | {OUTSIDE}

    # --- statements ---

    def add(
        self,
        element: Element,
        text: str | Sequence[str],
        writes: Iterable[str],
        values: Sequence[Expression],
        condition: Expression | None = None,
        *,
        release: bool = True,
    ) -> None:
        """Add a statement: `text` with {0}, {1} ... for the texts of `values`.

        `writes` are the changed variables. Unless `release` is False, this is the statement of the
        element for which the values of its inputs wait.
        """
        if release:
            self.released(element)
        changed = frozenset(name.upper() for name in writes)
        self._keep_before(changed)
        texts = (text,) if isinstance(text, str) else text
        given = [self.written(value) for value in values]
        lines = [(_filled(one, given), element.at) for one in texts]
        when = self.written(condition) if condition is not None else ""
        self._append(Made(element, lines, "" if when == "TRUE" else when, [], changed), changed)

    def released(self, element: Element) -> None:
        """Note that an element has used its inputs."""
        for left in self._left.values():
            left.discard(element.id)

    def jump(
        self, element: Element, label: str, condition: Expression, inverse: Expression
    ) -> None:
        """Add a jump to a label; an empty label leaves the POU."""
        self.released(element)
        text, opposite = self.written(condition), self.written(inverse)
        self.made.append(Jumped(element, label, condition, text, opposite))

    def _keep_before(self, changed: frozenset[str]) -> None:
        """Keep the values that later statements need and that a change would falsify."""
        live = {key for key in self._waiting if self._left.get(key)}
        waiting = list(live)
        while waiting:
            now = waiting.pop()
            guard = self._guards.get(now)
            used = [*keys_in(self._bound[now]), *(keys_in(guard) if guard is not None else ())]
            for key in used:
                if key in self._waiting and key not in live:
                    live.add(key)
                    waiting.append(key)
        for key in [key for key in self._waiting if key in live]:
            reads = self.reads(self._bound[key])
            if reads & changed or ANYTHING in reads:
                self.keep(key)

    def keep_all(self) -> None:
        """Keep all values that later statements need."""
        for key in [key for key in self._waiting if self._left.get(key)]:
            self.keep(key)

    def _append(self, made: Made, changed: frozenset[str]) -> None:
        self._edges = {key: edge for key, edge in self._edges.items() if not edge[1] & changed}
        last = self.made[-1] if self.made else None
        if (
            isinstance(last, Made)
            and made.condition
            and last.condition == made.condition
            and last.element.network == made.element.network
            and not (last.otherwise or made.otherwise)
            and not self.marked(self.named(made.condition)) & last.writes
        ):
            last.lines += made.lines
            last.writes |= made.writes
        else:
            self.made.append(made)

    # --- edges ---

    def edge(self, element: Element, kind: str, name: str, value: Expression, share: str) -> Text:
        """Add the detection of an edge and return the variable that is TRUE at the edge.

        A detection with the same `share` is used again while what it reads is unchanged.
        """
        found = self._edges.get((share, kind)) if share else None
        if found is None:
            block = "R_TRIG" if kind == "rising" else "F_TRIG"
            trigger = self.variable(kind.capitalize(), name, block)
            clock, reads = self.written(value), self.reads(value)
            changed = frozenset((trigger.upper(),))
            self._append(
                Made(element, [(f"{trigger}(CLK := {clock});", element.at)], "", [], changed),
                changed,
            )
            found = trigger, reads
            if share:
                self._edges[share, kind] = found
        return Text(f"{found[0]}.Q", "BOOL")


def _filled(text: str, given: Sequence[str]) -> str:
    """Return a text with the given texts in place of {0}, {1} ..."""

    def value(found: re.Match[str]) -> str:
        number = int(found[1])
        return given[number] if number < len(given) else found[0]

    return re.sub(r"\{(\d+)\}", value, text)


def _unknown(element: Element) -> DiagramError:
    text = f"the type of the result of {named(element)} is not known"
    return wrong(element, text, "connect it to variables of declared types")
