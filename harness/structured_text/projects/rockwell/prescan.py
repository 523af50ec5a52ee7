"""The prescan: what a controller does with all ladder routines before the first scan of any task.

It visits each routine that JSR can reach, whatever the conditions of its rungs are. The statements
for tags of the controller are in a function, which the first program calls; a program executes the
statements for its own tags at its first scan, before anything can have read them.

Source: 1756-PM018 and 1756-RM003, prescan of each instruction.
"""

from __future__ import annotations

import re
from collections.abc import Container, Mapping, Sequence

from structured_text.errors import VARIABLES
from structured_text.projects.model import Lines, Piece, made
from structured_text.projects.rockwell.data import First
from structured_text.projects.rockwell.expression_reader import Token

__all__ = [
    "DONE",
    "FUNCTION",
    "METHOD",
    "VARIABLE",
    "by_scope",
    "function",
    "in_order",
    "jumps_in",
    "of_program",
]

#: The function for the tags of the controller, and the variable that shows that it was called.
FUNCTION, VARIABLE = "L5X_PRESCAN", f"{VARIABLES}ControllerPrescanned"
#: The method of each program, and its variable.
METHOD, DONE = f"{VARIABLES}Prescan", f"{VARIABLES}Prescanned"
_WORD = re.compile(r"(?<![\w.])[^\W\d]\w*")


def jumps_in(tokens: Sequence[Token]) -> tuple[First, ...]:
    """Return the routines that a routine in Structured Text calls."""
    return tuple(
        First(routine=tokens[place + 2].word)
        for place, token in enumerate(tokens[:-2])
        if token.word == "JSR" and tokens[place + 1].text == "("
    )


def in_order(main: str, parts: Mapping[str, Sequence[First]]) -> list[First]:
    """Return the parts of the prescan of a program, in the order of its routines."""
    found: list[First] = []
    waiting, seen = [iter(parts.get(main, ()))], {main}
    while waiting:
        part = next(waiting[-1], None)
        if part is None:
            waiting.pop()
        elif not part.routine:
            found.append(part)
        elif part.routine not in seen:
            seen.add(part.routine)
            waiting.append(iter(parts.get(part.routine, ())))
    return found


def by_scope(parts: Sequence[First], own: Container[str]) -> tuple[list[str], list[str]]:
    """Return the lines for tags of the controller, and those for tags of the program.

    `own` has the names of the program's variables in upper case.
    """
    shared: list[str] = []
    mine: list[str] = []
    for part in parts:
        words = {word.upper() for line in part.lines for word in _WORD.findall(line)}
        is_own = any(word in own for word in words)
        (mine if is_own else shared).extend(part.lines)
    return _once(shared), _once(mine)


def _once(lines: list[str]) -> list[str]:
    """Return the lines without single statements that stand twice in a row."""
    return [line for place, line in enumerate(lines) if not place or lines[place - 1] != line]


def function(lines: Sequence[str], at: int) -> Lines:
    """Return the function with the statements for the tags of the controller."""
    return made(
        at,
        f"FUNCTION {FUNCTION} : BOOL",
        f"  IF NOT {VARIABLE} THEN",
        f"    {VARIABLE} := TRUE;",
        *(f"    {line}" for line in lines),
        "  END_IF;",
        "END_FUNCTION",
    )


def of_program(name: str, lines: Sequence[str], at: int, *, shared: bool) -> Piece:
    """Return the method with the prescan of a program.

    If `shared` is true, it first calls the prescan of the controller's tags.
    """
    call = (f"    {FUNCTION}();",) if shared else ()
    body = (
        f"  IF NOT {DONE} THEN",
        f"    {DONE} := TRUE;",
        *call,
        *(f"    {line}" for line in lines),
        "  END_IF;",
    )
    head = made(at, f"METHOD {METHOD}")
    return Piece(f"{name}.{METHOD}", head, made(at, *body), made(at, "END_METHOD"))
