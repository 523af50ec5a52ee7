"""Reads of the counter of a FOR after the loop has ended.

IEC 61131-3 leaves the value open. After the loop, the counter has the last value on matiec since
June 2024. On other engines it has the value of one further step. After EXIT all engines have the
same value.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from structured_text.engines.matiec.hits import Hit, own_expressions
from structured_text.language import tree as t
from structured_text.language.walk import nodes

__all__ = ["stale_reads"]

#: Counters of FOR loops that have ended, by the identity of their symbol.
_Stale = frozenset[int]


def stale_reads(pou: t.Pou) -> Iterator[Hit]:
    """Yield the statements that read the counter of a FOR after the loop has ended.

    A statement is left out if the counter has got a new value since then.
    """
    if not any(isinstance(one, t.For) for one in nodes(pou.body)):
        return
    walk = _Walk(pou)
    after = walk.body(pou.body, frozenset())
    # A block keeps its variables, so its next call may read a counter of the previous call.
    if pou.kind != "FUNCTION":
        temporary = {id(symbol) for symbol in pou.section("VAR_TEMP")}
        walk.body(pou.body, after - temporary)
    yield from dict.fromkeys(walk.hits)


class _Walk:
    """The walk through a body in the order of its statements."""

    def __init__(self, pou: t.Pou) -> None:
        self._pou = pou
        self.hits: list[Hit] = []

    def body(self, body: Iterable[t.Statement], stale: _Stale) -> _Stale:
        """Return the stale counters after a body, given the stale counters before it."""
        for one in body:
            stale = self._statement(one, stale)
        return stale

    def _statement(self, one: t.Statement, stale: _Stale) -> _Stale:
        if isinstance(one, t.Assign):
            self._read(one, one.value, stale)
            if isinstance(one.target, t.Use):
                return stale - {id(one.target.symbol)}
            self._read(one, one.target, stale)
            return stale
        if isinstance(one, t.For):
            return self._loop(one, stale)
        for expression in own_expressions(one):
            self._read(one, expression, stale)
        if isinstance(one, t.If):
            ends = [self.body(body, stale) for _, body in one.branches]
            return frozenset().union(*ends, self.body(one.otherwise, stale))
        if isinstance(one, t.Case):
            ends = [self.body(body, stale) for _, body in one.branches]
            return frozenset().union(*ends, self.body(one.otherwise, stale))
        if isinstance(one, (t.While, t.Repeat)):
            again = self.body(one.body, stale) | stale
            return self.body(one.body, again) | stale
        return stale

    def _loop(self, one: t.For, stale: _Stale) -> _Stale:
        for expression in (one.start, one.end, one.step):
            self._read(one, expression, stale)
        own = {id(one.counter.symbol)} if isinstance(one.counter, t.Use) else set()
        inside = stale - own
        inside = (self.body(one.body, inside) | inside) - own
        return (self.body(one.body, inside) | inside) | own

    def _read(self, one: t.Statement, expression: Any, stale: _Stale) -> None:
        if not stale:
            return
        for node in nodes(expression):
            if isinstance(node, t.Use) and id(node.symbol) in stale:
                self.hits.append(Hit(self._pou.file, one.at, node.symbol.name))
                return
