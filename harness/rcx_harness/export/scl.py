"""Siemens SCL: one external source file for TIA Portal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.export.body import Scope
from rcx_harness.export.expressions import expression_text, init_text
from rcx_harness.export.output import NOTICE, Output
from rcx_harness.export.parts import Part, Sources
from rcx_harness.export.scl_body import Names, quoted, scl_body
from rcx_harness.export.words import blocks_of, unwritten, words

__all__ = ["to_scl"]

_ZEROS = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0", "TIME": "T#0s", "STRING": "''"}
_ORDER = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR", "VAR_TEMP")

#: The flip-flops, which SCL has not: the statements of IEC 61131-3, tables 34.1 and 34.2.
_FLIP_FLOPS = {
    "SR": ("S1", "R", "#S1 OR (NOT #R AND #Q1)"),
    "RS": ("S", "R1", "NOT #R1 AND (#S OR #Q1)"),
}

_PROGRAM = "written as FUNCTION_BLOCK; call an instance of it in a cyclic OB"
_CONFIGURATION = "set the cycle of the OB that calls the program"
_GLOBALS = "has global or located variables; make it again in TIA Portal"


def to_scl(sources: Sources) -> Output:
    """Write structures, functions and blocks; what SCL has no word for is written another way.

    Enumerations become INT, their members local constants of each block that uses them; named
    arrays are written out where they are used; programs become function blocks.
    """
    writer = _Writer(sources)
    texts, left_out = [f"{_lines(NOTICE)}{writer.enumerations()}"], []
    reasons = {
        part.name.upper(): _GLOBALS
        for part in sources.parts
        if isinstance(part.node, s.Pou) and _reaches_out(part.node)
    }
    barred = unwritten(sources.parts, words("scl"), reasons)
    texts += writer.flip_flops(one for one in sources.parts if one.name.upper() not in barred)
    for part in sources.parts:
        node = part.node
        if isinstance(node, s.Configuration):
            left_out.append(f"CONFIGURATION {part.name}: {_CONFIGURATION}")
        elif part.name.upper() in barred:
            left_out.append(f"{part.kind} {part.name}: {barred[part.name.upper()]}")
        elif isinstance(node, s.TypeDecl):
            if isinstance(node.spec, s.StructSpec):
                texts.append("\n".join(writer.structure(part, node.spec)))
        else:
            if part.kind == "PROGRAM":
                left_out.append(f"PROGRAM {part.name}: {_PROGRAM}")
            texts.append("\n".join(writer.pou(part, node)))
    return Output({"": "\n\n".join(texts) + "\n"}, tuple(left_out), newline="\r\n")


def _reaches_out(node: s.Pou) -> bool:
    return any(
        section.kind in ("VAR_EXTERNAL", "VAR_GLOBAL")
        or any(one.address is not None for one in section.variables)
        for section in node.sections
    )


def _lines(text: str) -> str:
    return "".join(f"// {line}".rstrip() + "\n" for line in text.splitlines())


def _note(text: str) -> str:
    return f"   // {' '.join(text.split())}" if text else ""


class _Writer:
    """Knows the types and functions of the sources."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources
        self._types = {
            part.name.upper(): part.node
            for part in sources.parts
            if isinstance(part.node, s.TypeDecl)
        }
        self._enums = [
            (part, part.node.spec)
            for part in sources.of("TYPE")
            if isinstance(part.node, s.TypeDecl) and isinstance(part.node.spec, s.EnumSpec)
        ]
        self._members = {
            member.key: (member.text, value)
            for _, spec in self._enums
            for value, member in enumerate(spec.members)
        }
        self._blocks = {part.name.upper() for part in sources.of("FUNCTION_BLOCK", "PROGRAM")}
        self._functions = {
            part.name.upper(): self._defaults(part.node)
            for part in sources.of("FUNCTION")
            if isinstance(part.node, s.Pou)
        }

    def enumerations(self) -> str:
        """All enumerations as comments, for those who call the blocks."""
        text = ["", "Enumerations are INT here; their members are constants of the blocks:"]
        for part, spec in self._enums:
            members = (f"{value} {name.text}" for value, name in enumerate(spec.members))
            text.append(f"  {part.name}: {', '.join(members)}")
        return _lines("\n".join(text)) if self._enums else ""

    def flip_flops(self, parts: Iterable[Part]) -> Iterator[str]:
        """The flip-flops that the parts use, as function blocks."""
        used = {key for part in parts for key in blocks_of(part)}
        for key, (first, second, value) in _FLIP_FLOPS.items():
            if key in used:
                name = words("scl").blocks[key].name
                yield "\n".join(
                    [
                        f'FUNCTION_BLOCK "{name}"',
                        "{ S7_Optimized_Access := 'TRUE' }\nVERSION : 0.1",
                        f"// {name}: the flip-flop {key} of IEC 61131-3, which SCL has not.",
                        f"   VAR_INPUT\n      {first} : BOOL;\n      {second} : BOOL;\n   END_VAR",
                        "   VAR_OUTPUT\n      Q1 : BOOL;\n   END_VAR",
                        f"BEGIN\n  #Q1 := {value};\nEND_FUNCTION_BLOCK",
                    ]
                )

    def structure(self, part: Part, spec: s.StructSpec) -> Iterator[str]:
        """A PLC data type."""
        yield f'TYPE "{part.name}"\nVERSION : 0.1\n{_lines(part.header)}   STRUCT'
        for field in spec.fields:
            yield from self._variables(field, part)
        yield "   END_STRUCT;\n\nEND_TYPE"

    def pou(self, part: Part, node: s.Pou) -> Iterator[str]:
        """A function or function block."""
        kind = "FUNCTION_BLOCK" if node.kind == "PROGRAM" else node.kind
        result = f" : {self._spec(node.result)}" if node.result is not None else ""
        yield f'{kind} "{part.name}"{result}'
        yield f"{{ S7_Optimized_Access := 'TRUE' }}\nVERSION : 0.1\n{_lines(part.header)}".rstrip()
        for wanted in _ORDER:
            for section in node.sections:
                if self._section(section, node) == wanted and section.qualifier != "CONSTANT":
                    yield f"   {wanted}{' RETAIN' if section.qualifier == 'RETAIN' else ''}"
                    initial = kind != "FUNCTION" and wanted != "VAR_TEMP"
                    for one in section.variables:
                        yield from self._variables(one, part, initial=initial)
                    yield "   END_VAR"
        names = Names(self._members, self._functions)
        body = scl_body(part.body, Scope.of(part, self._sources), names)
        constants = list(self._constants(part, node, body))
        if constants:
            yield "\n".join(["   VAR CONSTANT", *constants, "   END_VAR"])
        yield "\n".join(["BEGIN", *self._cleared(node), body, f"END_{kind}"])

    def _section(self, section: s.Section, node: s.Pou) -> str:
        """A function's variables are temporary."""
        return "VAR_TEMP" if node.kind == "FUNCTION" and section.kind == "VAR" else section.kind

    def _variables(self, one: s.VarDecl, part: Part, *, initial: bool = True) -> Iterator[str]:
        value = "" if one.initial is None or not initial else f" := {self._value(one.initial)}"
        for name in one.names:
            note = _note(part.notes.get(name.key, ""))
            yield f"      {quoted(name.text)} : {self._spec(one.spec)}{value};{note}"

    def _value(self, init: s.Init) -> str:
        if isinstance(init, s.Name) and init.key in self._members:
            return str(self._members[init.key][1])
        return init_text(init)

    def _spec(self, spec: s.TypeSpec) -> str:
        if isinstance(spec, s.ArraySpec):
            bounds = (
                f"{expression_text(one.low)}..{expression_text(one.high)}"
                for one in spec.dimensions
            )
            return f"Array[{', '.join(bounds)}] of {self._spec(spec.element)}"
        if isinstance(spec, s.EnumSpec):
            return "INT"
        if isinstance(spec, s.StructSpec):
            fields = " ".join(
                f"{name.text} : {self._spec(one.spec)};"
                for one in spec.fields
                for name in one.names
            )
            return f"STRUCT {fields} END_STRUCT"
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
        """The block's own constants and the members of enumerations that it uses."""
        for section in node.sections:
            if section.qualifier == "CONSTANT":
                for one in section.variables:
                    yield from self._variables(one, part)
        used = {word.upper() for word in body.replace("#", " #").split() if word.startswith("#")}
        marked = {"".join(c for c in word[1:] if c.isalnum() or c == "_") for word in used}
        for key in sorted(marked & self._members.keys(), key=self._rank):
            name, value = self._members[key]
            yield f"      {name} : INT := {value};"

    def _rank(self, key: str) -> int:
        return list(self._members).index(key)

    def _cleared(self, node: s.Pou) -> Iterator[str]:
        """Temporary variables begin with their initial values at each call; in SCL, with none."""
        if node.result is not None:
            yield f"  #{node.name.text} := {self._zero(node.result)};"
        for section in node.sections:
            if self._section(section, node) == "VAR_TEMP":
                for one in section.variables:
                    value = (
                        self._zero(one.spec) if one.initial is None else self._value(one.initial)
                    )
                    yield from (f"  #{quoted(name.text)} := {value};" for name in one.names)

    def _zero(self, spec: s.TypeSpec) -> str:
        return _ZEROS.get(self._spec(spec).upper(), "0")

    def _defaults(self, node: s.Pou) -> Mapping[str, str]:
        """What stands for each argument of a function that is left out."""
        return {
            name.key: self._zero(one.spec) if one.initial is None else self._value(one.initial)
            for section in node.sections
            if section.kind == "VAR_INPUT"
            for one in section.variables
            for name in one.names
        }
