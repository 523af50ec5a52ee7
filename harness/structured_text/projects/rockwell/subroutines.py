"""Parameters of routines: JSR passes values, SBR receives them, and RET returns values.

A routine is a method. Its inputs and outputs have the types of the tags of SBR and RET.

Source: 1756-RM003, JSR, SBR and RET: input parameters are copied to the tags of SBR before the
routine is executed, and the values of RET to the return parameters of JSR after it. The types must
be the same. A JSR with fewer inputs than SBR, or more returns than RET, is a major fault.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from structured_text.errors import VARIABLES, InputError
from structured_text.language.source import Line
from structured_text.projects.model import Lines, made
from structured_text.projects.rockwell.data import STORED, Data, Subroutine, Types
from structured_text.projects.rockwell.expression_reader import (
    ExpressionReader,
    Routine,
    Token,
    tokens_of,
)

__all__ = [
    "SubroutineReader",
    "declared_parameters",
    "jump_of",
    "received_by",
    "returned_by",
    "subroutine_of",
]

#: The end of `JSR(Routine, 0, 0)`, as some files have that are written by hand.
_EXTRA = [",", "0", ")"]
_INPUT, _RETURN = f"{VARIABLES}Input", f"{VARIABLES}Return"


def declared_parameters(routine: Subroutine, types: Types, at: int) -> Lines:
    """Return the sections that declare the parameters of a routine's method."""
    lines: Lines = ()
    sections = (("VAR_INPUT", _INPUT, routine.inputs), ("VAR_OUTPUT", _RETURN, routine.returns))
    for word, name, parameters in sections:
        if parameters:
            texts = [
                f"    {name}{number} : {types.written(data)};"
                for number, data in enumerate(parameters, 1)
            ]
            lines += made(at, f"  {word}", *texts, "  END_VAR")
    return lines


def subroutine_of(name: str, tokens: Sequence[Token], scope: Routine) -> Subroutine:
    """Return the parameters of a routine, from the first SBR and RET in its tokens.

    A parameter that cannot be read ends the list. The error is reported when its body is read.
    """
    lists: dict[str, tuple[Data, ...]] = {"SBR": (), "RET": ()}
    for place, token in enumerate(tokens[:-1]):
        if token.word in lists and tokens[place + 1].text == "(" and not lists[token.word]:
            reader = _Parameters(tokens[place + 2 :], token.at, scope)
            lists[token.word] = tuple(reader.types())
    return Subroutine(name, lists["SBR"], lists["RET"])


def jump_of(operands: Sequence[str], at: int, scope: Routine) -> str:
    """Return the call for a JSR of a rung, or raise InputError."""
    reader, token = _reader(operands, at, scope)
    return reader.jump(token)


def received_by(operands: Sequence[str], at: int, scope: Routine) -> list[str]:
    """Return the statements for a SBR of a rung, or raise InputError."""
    reader, token = _reader(operands, at, scope)
    return list(reader.received(token))


def returned_by(operands: Sequence[str], at: int, scope: Routine) -> list[str]:
    """Return the statements for a RET of a rung without its RETURN, or raise InputError."""
    reader, token = _reader(operands, at, scope)
    return list(reader.left(token))[:-1]


def _reader(operands: Sequence[str], at: int, scope: Routine) -> tuple[SubroutineReader, Token]:
    tokens = tokens_of([Line(f"{','.join(operands)})", at)])
    return SubroutineReader(tokens, at, scope), Token("end", "", at)


class SubroutineReader(ExpressionReader):
    """The reader of JSR, SBR and RET; the word and its parenthesis are already read."""

    def jump(self, token: Token) -> str:
        """Return the call for a JSR."""
        name = self._next()
        routine = self._routine.routines.get(name.word)
        if routine is None:
            raise self._error(f"there is no routine {name.text} in this program", token)
        given = self._routine.subroutines.get(name.word, Subroutine(routine))
        count = 0
        if self._take(","):
            number = self._next()
            if not number.text.isdigit():
                text = f"the second operand of JSR is {number.text!r}, not the number of inputs"
                raise self._error(text, token, "write JSR(Routine, count, inputs, returns)")
            count = int(number.text)
        arguments = []
        for place in range(count):
            self._expect(",")
            expected = given.inputs[place] if place < len(given.inputs) else None
            text = self._passed(expected, name.text, token)
            if expected is not None:
                arguments.append(f"{_INPUT}{place + 1} := {text}")
        if count < len(given.inputs):
            raise self._error(
                f"JSR passes {count} inputs to {name.text}, whose SBR has {len(given.inputs)}; the "
                "controller stops with a major fault",
                token,
                "pass a value for each tag of SBR",
            )
        behind = [self._peek(ahead).text for ahead in range(len(_EXTRA))]
        if not count and behind == _EXTRA:
            self._place += len(_EXTRA) - 1
        arguments += self._returned(given, name.text, token)
        self._expect(")")
        return f"{routine}({', '.join(arguments)});"

    def _passed(self, expected: Data | None, name: str, token: Token) -> str:
        """Read an input of JSR, and return its value in the type of SBR's tag."""
        found = self._whole_tag()
        if found is None:
            value = self._value()
            return self._converted(value, expected.type, token) if expected else value[0]
        text, data = found
        if expected and (data.type.upper(), data.sizes) != (expected.type.upper(), expected.sizes):
            raise self._error(
                f"JSR passes {text}, a {_said(data)}, to {name}, whose SBR has a "
                f"{_said(expected)} there",
                token,
                "use tags of the same type",
            )
        return f"{STORED[data.type]}_TO_{data.type}({text})" if data.stored else text

    def _whole_tag(self) -> tuple[str, Data] | None:
        """Read a parameter that is a tag; return None for a number or an expression."""
        place = self._place
        is_name = self._peek().kind == "name" and self._peek(1).text != "("
        if is_name and self._peek().word not in ("TRUE", "FALSE", "NOT"):
            found = self._variable()
            if self._peek().text in (",", ")"):
                return found
        self._place = place
        return None

    def _returned(self, given: Subroutine, name: str, token: Token) -> Iterator[str]:
        number = 0
        while self._take(","):
            number += 1
            if self._peek().kind == "number":
                text = f"JSR returns a value to {self._peek().text}, which is not a tag"
                raise self._error(text, token, "write JSR(Routine, count, inputs, returns)")
            text, data = self._variable(written=True)
            if number > len(given.returns):
                raise self._error(
                    f"JSR expects {number} or more values from {name}, whose RET has "
                    f"{len(given.returns)}; the controller stops with a major fault",
                    token,
                    "return a value for each return parameter of JSR",
                )
            kind = given.returns[number - 1]
            if (data.type.upper(), data.sizes) != (kind.type.upper(), kind.sizes) or data.stored:
                raise self._error(
                    f"JSR copies a {_said(kind)} of {name} to {text}, a {_said(data)}",
                    token,
                    "use a tag of the same type that is not an element of an array of SINT or INT",
                )
            yield f"{_RETURN}{number} => {text}"

    def received(self, token: Token) -> Iterator[str]:
        """Yield the statements for an SBR: its tags get the values of the inputs."""
        number = 0
        while not self._take(")"):
            if number:
                self._expect(",")
            number += 1
            text, data = self._variable(written=True)
            value = f"{_INPUT}{number}"
            if data.stored:
                value = f"{data.type}_TO_{STORED[data.type]}({value})"
            yield f"{text} := {value};"
        own = self._routine.own
        if own is None or number > len(own.inputs):
            raise self._error("SBR is not supported in a routine that JSR does not call", token)

    def left(self, token: Token) -> Iterator[str]:
        """Yield the statements for a RET: the outputs get their values, and the routine ends."""
        own = self._routine.own or Subroutine("")
        number = 0
        while not self._take(")"):
            if number:
                self._expect(",")
            number += 1
            if number > len(own.returns):
                raise self._error("another RET of this routine returns fewer values", token)
            kind = own.returns[number - 1]
            yield f"{_RETURN}{number} := {self._passed(kind, own.name, token)};"
        if number < len(own.returns):
            raise self._error("another RET of this routine returns more values", token)
        yield "RETURN;"


class _Parameters(SubroutineReader):
    """The reader of the types of SBR's and RET's parameters."""

    def types(self) -> Iterator[Data]:
        """Yield the types up to the closing parenthesis, or up to an unreadable parameter."""
        try:
            while not self._take(")"):
                self._take(",")
                data = self._whole_tag()
                yield Data(data[1].type, data[1].sizes) if data else Data(self._value()[1])
        except InputError:
            return


def _said(data: Data) -> str:
    sizes = "".join(f"[{size}]" for size in data.sizes)
    return f"{data.type}{sizes}"
