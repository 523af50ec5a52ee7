"""The routines of programs and instructions: their statements, and the diagrams of their rungs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.compiling import deeply
from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.model import Foreign, Lines, made, without_comments
from structured_text.projects.rockwell import prescan
from structured_text.projects.rockwell.body import translated
from structured_text.projects.rockwell.charts.reader import read_chart
from structured_text.projects.rockwell.charts.translate import translated_chart
from structured_text.projects.rockwell.data import First, Types
from structured_text.projects.rockwell.expression_reader import Routine, plain_tag, tokens_of
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.diagram import diagram_of
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.rungs import read_rungs
from structured_text.projects.rockwell.ladder.translate import translated_rungs
from structured_text.projects.rockwell.sheets.diagram import diagram_of as sheets_diagram
from structured_text.projects.rockwell.sheets.reader import drawn_in, read_sheets
from structured_text.projects.rockwell.sheets.translate import translated_sheets
from structured_text.projects.xml import Element

__all__ = ["Read", "RoutineReader", "chosen", "code_of", "copies", "declarations", "returns"]
__all__ += ["statements_of"]


@dataclass(frozen=True)
class Read:
    """A routine that was read: its statements, and the diagram of its rungs."""

    body: Lines | Foreign = ()
    diagram: Diagram | None = None


class RoutineReader:
    """The reader of the routines of a file.

    Args:
        file: The file.
        types: The types of the project.
        notes: The list to which notes are added.
        options: The attributes of the controller.
    """

    def __init__(
        self, file: Path, types: Types, notes: list[str], options: Mapping[str, str]
    ) -> None:
        self._options = options
        self._file, self._types, self._notes = file, types, notes

    def read(
        self,
        routine: Element,
        scope: Routine,
        variables: dict[str, str] | None = None,
        *,
        may_return: bool = True,
    ) -> Read:
        """Return the statements of a routine.

        Variables that only this routine needs are added to `variables`, with their types. Without
        this argument, they are added to the program or instruction. If `may_return` is false,
        further statements follow the routine, and a rung does not leave it by RETURN.
        """
        kind = routine.get("Type")
        if kind not in ("ST", "RLL", "FBD", "SFC"):
            return Read(Foreign(kind, routine.at))
        scope.take_cleared()  # what a routine that was refused has left
        try:
            if kind != "ST":
                body = Body(scope, may_return=may_return)
                return deeply(partial(self._drawn, routine, body, variables))
            lines = statements_of(routine)
            found = deeply(partial(self._text, lines, scope))
            cleared = tuple(First((line,)) for line in scope.take_cleared())
            jumps = prescan.jumps_in(tokens_of(lines))
            scope.first[_key(routine)] = (*cleared, *jumps)
            return Read(found)
        except RecursionError:
            text = "has statements or expressions nested too deeply"
            return Read(Foreign(kind, routine.at, text))
        except LadderError as error:
            hint = f" ({error.hint})" if error.hint else ""
            return Read(Foreign(kind, error.at, f"{error.message}{hint}"))
        except InputError as error:
            hint = f" ({error.hint})" if error.hint else ""
            return Read(Foreign(kind, error.line or routine.at, f"{error.message}{hint}"))

    def _text(self, lines: list[Line], scope: Routine) -> Lines:
        before = len(scope.notes)
        found = translated(lines, scope)
        self._notes += [f"{self._file}:{at}: {text}" for at, text in scope.notes[before:]]
        return found

    def _drawn(self, routine: Element, body: Body, variables: dict[str, str] | None) -> Read:
        """Return the statements and the diagram of a ladder, function block diagram or chart."""
        diagram = None
        if routine.get("Type") == "SFC":
            contents = drawn_in(routine, "SFCContent", self._note)
            chart = read_chart(contents[0] if contents else routine)
            found = translated_chart(chart, body, self._options)
        elif routine.get("Type") == "FBD":
            sheets = read_sheets(routine, self._note)
            found = translated_sheets(sheets, body)
            diagram = sheets_diagram(sheets, self._types)
        else:
            rungs = read_rungs(routine, self._note)
            found = translated_rungs(rungs, body)
            diagram = diagram_of(rungs, body)
        added = body.routine.added
        added.update(body.kept)
        body.routine.first[_key(routine)] = body.first
        self._notes += [f"{self._file}:{at}: {text}" for at, text in body.notes]
        (added if variables is None else variables).update(body.variables)
        return Read(found, diagram)

    def _note(self, text: str, element: Element) -> None:
        self._notes.append(f"{self._file}:{element.at}: {text}")


def statements_of(routine: Element) -> list[Line]:
    """Return the statements or rungs of a routine, as lines."""
    texts = (*routine.all("STContent", "Line"), *routine.all("RLLContent", "Rung", "Text"))
    return [line for one in texts for line in one.lines() if line.text.strip()]


def chosen(condition: str, one: Lines, other: Lines, at: int) -> Lines:
    """Return the statements of an IF with two branches, of which one may be empty."""
    if not _acts(one):
        condition, one, other = f"NOT {condition}", other, one
    if not _acts(one):
        return ()
    lines = made(at, f"  IF {condition} THEN")
    lines += tuple(replace(line, text=f"  {line.text}") for line in one)
    if _acts(other):
        lines += made(at, "  ELSE")
        lines += tuple(replace(line, text=f"  {line.text}") for line in other)
    return (*lines, *made(at, "  END_IF;"))


def _acts(lines: Lines) -> bool:
    """Return whether some lines have statements and not only comments."""
    return bool(without_comments("\n".join(line.text for line in lines)).strip())


def returns(lines: Lines) -> bool:
    """Return whether a RETURN may leave the statements."""
    return any(line.text.strip() == "RETURN;" for line in lines)


def code_of(element: Element) -> str:
    """Return the text of all routines below an element, in upper case."""
    texts = (one.text() for one in element.below("STContent", "Text"))
    operands = (one.get("Operand") for one in element.below("IRef", "ORef"))
    return "\n".join((*texts, *operands)).upper()


def declarations(variables: Mapping[str, str]) -> Iterator[str]:
    """Yield the section with some variables, if there are any."""
    kinds: dict[str, list[str]] = {}
    for name, kind in variables.items():
        kinds.setdefault(kind, []).append(name)
    for kind, names in kinds.items():
        yield f"  VAR {', '.join(names)} : {kind}; END_VAR"


def copies(parameters: Iterable[Element], usage: str) -> Iterator[Line]:
    """Yield the copy statements between the parameters of an instruction and its local tags.

    Inputs are copied before the statements of the instruction, outputs after them.
    """
    for one in parameters:
        if one.get("TagType") == "Alias" and one.get("Usage") == usage and one.get("AliasFor"):
            pin, tag = plain_tag(one.get("Name")), plain_tag(one.get("AliasFor"))
            pair = (tag, pin) if usage == "Input" else (pin, tag)
            yield from made(one.at, f"  {pair[0]} := {pair[1]};")


def _key(routine: Element) -> str:
    return routine.get("Name").upper()
