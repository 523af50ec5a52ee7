"""Which variables of a POU are written by its statements, also through the blocks that it calls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rcx_harness.engine.frontend import tree as t

__all__ = ["written"]


def written(pou: t.Pou, pous: Mapping[str, t.Pou]) -> set[str]:
    """Names of the variables that are assigned, or passed to a block that assigns them.

    Args:
        pou: A program or block.
        pous: The POUs of the sources by upper-case name.
    """
    found = set()
    for one in _statements(pou.body):
        if isinstance(one, t.Assign):
            found.add(_root(one.target))
        elif isinstance(one, t.CallBlock):
            found |= {_root(target) for _, target in one.outputs}
            callee = pous.get(one.block.name.upper())
            inside = written(callee, pous) if callee is not None else set()
            found |= {_root(variable) for pin, variable in one.in_outs if pin in inside}
    return found


def _root(node: t.Variable) -> str:
    while not isinstance(node, t.Use):
        node = node.base
    return node.symbol.name


def _statements(body: Iterable[t.Statement]) -> Iterator[t.Statement]:
    for one in body:
        yield one
        if isinstance(one, t.If | t.Case):
            for branch in one.branches:
                yield from _statements(branch[1])
            yield from _statements(one.otherwise)
        elif isinstance(one, t.While | t.Repeat | t.For):
            yield from _statements(one.body)
