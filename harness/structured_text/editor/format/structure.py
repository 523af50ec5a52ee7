"""The structure of a source: where statements begin, and how deeply they are nested.

`structure_of` reads the items once, with a stack of the open blocks. The source has no syntax
errors, so that each END closes the block at the top of the stack.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from structured_text.editor.format.items import SKIPPED_WORD, Item

__all__ = ["Begin", "Colon", "Part", "structure_of"]


class Begin(Enum):
    """Tells whether an item begins a line."""

    NO = "continues"
    LINE = "begins a line"
    AS_WRITTEN = "begins a line if it does so in the source"


class Colon(Enum):
    """The meaning of a colon."""

    NONE = ""
    TYPE = "before a type"
    DECLARED = "before the type of a variable"
    LABEL = "behind a label"


@dataclass
class Part:
    """An item with its place in the structure.

    Attributes:
        item: The item.
        begin: Whether the item begins a line.
        level: Number of open blocks around the statement of the item.
        depth: Number of open parentheses and brackets around the item.
        colon: The meaning, if the item is a colon.
        declares: Whether the item belongs to a declaration and stands before its initial value.
        closes: Whether the item ends a block or begins its next branch.
    """

    item: Item
    begin: Begin = Begin.NO
    level: int = 0
    depth: int = 0
    colon: Colon = Colon.NONE
    declares: bool = False
    closes: bool = False


class _State(Enum):
    START = "a statement begins"
    LABELLED = "a statement begins behind a label"
    HEAD = "in the first line of a POU"
    WORDS = "behind VAR, GET or SET, before the declarations"
    INSIDE = "in a statement"
    ENDED = "behind END"
    CATCH = "behind CATCH"


_POUS = frozenset(
    (
        *("FUNCTION", "FUNCTION_BLOCK", "PROGRAM", "CLASS", "INTERFACE", "METHOD", "PROPERTY"),
        *("ACTION", "NAMESPACE", "CONFIGURATION", "RESOURCE"),
    )
)
_LOOPS = frozenset(("IF", "WHILE", "FOR", "CASE"))
_OPENS_AT_ONCE = frozenset(("REPEAT", "TRY", "TYPE"))
_ACCESSORS = frozenset(("GET", "SET"))
_QUALIFIERS = frozenset(("CONSTANT", "RETAIN", "NON_RETAIN", "PERSISTENT", "WORD"))
_BRANCHES = frozenset(("ELSE", "ELSIF", "UNTIL", "CATCH", "FINALLY"))
_OPENING, _CLOSING = ("LPAR", "LSQB"), ("RPAR", "RSQB")
#: Blocks with declarations.
_DECLARING = frozenset(("STRUCT", "UNION", "TYPE"))
#: Tokens that can begin a CASE label, but not a statement.
_LABELS = frozenset(("LABEL", "INTEGER", "TYPED", "TRUE", "FALSE", "STRING", "MINUS"))
#: Words that begin a statement.
_STATEMENTS = frozenset(
    (
        *_LOOPS,
        *("REPEAT", "TRY", "RETURN", "EXIT", "CONTINUE", "THIS", "SUPER", "IDENT", "LABEL"),
        *("TASK", "METHOD", "PROPERTY", "ACTION", "GET", "SET", "RESOURCE", "PROGRAM", "USING"),
        *("TYPE", "FUNCTION", "FUNCTION_BLOCK", "CLASS", "INTERFACE", "NAMESPACE"),
    )
)
#: Tokens that can end a name or a type.
_OPERAND_ENDS = frozenset(("IDENT", "RPAR", "RSQB", "GT", "INTEGER", "TYPED", "STRING"))
#: Name of a label on the stack of blocks, and of the last branch of a CASE.
_LABEL, _OTHERWISE = ":", "OTHERWISE"


def structure_of(items: Iterable[Item]) -> list[Part]:
    """Return the items of a source with their places in its structure."""
    reader = _Reader()
    return [reader.read(item) for item in items]


class _Reader:
    """Follows the open blocks; `structure_of` creates it."""

    def __init__(self) -> None:
        self._blocks: list[str] = []
        self._state = _State.START
        self._depth = 0
        self._before = ""
        self._level = 0
        self._head = ""
        self._typed = False
        #: For each open CASE, its column and the column of its last label in the source.
        self._labels: list[tuple[int, int]] = []

    def read(self, item: Item) -> Part:
        """Return the part of the next item."""
        if not item.is_token or item.kind == SKIPPED_WORD:
            if self._depth or self._state == _State.INSIDE or item.kind == SKIPPED_WORD:
                return Part(item, level=self._level, depth=self._depth)
            return Part(item, Begin.AS_WRITTEN, len(self._blocks), self._depth)
        kind = item.kind
        part = self._token(kind, item)
        self._before = kind
        return part

    def _token(self, kind: str, item: Item) -> Part:
        if kind in _CLOSING:
            self._depth -= 1
        part = Part(item, depth=self._depth)
        if not self._depth:
            part.begin, part.closes = self._at_top(kind, item.column)
        part.level = self._level
        if kind in _OPENING:
            self._depth += 1
        elif kind in ("STRUCT", "UNION"):
            self._blocks.append(kind)
            self._state = _State.START
        elif kind == "COLON" and not self._depth:
            part.colon = self._colon()
        part.declares = self._state == _State.HEAD or (self._typed and self._declaring())
        if kind in ("ASSIGN", "LATCH") and not self._depth:
            self._typed = False
        return part

    def _declaring(self) -> bool:
        top = self._blocks[-1] if self._blocks else ""
        return top in _DECLARING or top.startswith("VAR")

    def _colon(self) -> Colon:
        if self._state == _State.HEAD:
            if self._head == "ACTION":
                self._state = _State.START
                return Colon.LABEL
            return Colon.TYPE
        if self._blocks and self._blocks[-1] == _LABEL and self._level == len(self._blocks) - 1:
            self._state = _State.LABELLED
            self._level = len(self._blocks)
            return Colon.LABEL
        if self._declaring() and not self._typed:
            self._typed = True
            return Colon.TYPE if self._blocks[-1] == "TYPE" else Colon.DECLARED
        return Colon.TYPE

    def _at_top(self, kind: str, column: int) -> tuple[Begin, bool]:
        """Return the beginning of a token outside of parentheses, and whether it closes a block."""
        if kind.startswith("END_"):
            self._close(kind)
            self._level = len(self._blocks)
            self._state = _State.ENDED
            return Begin.LINE, True
        if kind in _BRANCHES and self._state != _State.INSIDE:
            return self._branch(kind, column), True
        state = self._state
        if state == _State.CATCH and kind in ("LPAR", "RPAR"):
            self._state = state if kind == "LPAR" else _State.START
            return Begin.NO, False
        if state in (_State.ENDED, _State.CATCH):
            if kind == "SEMICOLON":
                self._state = _State.START
                return Begin.NO, False
            state = _State.START
        if state == _State.HEAD and self._ends_head(kind):
            state = _State.START
        if state == _State.WORDS and kind not in _QUALIFIERS:
            state = _State.START
        if state in (_State.START, _State.LABELLED):
            return self._statement(kind, state, column), False
        self._inside(kind)
        return Begin.NO, False

    def _close(self, kind: str) -> None:
        if kind == "END_CASE" and self._labels:
            self._labels.pop()
        if self._blocks and self._blocks[-1] == _LABEL:
            self._blocks.pop()
        if self._blocks:
            self._blocks.pop()

    def _branch(self, kind: str, column: int) -> Begin:
        if self._blocks and self._blocks[-1] == _LABEL:
            self._blocks.pop()
        if kind == "ELSE" and self._blocks and self._blocks[-1] == "CASE":
            self._blocks[-1] = _OTHERWISE
            outer, label = self._labels[-1]
            if outer < column == label:  # ELSE is written like a label
                self._blocks.append(_LABEL)
        self._level = max(0, len(self._blocks) - 1)
        self._state = _State.START if kind in ("ELSE", "FINALLY") else _State.INSIDE
        if kind == "CATCH":
            self._state = _State.CATCH
        return Begin.LINE

    def _ends_head(self, kind: str) -> bool:
        """Return whether a token behind the first words of a POU no longer belongs to them."""
        if kind.startswith("VAR") or self._before == "SEMICOLON":
            return True
        return self._before in _OPERAND_ENDS and kind in _STATEMENTS

    def _statement(self, kind: str, state: _State, column: int) -> Begin:
        """Read the first token of a statement."""
        top = self._blocks[-1] if self._blocks else ""
        if top in ("CASE", _LABEL) and kind in _LABELS:
            if top == _LABEL:
                self._blocks.pop()
            self._level = len(self._blocks)
            self._labels[-1] = self._labels[-1][0], column
            self._blocks.append(_LABEL)
            self._state = _State.INSIDE
            return Begin.LINE
        self._level = len(self._blocks)
        self._typed = False
        if kind == "SEMICOLON":
            self._state = _State.START
            return Begin.NO if self._before == "SEMICOLON" else Begin.LINE
        if kind in _POUS and not (kind == "PROGRAM" and top in ("RESOURCE", "CONFIGURATION")):
            self._blocks.append(kind)
            self._head = kind
            self._state = _State.HEAD
        elif kind.startswith("VAR") or kind in _ACCESSORS:
            self._blocks.append(kind)
            self._state = _State.WORDS
        elif kind in _OPENS_AT_ONCE:
            self._blocks.append(kind)
            self._state = _State.START
        elif kind in _LOOPS:
            self._blocks.append(kind)
            self._state = _State.INSIDE
            if kind == "CASE":
                self._labels.append((column, -1))
        else:
            self._state = _State.INSIDE
            behind = state == _State.LABELLED or self._before == "SEMICOLON"
            return Begin.AS_WRITTEN if behind else Begin.LINE
        return Begin.LINE

    def _inside(self, kind: str) -> None:
        """Read a token inside of a statement."""
        opened = kind == "OF" and self._blocks and self._blocks[-1] == "CASE"
        if opened or kind in ("SEMICOLON", "THEN", "DO"):
            self._state = _State.START
