"""The types of variables and the pins of blocks, for the statements of a POU."""

from __future__ import annotations

from dataclasses import dataclass

from structured_text.export.parts import Part, Sources
from structured_text.language import syntax as s
from structured_text.language.scalars import ELEMENTARY
from structured_text.language.standard import BLOCKS, pin_name
from structured_text.language.walk import declared

__all__ = ["Pin", "Scope", "named"]

_SECTIONS = ("VAR_INPUT", "VAR_IN_OUT", "VAR_OUTPUT")
_NOWHERE = s.Position(0, 0)


@dataclass(frozen=True)
class Pin:
    """A pin of a block; `section` is VAR_INPUT, VAR_IN_OUT or VAR_OUTPUT."""

    name: str
    section: str
    spec: s.TypeSpec


def named(name: str) -> s.NamedSpec:
    """Return the specification of a type by its name."""
    return s.NamedSpec(s.Name(name, _NOWHERE), _NOWHERE)


class Scope:
    """The variables of a POU, with the types and blocks of the sources."""

    def __init__(self, part: Part, sources: Sources) -> None:
        node = part.node
        assert isinstance(node, s.Pou)
        self._sources = sources
        self._pous = {
            found.name.upper(): found.node
            for found in sources.parts
            if isinstance(found.node, s.Pou)
        }
        self.variables = {name.key: one.spec for _, one, name in declared(node.sections)}
        #: Variables that cannot be passed to a block as VAR_IN_OUT in every tool.
        self.bound = frozenset(
            name.key
            for section, one, name in declared(node.sections)
            if one.address is not None or section.kind == "VAR_EXTERNAL"
        )
        #: The words that an added variable must not have as its name.
        self.names = {*self.variables, *self._pous, *sources.types, *sources.members}

    def spec_of(self, path: s.Expression) -> s.TypeSpec | None:
        """Return the type of a variable, a field, a pin or an element; None if unknown."""
        if isinstance(path, s.Name):
            return self.variables.get(path.key)
        if isinstance(path, s.Field):
            return self._field(self.spec_of(path.base), path.name.key)
        if isinstance(path, s.Index):
            found = self._sources.base(self.spec_of(path.base))
            return found.element if isinstance(found, s.ArraySpec) else None
        if isinstance(path, s.Part):
            return named("BOOL") if path.size == "X" else None
        return None

    def _field(self, spec: s.TypeSpec | None, key: str) -> s.TypeSpec | None:
        block = self.block(spec)
        if block:
            return next((pin.spec for pin in self.pins(block) if pin.name.upper() == key), None)
        found = self._sources.base(spec)
        if not isinstance(found, s.StructSpec):
            return None
        fields = ((name.key, one.spec) for one in found.fields for name in one.names)
        return next((one for name, one in fields if name == key), None)

    def is_boolean(self, spec: s.TypeSpec | None) -> bool:
        """Return whether a type is BOOL."""
        return isinstance(spec, s.NamedSpec) and spec.name.key == "BOOL"

    def is_elementary(self, spec: s.TypeSpec | None) -> bool:
        """Return whether a type is elementary, and not an enumeration, a structure or an array."""
        return isinstance(spec, s.NamedSpec) and spec.name.key in ELEMENTARY

    def is_enumeration(self, spec: s.TypeSpec | None) -> bool:
        """Return whether a type is an enumeration."""
        return isinstance(self._sources.base(spec), s.EnumSpec)

    def block(self, spec: s.TypeSpec | None) -> str:
        """Return the upper-case name of a function block; empty for any other type."""
        key = spec.name.key if isinstance(spec, s.NamedSpec) else ""
        pou = self._pous.get(key)
        return key if (pou is not None and pou.kind == "FUNCTION_BLOCK") or key in BLOCKS else ""

    def block_name(self, block: str) -> str:
        """Return the name of a block as it is declared."""
        pou = self._pous.get(block)
        return block if pou is None else pou.name.text

    def pins(self, block: str) -> list[Pin]:
        """Return the pins of a block in the order of their declaration."""
        pou = self._pous.get(block)
        if pou is None:
            return [
                Pin(one.name, one.section, named(one.type.name)) for one in BLOCKS[block].variables
            ]
        return [
            Pin(name.text, section.kind, one.spec)
            for section, one, name in declared(pou.sections)
            if section.kind in _SECTIONS
        ]

    def pin(self, block: str, name: str) -> Pin | None:
        """Return a pin of a block by its name, which may be an alternative name."""
        standard = BLOCKS.get(block) if block not in self._pous else None
        key = name.upper() if standard is None else pin_name(standard, name)
        return next((pin for pin in self.pins(block) if pin.name.upper() == key), None)

    def changes_variables(self, function: str) -> bool:
        """Return whether a function of the sources may change variables other than its result."""
        pou = self._pous.get(function)
        kinds = {section.kind for section in pou.sections} if pou is not None else set()
        return bool(kinds & {"VAR_IN_OUT", "VAR_EXTERNAL", "VAR_OUTPUT"})
