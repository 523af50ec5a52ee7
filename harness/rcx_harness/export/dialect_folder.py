"""A folder for tools that keep variables in tables: a body and its tables for each POU."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.standard import BLOCKS
from rcx_harness.export.body import Scope
from rcx_harness.export.dialect import Dialect, Names
from rcx_harness.export.dialect_body import dialect_body
from rcx_harness.export.output import NOTICE, Output
from rcx_harness.export.parts import Part, Sources, comment
from rcx_harness.export.words import unwritten

__all__ = ["Row", "Tool", "cell", "tabbed", "to_folder"]

_PROGRAM = "has global or located variables; make it again in the tool"
_CONFIGURATION = "assign the program to a task of your project"


@dataclass(frozen=True)
class Row:
    """A line of a table, in the tool's words.

    Attributes:
        section: VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT or VAR; RESULT of a function, FIELD of a
            structure, MEMBER of an enumeration.
        initial: Its initial value; the number of a member; empty if there is none.
    """

    name: str
    section: str
    type: str
    initial: str
    comment: str
    constant: bool = False


@dataclass(frozen=True)
class Tool:
    """What differs from tool to tool.

    Attributes:
        tables: Texts of a declaration's tables by what their names end in.
        readme: What to do with the folder; `{renamed}` and `{order}` are filled in.
    """

    dialect: Dialect
    tables: Callable[[list[Row]], Mapping[str, str]]
    readme: str


def to_folder(sources: Sources, tool: Tool) -> Output:
    """Write bodies and tables; what the tool has no type for is left out, and what needs it."""
    writer = _Writer(sources, tool)
    files: dict[str, str] = {}
    for part in writer.carried:
        files.update(writer.files(part))
    if not tool.dialect.enumerations:
        files["types/enumerations.txt"] = writer.numbers()
    order = "\n".join(f"  {part.folder}/{part.name}" for part in writer.carried)
    renamed = ", ".join(f"{old} is {new}" for old, new in sorted(writer.renamed.items()))
    steps = tool.readme.format(order=order, renamed=renamed or "none")
    files["README.txt"] = f"{NOTICE}\n\n{steps}"
    return Output(dict(sorted(files.items())), tuple(writer.left_out), newline="\r\n")


def cell(text: str) -> str:
    """A comment as a table's cell: on one line, without tabs."""
    return " ".join(text.split())


def tabbed(lines: Iterable[tuple[str, ...]]) -> str:
    """A table to paste: cells separated by tabs, without a line of titles."""
    return "".join("\t".join(line) + "\n" for line in lines)


class _Writer:
    def __init__(self, sources: Sources, tool: Tool) -> None:
        self._names = Names(sources, tool.dialect)
        self._sources = sources
        self._tool = tool
        self.renamed: dict[str, str] = {}
        self.left_out: list[str] = []
        self.carried = list(self._choose(sources))

    def _choose(self, sources: Sources) -> Iterator[Part]:
        """The parts that the tool can have; why it cannot have the others."""
        known = {part.name.upper() for part in sources.parts} | set(BLOCKS)
        reasons = {
            part.name.upper(): self._names.trouble(part, known) or _outside(part)
            for part in sources.parts
        }
        barred = unwritten(
            sources.parts,
            self._tool.dialect.words_of,
            {name: why for name, why in reasons.items() if why},
        )
        for part in sources.parts:
            why = barred.get(part.name.upper())
            if why is not None:
                self.left_out.append(f"{part.kind} {part.name}: {why}")
            elif _written(part, self._tool.dialect):
                yield part

    def files(self, part: Part) -> Iterator[tuple[str, str]]:
        """Path and text of a declaration's files."""
        rows = list(self._rows(part))
        for ending, text in self._tool.tables(rows).items():
            yield f"{part.folder}/{part.name}{ending}", text
        if isinstance(part.node, s.Pou):
            yield f"{part.folder}/{part.name}.st", self._body(part, part.node)

    def numbers(self) -> str:
        """All enumerations with the numbers of their members."""
        lines = [
            f"{name}: {', '.join(f'{value} {member.text}' for value, member in members)}"
            for name, members in self._enumerations()
        ]
        return "\n".join(
            [f"Enumerations are {self._names.dialect.types['INT']} here.", "", *lines, ""]
        )

    def _enumerations(self) -> Iterator[tuple[str, Iterable[tuple[int, s.Name]]]]:
        for node in self._names.types.values():
            if isinstance(node.spec, s.EnumSpec):
                yield node.name.text, enumerate(node.spec.members)

    def _body(self, part: Part, node: s.Pou) -> str:
        result = f" : {self._names.spec(node.result)}" if node.result is not None else ""
        head = comment(f"{part.kind} {part.name}{result}\n\n{part.header}".strip())
        body = dialect_body(part.body, Scope.of(part, self._sources), self._names)
        return "\n".join([head, *self._cleared(node), body, ""])

    def _cleared(self, node: s.Pou) -> Iterator[str]:
        """A function's variables begin with their initial values at each call."""
        if node.result is None:
            return
        yield f"  {node.name.text} := {self._names.zero(node.result)};"
        for section in node.sections:
            if section.kind not in ("VAR", "VAR_TEMP") or section.qualifier == "CONSTANT":
                continue
            for one in section.variables:
                value = self._names.start(one)
                yield from (f"  {self._name(name.text)} := {value};" for name in one.names)

    def _rows(self, part: Part) -> Iterator[Row]:
        node = part.node
        if isinstance(node, s.TypeDecl) and isinstance(node.spec, s.EnumSpec):
            for value, member in enumerate(node.spec.members):
                note = cell(part.notes.get(member.key, ""))
                yield Row(member.text, "MEMBER", "", str(value), note)
        elif isinstance(node, s.TypeDecl) and isinstance(node.spec, s.StructSpec):
            for one in node.spec.fields:
                yield from self._variables(part, one, "FIELD")
        elif isinstance(node, s.Pou):
            if node.result is not None:
                yield Row(node.name.text, "RESULT", self._names.spec(node.result), "", "")
            for section in node.sections:
                kind = "VAR" if section.kind == "VAR_TEMP" else section.kind
                constant = section.qualifier == "CONSTANT"
                for one in section.variables:
                    for row in self._variables(part, one, kind):
                        yield replace(row, constant=constant)

    def _variables(self, part: Part, one: s.VarDecl, section: str) -> Iterator[Row]:
        initial = "" if one.initial is None else self._names.value(one.initial)
        for name in one.names:
            note = cell(part.notes.get(name.key, ""))
            kind = self._names.spec(one.spec)
            yield Row(self._name(name.text), section, kind, initial, note)

    def _name(self, text: str) -> str:
        found = self._tool.dialect.name(text)
        if found != text:
            self.renamed[text] = found
        return found


def _written(part: Part, dialect: Dialect) -> bool:
    """Whether a declaration has files: no named arrays, enumerations where the tool has them."""
    if not isinstance(part.node, s.TypeDecl):
        return True
    spec = part.node.spec
    return isinstance(spec, s.StructSpec) or (isinstance(spec, s.EnumSpec) and dialect.enumerations)


def _outside(part: Part) -> str:
    """Why a declaration belongs to the project around it."""
    if isinstance(part.node, s.Configuration):
        return _CONFIGURATION
    if not isinstance(part.node, s.Pou):
        return ""
    reaches = any(
        section.kind in ("VAR_EXTERNAL", "VAR_GLOBAL")
        or any(one.address is not None for one in section.variables)
        for section in part.node.sections
    )
    return _PROGRAM if reaches else ""
