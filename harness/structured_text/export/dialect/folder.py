"""Export to a folder with a body and tables for each POU, for tools with tables of variables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from structured_text.export.body import Scope
from structured_text.export.dialect.dialect import BYTES, Dialect, Names, dialect_body
from structured_text.export.initial import is_scalar, zero
from structured_text.export.losses import lost_configuration, reaching_out
from structured_text.export.output import Missing, Output
from structured_text.export.parts import Part, Sources, comment, enumerations
from structured_text.export.starts import Starts
from structured_text.export.words import mentioned, unwritten
from structured_text.language import syntax as s
from structured_text.language.standard import BLOCKS
from structured_text.language.tree import Symbol
from structured_text.language.types import BlockType, StructType, Type
from structured_text.language.walk import declared

__all__ = ["Row", "Tool", "cell", "tabbed", "to_folder"]

_FLAG = "TRUE once the initial values are set"
#: The advice for a CONFIGURATION, which is not exported.
_CONFIGURATION = "assign the program to a task of your project"


@dataclass(frozen=True)
class Row:
    """A line of a table, in the tool's words.

    Attributes:
        section: VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT or VAR; RESULT of a function, FIELD of a
            structure, MEMBER of an enumeration.
        initial: The initial value of the variable, or the number of the member; empty if there is
            none.
        retain: Whether the variable keeps its value when power is off.
    """

    name: str
    section: str
    type: str
    initial: str
    comment: str
    constant: bool = False
    retain: bool = False


@dataclass(frozen=True)
class Tool:
    """The properties by which tools differ in their folders.

    Attributes:
        dialect: The words of the tool.
        retained: The sections in which the tool has retained variables.
        tables: A function that returns the texts of a declaration's tables. The keys are the ends
            of the file names.
        readme: Instructions for the folder; `{renamed}`, `{order}` and the notes are inserted.
        notes: Texts about the library, by subject. They are used for subjects on which the library
            has no text.
    """

    dialect: Dialect
    retained: tuple[str, ...]
    tables: Callable[[list[Row]], Mapping[str, str]]
    readme: str
    notes: Mapping[str, str] = field(default_factory=dict)


def to_folder(sources: Sources, tool: Tool) -> Output:
    """Write bodies and tables; omit declarations with types that the tool lacks.

    A declaration that needs an omitted declaration is omitted as well.
    """
    writer = _Writer(sources, tool)
    files: dict[str, str] = {}
    for part in writer.carried:
        files.update(writer.files(part))
    if not tool.dialect.enumerations:
        files["types/enumerations.txt"] = writer.numbers()
    order = "\n".join(f"  {part.folder}/{part.name}" for part in writer.carried)
    renamed = ", ".join(f"{old} is {new}" for old, new in sorted(writer.renamed.items()))
    said, own, listed = sources.renaming.said, sources.names.notes, tool.dialect.listed
    notes = {key: said(own.get(f"{listed}_{key}", text)) for key, text in tool.notes.items()}
    steps = said(tool.readme).format(order=order, renamed=renamed or "none", **notes)
    files["README.txt"] = f"{sources.notice}\n\n{steps}"
    return Output(dict(sorted(files.items())), tuple(writer.missing), newline="\r\n")


def cell(text: str) -> str:
    """Return a comment as the text of a table's cell: one line without tabs."""
    return " ".join(text.split())


def tabbed(lines: Iterable[tuple[str, ...]]) -> str:
    """Return a table to paste, with tabs between cells and without titles."""
    return "".join("\t".join(line) + "\n" for line in lines)


class _Writer:
    """A writer of the files of a folder."""

    def __init__(self, sources: Sources, tool: Tool) -> None:
        self._names = Names(sources, tool.dialect)
        self._sources = sources
        self._tool = tool
        self._starts = Starts(
            sources.project,
            self._name,
            tool.dialect.name,
            self._names.literal,
            implicit=zero,
            declared=is_scalar,
            kept=self._is_kept,
        )
        self.renamed: dict[str, str] = {}
        self.missing: list[Missing] = []
        self.carried = list(self._choose(sources))

    def _choose(self, sources: Sources) -> Iterator[Part]:
        """Yield the declarations that the tool supports; report all others with the reason."""
        known = {part.name.upper() for part in sources.parts} | set(BLOCKS)
        reasons = {
            part.name.upper(): self._names.trouble(part, known) or self._outside(part)
            for part in sources.parts
        }
        barred = unwritten(sources.parts, self._tool.dialect.words_of, reasons)
        replaced: set[str] = set()
        for part in sources.parts:
            lost = barred.get(part.name.upper())
            if isinstance(part.node, s.Configuration):
                self.missing.append(lost_configuration(part, _CONFIGURATION))
            elif lost is not None:
                words = lost.why == BYTES or not replaced.isdisjoint(mentioned(part))
                if words and part.folder != "program":
                    replaced.add(part.name.upper())
                self.missing.append(replace(lost, replaced=part.name.upper() in replaced))
            elif _written(part, self._tool.dialect):
                yield part

    def _outside(self, part: Part) -> str:
        """Return the reason why a POU cannot be exported by itself; empty if it can."""
        if not isinstance(part.node, s.Pou):
            return ""
        if isinstance(self._names.base(part.node.result), s.StructSpec | s.ArraySpec):
            return "its result is a structure or an array"
        return reaching_out(part.node, "the tool")

    def files(self, part: Part) -> Iterator[tuple[str, str]]:
        """Yield path and text of each file for a declaration."""
        rows = list(self._rows(part))
        for ending, text in self._tool.tables(rows).items():
            yield f"{part.folder}/{part.name}{ending}", text
        if isinstance(part.node, s.Pou):
            yield f"{part.folder}/{part.name}.st", self._body(part, part.node)
            self.missing += self._starts.lost(part, part.node)

    def numbers(self) -> str:
        """Return all enumerations with the numbers of their members."""
        lines = enumerations(self._names.types.values())
        return "\n".join(
            [f"Enumerations are {self._names.dialect.types['INT']} here.", "", *lines, ""]
        )

    def _body(self, part: Part, node: s.Pou) -> str:
        result = f" : {self._names.spec(node.result)}" if node.result is not None else ""
        head = comment(f"{part.kind} {part.name}{result}\n\n{part.header}".strip())
        body = dialect_body(part.body, Scope.of(part, self._sources), self._names)
        return "\n".join([head, *self._started(node), body, ""])

    def _started(self, node: s.Pou) -> Iterator[str]:
        """Yield statements for the initial values that the tables cannot contain."""
        if node.result is not None:
            yield f"  {node.name.text} := {self._names.zero(node.result)};"
        yield from self._starts.statements(
            node, lambda one, symbol: self._names.start(one, symbol.type, symbol.initial)
        )

    def _is_kept(self, section: s.Section, symbol: Symbol) -> bool:
        """Return whether the table marks a variable as retained."""
        able = section.kind in self._tool.retained and not isinstance(symbol.type, BlockType)
        return section.qualifier == "RETAIN" and able

    def _rows(self, part: Part) -> Iterator[Row]:
        node = part.node
        if isinstance(node, s.TypeDecl) and isinstance(node.spec, s.EnumSpec):
            for value, member in enumerate(node.spec.members):
                note = cell(part.notes.get(member.key, ""))
                yield Row(member.text, "MEMBER", "", str(value), note)
        elif isinstance(node, s.TypeDecl) and isinstance(node.spec, s.StructSpec):
            kinds = self._names.project.types[node.name.key]
            assert isinstance(kinds, StructType)
            values = self._names.project.initial[node.name.key]
            for one in node.spec.fields:
                for name in one.names:
                    kind = dict(kinds.fields)[name.text]
                    yield self._row(part, name, one, "FIELD", kind, values[name.text])
        elif isinstance(node, s.Pou):
            if node.result is not None:
                yield Row(node.name.text, "RESULT", self._names.spec(node.result), "", "")
            for section, one, name in declared(node.sections):
                symbol = self._starts.symbol(node, name)
                place = "VAR" if section.kind == "VAR_TEMP" else section.kind
                row = self._row(part, name, one, place, symbol.type, symbol.initial)
                constant = symbol.constant and is_scalar(symbol.type)
                yield replace(row, constant=constant, retain=self._is_kept(section, symbol))
            for flag, kept in self._starts.flags(node).items():
                yield Row(flag, "VAR", self._names.dialect.types["BOOL"], "", _FLAG, retain=kept)

    def _row(
        self, part: Part, name: s.Name, one: s.VarDecl, section: str, kind: Type, value: Any
    ) -> Row:
        initial = self._names.cell(one, kind, value) if is_scalar(kind) else ""
        note = cell(part.notes.get(name.key, ""))
        return Row(self._name(name.text), section, self._names.spec(one.spec), initial, note)

    def _name(self, text: str) -> str:
        found = self._tool.dialect.name(text)
        if found != text:
            self.renamed[text] = found
        return found


def _written(part: Part, dialect: Dialect) -> bool:
    """Return whether files are written for a declaration.

    Named arrays have no files. Enumerations have files only if the tool has enumerations.
    """
    if not isinstance(part.node, s.TypeDecl):
        return True
    spec = part.node.spec
    return isinstance(spec, s.StructSpec) or (isinstance(spec, s.EnumSpec) and dialect.enumerations)
