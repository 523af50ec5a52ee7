"""Export for Siemens SCL: one external source file for TIA Portal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from structured_text.export.body import Body, Scope
from structured_text.export.initial import is_scalar, literal, runs, zero
from structured_text.export.losses import lost_configuration, reaching_out
from structured_text.export.output import Missing, Output
from structured_text.export.parts import Part, Sources, enumerations
from structured_text.export.starts import Starts, each_call
from structured_text.export.words import blocks_of, unwritten, words
from structured_text.language import syntax as s
from structured_text.language.printer import bounds_text, init_text
from structured_text.language.tree import Symbol
from structured_text.language.types import ArrayType, BlockType, ElementaryType, StructType, Type
from structured_text.language.values import array_length
from structured_text.language.walk import declared

__all__ = ["Names", "quoted", "scl_body", "to_scl"]

#: Reserved words of SCL that are allowed as names in IEC 61131-3.
_RESERVED = frozenset(
    (
        *("AUTHOR", "BEGIN", "BLOCK", "BLOCK_DB", "BLOCK_FB", "BLOCK_FC", "CHAR", "CONTINUE"),
        *("COUNTER", "DATA_BLOCK", "DATE", "DT", "DTL", "END", "FAMILY", "GOTO"),
        *("KNOW_HOW_PROTECT", "LABEL", "LDT", "LTIME", "LTOD", "NAME", "NIL", "OK"),
        *("ORGANIZATION_BLOCK", "POINTER", "REF", "REF_TO", "REGION", "S5TIME", "TIMER"),
        *("TITLE", "TOD", "VARIANT", "VERSION", "VOID", "WCHAR", "WSTRING"),
    )
)


@dataclass(frozen=True)
class Names:
    """The meaning of the sources' names, in upper case.

    Attributes:
        members: Members of enumerations; they are written `#Name`, like variables.
        defaults: Functions of the sources, written `"Name"`, with the values of omitted arguments,
            by upper-case name.
    """

    members: Collection[str]
    defaults: Mapping[str, Mapping[str, str]]


def scl_body(text: str, scope: Scope, names: Names) -> str:
    """Return statements rewritten for SCL; comments and line breaks stay.

    `Name` becomes `#Name`, a function becomes `"Name"`. Arguments of functions and blocks get
    names. Omitted arguments of functions are written out, because SCL has no defaults for them.
    """
    return _Body(text, scope, names).all()


def quoted(name: str) -> str:
    """Return a name, in quotes if it is a reserved word of SCL."""
    return f'"{name}"' if name.upper() in _RESERVED else name


class _Body(Body):
    """A writer of statements in SCL."""

    def __init__(self, text: str, scope: Scope, names: Names) -> None:
        super().__init__(text, scope, words("scl"))
        self._names = names

    def _plain(self, text: str) -> str:
        return quoted(text)

    def _variable(self, at: int) -> str:
        return f"#{quoted(str(self._found[at]))}"

    def _word(self, at: int) -> str:
        token = self._found[at]
        if token.upper() in self._names.members:
            return f"#{quoted(str(token))}"
        return f'"{token}"' if token.upper() in self._names.defaults else str(token)

    def _own(self, at: int, given: list[tuple[str, int, int]], end: int) -> str:
        key = self._found[at].upper()
        defaults = self._names.defaults[key]
        return self._listed(at, given, end, self._scope.pins[key], named=True, defaults=defaults)


_ZEROS = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0", "TIME": "T#0s", "STRING": "''"}
_ORDER = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR", "VAR_TEMP")

#: The statements of SR and RS, which SCL lacks, from IEC 61131-3, tables 34.1 and 34.2.
_FLIP_FLOPS = {
    "SR": ("S1", "R", "#S1 OR (NOT #R AND #Q1)"),
    "RS": ("S", "R1", "NOT #R1 AND (#S OR #Q1)"),
}

_PROGRAM = "written as FUNCTION_BLOCK; call an instance of it in a cyclic OB"
_CONFIGURATION = "set the cycle of the OB that calls the program"


def to_scl(sources: Sources) -> Output:
    """Write structures, functions and blocks as one SCL source; replace what SCL lacks.

    Enumerations become INT, and their members become local constants of each block that uses them.
    Named arrays are written out where they are used. Programs become function blocks.
    """
    writer = _Writer(sources)
    texts, notes = [f"{_lines(sources.notice)}{writer.enumerations()}"], []
    lost: list[Missing] = []
    reasons = {
        part.name.upper(): reaching_out(part.node, "TIA Portal")
        for part in sources.parts
        if isinstance(part.node, s.Pou)
    }
    barred = unwritten(sources.parts, words("scl"), reasons)
    texts += writer.flip_flops(one for one in sources.parts if one.name.upper() not in barred)
    for part in sources.parts:
        node = part.node
        if isinstance(node, s.Configuration):
            lost.append(lost_configuration(part, _CONFIGURATION))
        elif part.name.upper() in barred:
            lost.append(barred[part.name.upper()])
        elif isinstance(node, s.TypeDecl):
            if isinstance(node.spec, s.StructSpec):
                texts.append("\n".join(writer.structure(part, node.spec)))
        else:
            if part.kind == "PROGRAM":
                notes.append(f"PROGRAM {part.name}: {_PROGRAM}")
            texts.append("\n".join(writer.pou(part, node)))
            lost += writer.starts.lost(part, node)
    text = "\n\n".join(texts) + "\n"
    return Output({"": text}, tuple(lost), newline="\r\n", notes=tuple(notes))


def _in_declaration(kind: Type) -> bool:
    """Return whether a declaration can contain the initial value of a type.

    A declaration can contain the values of scalars, and of arrays of scalars with one dimension.
    """
    row = isinstance(kind, ArrayType) and len(kind.bounds) == 1 and is_scalar(kind.element)
    return is_scalar(kind) or row


def _lines(text: str) -> str:
    return "".join(f"// {line}".rstrip() + "\n" for line in text.splitlines())


def _note(text: str) -> str:
    return f"   // {' '.join(text.split())}" if text else ""


class _Writer:
    """A writer of SCL that knows the types and functions of the sources."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources
        self._project = sources.project
        self.starts = Starts(
            sources.project,
            lambda name: f"#{quoted(name)}",
            quoted,
            self._literal,
            implicit=self._implicit,
            declared=_in_declaration,
            kept=lambda section, symbol: (
                section.qualifier == "RETAIN" and not isinstance(symbol.type, BlockType)
            ),
        )
        self._types, self._members = sources.types, sources.members
        self._blocks = {part.name.upper() for part in sources.of("FUNCTION_BLOCK", "PROGRAM")}
        self._functions = {
            part.name.upper(): self._defaults(part.node)
            for part in sources.of("FUNCTION")
            if isinstance(part.node, s.Pou)
        }

    def enumerations(self) -> str:
        """Return all enumerations as comments, for the users of the blocks."""
        text = ["", "Enumerations are INT here; their members are constants of the blocks:"]
        lines = enumerations(self._types.values())
        return _lines("\n".join([*text, *(f"  {line}" for line in lines)])) if lines else ""

    def flip_flops(self, parts: Iterable[Part]) -> Iterator[str]:
        """Yield the flip-flops (SR, RS) that the declarations use, as function blocks."""
        used = {key for part in parts for key in blocks_of(part)}
        for key, (first, second, value) in _FLIP_FLOPS.items():
            if key in used:
                name = words("scl").blocks[key].name
                yield "\n".join(
                    [
                        f'FUNCTION_BLOCK "{name}"',
                        "{ S7_Optimized_Access := 'TRUE' }\nVERSION : 0.1",
                        f"// {name}: the flip-flop {key} of IEC 61131-3, which SCL lacks.",
                        f"   VAR_INPUT\n      {first} : BOOL;\n      {second} : BOOL;\n   END_VAR",
                        "   VAR_OUTPUT\n      Q1 : BOOL;\n   END_VAR",
                        f"BEGIN\n  #Q1 := {value};\nEND_FUNCTION_BLOCK",
                    ]
                )

    def structure(self, part: Part, spec: s.StructSpec) -> Iterator[str]:
        """Yield the lines of a PLC data type."""
        yield f'TYPE "{part.name}"\nVERSION : 0.1\n{_lines(part.header)}   STRUCT'
        kind, values = self._project.types[part.name.upper()], self._project.initial
        assert isinstance(kind, StructType)
        assert isinstance(part.node, s.TypeDecl)
        for field in spec.fields:
            # An initial value of a whole structure has priority over the initial values of its
            # fields.
            if part.node.initial is not None:
                field = replace(field, initial=None)
            for name in field.names:
                inner, value = dict(kind.fields)[name.text], values[part.name.upper()][name.text]
                yield self._variable(name, field, part, self._initial(field, inner, value))
        yield "   END_STRUCT;\n\nEND_TYPE"

    def pou(self, part: Part, node: s.Pou) -> Iterator[str]:
        """Yield the lines of a function or function block."""
        kind = "FUNCTION_BLOCK" if node.kind == "PROGRAM" else node.kind
        result = f" : {self._spec(node.result)}" if node.result is not None else ""
        yield f'{kind} "{part.name}"{result}'
        yield f"{{ S7_Optimized_Access := 'TRUE' }}\nVERSION : 0.1\n{_lines(part.header)}".rstrip()
        for wanted in _ORDER:
            for section in node.sections:
                if self._section(section, node) == wanted:
                    yield from self._declared(section, wanted, part, node)
        for flag, kept in self.starts.flags(node).items():
            yield f"   VAR{' RETAIN' if kept else ''}"
            yield f"      {flag} : BOOL;   // TRUE once the initial values are set"
            yield "   END_VAR"
        names = Names(self._members, self._functions)
        body = scl_body(part.body, Scope.of(part, self._sources), names)
        constants = list(self._constants(part, node, body))
        if constants:
            yield "\n".join(["   VAR CONSTANT", *constants, "   END_VAR"])
        yield "\n".join(["BEGIN", *self._cleared(node), body, f"END_{kind}"])

    def _section(self, section: s.Section, node: s.Pou) -> str:
        """Return the kind of a section in SCL, where the variables of a function are temporary."""
        return "VAR_TEMP" if node.kind == "FUNCTION" and section.kind == "VAR" else section.kind

    def _declared(self, section: s.Section, word: str, part: Part, node: s.Pou) -> Iterator[str]:
        """Yield a section of variables without its scalar constants.

        The scalar constants are written after all sections.
        """
        lines = []
        for one in section.variables:
            for name in one.names:
                symbol = self.starts.symbol(node, name)
                if symbol.constant and is_scalar(symbol.type):
                    continue
                initial = ""
                if node.kind != "FUNCTION" and not each_call(node, section):
                    initial = self._initial(one, symbol.type, symbol.initial)
                lines.append(self._variable(name, one, part, initial))
        if lines or section.qualifier != "CONSTANT":
            yield f"   {word}{' RETAIN' if section.qualifier == 'RETAIN' else ''}"
            yield from lines
            yield "   END_VAR"

    def _variable(self, name: s.Name, one: s.VarDecl, part: Part, initial: str) -> str:
        note = _note(part.notes.get(name.key, ""))
        value = f" := {initial}" if initial else ""
        return f"      {quoted(name.text)} : {self._spec(one.spec)}{value};{note}"

    def _initial(self, one: s.VarDecl, kind: Type, value: Any) -> str:
        """Return the initial value for a declaration.

        The result is empty if a declaration does not need the value, or cannot contain it.
        """
        if isinstance(kind, BlockType) or not _in_declaration(kind):
            return ""
        if one.initial is None and value == self._implicit(kind):
            return ""
        if isinstance(kind, ArrayType):
            return runs([self._literal(item, kind.element) for item in value])
        return self._literal(value, kind) if one.initial is None else self._value(one.initial)

    def _implicit(self, kind: Type) -> Any:
        """Return the value that a variable of a type has without an initial value.

        The fields of a PLC data type can have values of their own.
        """
        if isinstance(kind, StructType):
            values = self._project.initial[kind.name.upper()]
            return {
                name: values[name] if _in_declaration(field) else self._implicit(field)
                for name, field in kind.fields
            }
        if isinstance(kind, ArrayType):
            return [self._implicit(kind.element)] * array_length(kind)
        return zero(kind)

    def _literal(self, value: Any, kind: Type) -> str:
        return literal(value, kind) if isinstance(kind, ElementaryType) else str(value)

    def _value(self, init: s.Init) -> str:
        if isinstance(init, s.Name) and init.key in self._members:
            return str(self._members[init.key][1])
        return init_text(init)

    def _spec(self, spec: s.TypeSpec) -> str:
        if isinstance(spec, s.ArraySpec):
            return f"Array[{bounds_text(spec)}] of {self._spec(spec.element)}"
        if isinstance(spec, s.EnumSpec):
            return "INT"
        if isinstance(spec, s.StructSpec):
            fields = " ".join(
                f"{name.text} : {self._spec(one.spec)};"
                for one in spec.fields
                for name in one.names
            )
            return f"STRUCT {fields} END_STRUCT"
        assert isinstance(spec, s.NamedSpec)
        declared = self._types.get(spec.name.key)
        if declared is not None and not isinstance(declared.spec, s.StructSpec):
            return self._spec(declared.spec)
        if declared is not None or spec.name.key in self._blocks:
            return f'"{spec.name.text}"'
        standard = words("scl").blocks.get(spec.name.key)
        if standard is None:
            return spec.name.text
        return f'"{standard.name}"' if spec.name.key in _FLIP_FLOPS else standard.name

    def _constants(self, part: Part, node: s.Pou, body: str) -> Iterator[str]:
        """Yield the block's own constants and the members of enumerations that it uses."""
        for _, one, name in declared(node.sections):
            symbol = self.starts.symbol(node, name)
            if symbol.constant and is_scalar(symbol.type):
                initial = self._initial(one, symbol.type, symbol.initial)
                zeros = self._literal(symbol.initial, symbol.type)
                yield self._variable(name, one, part, initial or zeros)
        used = {word.upper() for word in body.replace("#", " #").split() if word.startswith("#")}
        marked = {"".join(c for c in word[1:] if c.isalnum() or c == "_") for word in used}
        for key in sorted(marked & self._members.keys(), key=self._rank):
            _, value, member = self._members[key]
            yield f"      {member} : INT := {value};"

    def _rank(self, key: str) -> int:
        return list(self._members).index(key)

    def _cleared(self, node: s.Pou) -> Iterator[str]:
        """Yield statements that set a function's result and variables to their initial values.

        In SCL, temporary variables have no initial value.
        """
        if node.result is not None:
            yield f"  #{node.name.text} := {self._zero(node.result)};"
        yield from self.starts.statements(node, self._start)

    def _start(self, one: s.VarDecl, symbol: Symbol) -> str:
        """Return the initial value of a scalar as SCL."""
        if one.initial is not None:
            return self._value(one.initial)
        if symbol.initial == zero(symbol.type):
            return self._zero(one.spec)
        return self._literal(symbol.initial, symbol.type)

    def _zero(self, spec: s.TypeSpec) -> str:
        return _ZEROS.get(self._spec(spec).upper(), "0")

    def _defaults(self, node: s.Pou) -> Mapping[str, str]:
        """Return the values that SCL writes for omitted arguments of a function."""
        return {
            name.key: self._start(one, self.starts.symbol(node, name))
            for section, one, name in declared(node.sections)
            if section.kind == "VAR_INPUT" and is_scalar(self.starts.symbol(node, name).type)
        }
