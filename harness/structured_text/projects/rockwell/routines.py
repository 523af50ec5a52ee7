"""The bodies of routines: Structured Text, ladder and function block diagrams."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.compiling import deeply
from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.model import Foreign, Lines
from structured_text.projects.rockwell import prescan
from structured_text.projects.rockwell.body import translated
from structured_text.projects.rockwell.data import Types
from structured_text.projects.rockwell.expression_reader import Routine, tokens_of
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.rungs import read_rungs
from structured_text.projects.rockwell.ladder.translate import translated_rungs
from structured_text.projects.rockwell.sheets.diagram import diagram_of
from structured_text.projects.rockwell.sheets.reader import read_sheets
from structured_text.projects.rockwell.sheets.translate import translated_sheets
from structured_text.projects.xml import Element

__all__ = ["Routines", "statements"]


class Routines:
    """The reader of the routines of a file.

    Args:
        file: The file.
        types: The types of the project.
        notes: The list that takes what a user may miss.
    """

    def __init__(self, file: Path, types: Types, notes: list[str]) -> None:
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
        if kind not in ("ST", "RLL", "FBD"):
            return Foreign(kind, routine.at)
        try:
            if kind != "ST":
                body = Body(scope, may_return=may_return)
                return deeply(partial(self._drawn, routine, body, variables))
            lines = statements(routine)
            scope.first[_key(routine)] = prescan.jumps_in(tokens_of(lines))
            return deeply(partial(translated, lines, scope))
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
        """Return the statements of a ladder or function block diagram routine."""
        if routine.get("Type") == "FBD":
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


def statements(routine: Element) -> list[Line]:
    """Return the statements or rungs of a routine, as lines."""
    texts = (*routine.all("STContent", "Line"), *routine.all("RLLContent", "Rung", "Text"))
    return [line for one in texts for line in one.lines() if line.text.strip()]


def _key(element: Element) -> str:
    return element.get("Name").upper()
