"""Function blocks with generic constants: `VAR_GENERIC CONSTANT`, and `Buffer<6>` as a type.

For each list of values, a block is generated in which the constants have these values.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.printer import expression_text
from structured_text.language.registry import last_name

__all__ = ["instantiated"]

_SECTION = "VAR_GENERIC"
#: Limit for the number of generated blocks. A block that contains itself with other values would
#: need infinitely many.
_MOST_MADE = 200

_Constants = Mapping[str, s.Init]


def instantiated(sources: Sequence[s.Source]) -> list[s.Source]:
    """Return the sources with a block for each list of values that a generic block is used with."""
    generic = {
        node.name.key: (place, node)
        for place, source in enumerate(sources)
        for node in source.declarations
        if isinstance(node, s.Pou) and any(one.kind == _SECTION for one in node.sections)
    }
    return _Maker(sources, generic).sources() if generic else list(sources)


class _Maker:
    """Replaces generic blocks by blocks with values; `instantiated` uses this class."""

    def __init__(
        self, sources: Sequence[s.Source], generic: Mapping[str, tuple[int, s.Pou]]
    ) -> None:
        self._sources, self._generic = sources, generic
        self._made: dict[str, tuple[int, s.Pou, dict[str, s.Init]]] = {}
        self._errors: list[list[InputError]] = [[] for _ in sources]

    def sources(self) -> list[s.Source]:
        """Return the sources, with the new blocks behind the generic blocks."""
        found: list[list[Any]] = [[] for _ in self._sources]
        for place, source in enumerate(self._sources):
            for node in source.declarations:
                if node.name.key not in self._generic:
                    constants = _constants(node.sections) if isinstance(node, s.Pou) else {}
                    found[place].append(self._rewritten(node, constants, place))
        done = 0
        while done < len(self._made):
            key = list(self._made)[done]
            place, pou, values = self._made[key]
            found[place].append(self._rewritten(pou, values, place))
            done += 1
        return [
            replace(one, declarations=tuple(nodes), errors=(*one.errors, *errors))
            for one, nodes, errors in zip(self._sources, found, self._errors, strict=True)
        ]

    def _rewritten(self, node: Any, constants: _Constants, place: int) -> Any:
        """Return a node in which each generic type is the name of the block made for it."""
        if isinstance(node, tuple) and not isinstance(node, s.Position):
            return tuple(self._rewritten(one, constants, place) for one in node)
        if not is_dataclass(node) or isinstance(node, (s.Name, s.Literal)):
            return node
        if isinstance(node, s.NamedSpec) and node.generics:
            return self._named(node, constants, place)
        if isinstance(node, s.Pou) and node.generics and node.extends is not None:
            base = s.NamedSpec(node.extends, node.extends.at, generics=node.generics)
            named = self._named(base, constants, place)
            node = replace(node, extends=named.name, generics=named.generics)
        changed = {}
        for one in fields(node):
            old = getattr(node, one.name)
            new = self._rewritten(old, constants, place)
            if new is not old and new != old:
                changed[one.name] = new
        return replace(node, **changed) if changed else node

    def _named(self, spec: s.NamedSpec, constants: _Constants, place: int) -> s.NamedSpec:
        values = [_resolved(one, constants) for one in spec.generics]
        found = self._generic.get(last_name(spec.name))
        if found is None:
            return spec  # the name is not a generic block of these sources; the checker reports it
        home, pou = found
        names = [name for one in _generic_names(pou) for name in one]
        if len(names) != len(values) or len(self._made) >= _MOST_MADE:
            text = f"{pou.name.text} takes {len(names)} generic constants, not {len(values)}"
            if len(names) == len(values):
                text = f"more than {_MOST_MADE} blocks of generic constants"
            file = self._sources[place].file
            line, column = spec.at
            self._errors[place].append(InputError(text, file=file, line=line, column=column))
            return replace(spec, generics=())
        shown = "_".join(re.sub(r"\W+", "_", expression_text(one)) for one in values)
        name = s.Name(f"{pou.name.text}__{shown}", spec.name.at)
        if name.key not in self._made:
            given = dict(zip((one.key for one in names), values, strict=True))
            made = replace(pou, name=s.Name(name.text, pou.name.at), sections=_fixed(pou, given))
            self._made[name.key] = home, made, {**_constants(made.sections), **given}
        return replace(spec, name=name, generics=())


def _generic_names(pou: s.Pou) -> list[tuple[s.Name, ...]]:
    return [
        one.names
        for section in pou.sections
        if section.kind == _SECTION
        for one in section.variables
    ]


def _fixed(pou: s.Pou, given: Mapping[str, s.Init]) -> tuple[s.Section, ...]:
    """Return the sections of a POU, in which generic constants are constants with these values."""
    found = []
    for section in pou.sections:
        if section.kind == _SECTION:
            variables = tuple(
                replace(one, names=(name,), initial=given[name.key])
                for one in section.variables
                for name in one.names
            )
            section = replace(section, kind="VAR", qualifier="CONSTANT", variables=variables)
        found.append(section)
    return tuple(found)


def _constants(sections: Sequence[s.Section]) -> dict[str, s.Init]:
    """Return the constants of a POU with their values, by upper-case name."""
    return {
        name.key: one.initial
        for section in sections
        if section.qualifier == "CONSTANT"
        for one in section.variables
        for name in one.names
        if one.initial is not None
    }


def _resolved(node: Any, constants: _Constants) -> Any:
    """Return an expression with the constants of the surrounding POU replaced by their values."""
    if isinstance(node, s.Name):
        value = constants.get(node.key)
        return node if value is None else value
    if isinstance(node, s.Unary):
        return replace(node, operand=_resolved(node.operand, constants))
    if isinstance(node, s.Binary):
        left, right = (_resolved(one, constants) for one in (node.left, node.right))
        return replace(node, left=left, right=right)
    return node
