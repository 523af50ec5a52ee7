"""The bodies of routines: Structured Text, ladder, function block diagrams and charts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.compiling import deeply
from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.model import Foreign, Lines
from structured_text.projects.rockwell import prescan
from structured_text.projects.rockwell.body import translated
from structured_text.projects.rockwell.charts.reader import read_chart
from structured_text.projects.rockwell.charts.translate import translated_chart
from structured_text.projects.rockwell.data import First, Types
from structured_text.projects.rockwell.expression_reader import Routine, tokens_of
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.rungs import read_rungs
from structured_text.projects.rockwell.ladder.translate import translated_rungs
from structured_text.projects.rockwell.sheets.diagram import diagram_of
from structured_text.projects.rockwell.sheets.reader import drawn_in, read_sheets
from structured_text.projects.rockwell.sheets.translate import translated_sheets
from structured_text.projects.xml import Element

__all__ = ["Routines", "code_in", "statements"]


class Routines:
    """The reader of the routines of a file.

    Args:
        file: The file.
        types: The types of the project.
        notes: The list that takes what a user may miss.
        options: The attributes of the controller.
    """

    def __init__(
        self, file: Path, types: Types, notes: list[str], options: Mapping[str, str]
    ) -> None:
        self._options = options
        self._file, self._types, self._notes = file, types, notes
        self._diagrams: dict[int, Diagram] = {}

    def diagram(self, routine: Element | None) -> Diagram | None:
        """Return the diagram that a routine was translated from; None for other routines."""
        return self._diagrams.get(id(routine))

    def body(
        self,
        routine: Element,
        scope: Routine,
        variables: dict[str, str] | None = None,
        *,
        may_return: bool = True,
    ) -> Lines | Foreign:
        """Return the statements of a routine.

        Variables that only this routine needs are added to `variables`, with their types. Without
        this argument, they are added to the program or instruction. If `may_return` is false,
        further statements follow the routine, and a rung does not leave it by RETURN.
        """
        kind = routine.get("Type")
        if kind not in ("ST", "RLL", "FBD", "SFC"):
            return Foreign(kind, routine.at)
        scope.take_cleared()  # what a routine that was refused has left
        try:
            if kind != "ST":
                body = Body(scope, may_return=may_return)
                return deeply(partial(self._drawn, routine, body, variables))
            lines = statements(routine)
            found = deeply(partial(translated, lines, scope))
            cleared = tuple(First((line,)) for line in scope.take_cleared())
            jumps = prescan.jumps_in(tokens_of(lines))
            scope.first[_key(routine)] = (*cleared, *jumps)
            return found
        except RecursionError:
            text = "has statements or expressions nested too deeply"
            return Foreign(kind, routine.at, text)
        except LadderError as error:
            hint = f" ({error.hint})" if error.hint else ""
            return Foreign(kind, error.at, f"{error.message}{hint}")
        except InputError as error:
            hint = f" ({error.hint})" if error.hint else ""
            return Foreign(kind, error.line or routine.at, f"{error.message}{hint}")

    def _drawn(self, routine: Element, body: Body, variables: dict[str, str] | None) -> Lines:
        """Return the statements of a ladder, function block diagram or chart."""
        if routine.get("Type") == "SFC":
            contents = drawn_in(routine, "SFCContent", self._note)
            chart = read_chart(contents[0] if contents else routine)
            found = translated_chart(chart, body, self._options)
        elif routine.get("Type") == "FBD":
            sheets = read_sheets(routine, self._note)
            found = translated_sheets(sheets, body)
            self._diagrams[id(routine)] = diagram_of(sheets, self._types)
        else:
            found = translated_rungs(read_rungs(routine, self._note), body)
        added = body.routine.added
        added.update(body.kept)
        body.routine.first[_key(routine)] = body.first
        self._notes += [f"{self._file}:{at}: {text}" for at, text in body.notes]
        (added if variables is None else variables).update(body.variables)
        return found

    def _note(self, text: str, element: Element) -> None:
        self._notes.append(f"{self._file}:{element.at}: {text}")


def code_in(element: Element) -> str:
    """Return the text of all routines below an element, in upper case."""
    texts = (one.text() for one in element.below("STContent", "Text"))
    operands = (one.get("Operand") for one in element.below("IRef", "ORef"))
    return "\n".join((*texts, *operands)).upper()


def statements(routine: Element) -> list[Line]:
    """Return the statements or rungs of a routine, as lines."""
    texts = (*routine.all("STContent", "Line"), *routine.all("RLLContent", "Rung", "Text"))
    return [line for one in texts for line in one.lines() if line.text.strip()]


def _key(element: Element) -> str:
    return element.get("Name").upper()
