"""The statements of a Logix routine, translated to Structured Text of the standard."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from structured_text.language.source import Line
from structured_text.projects.rockwell.copies import Place, copied
from structured_text.projects.rockwell.data import INTEGERS, STORED, Data
from structured_text.projects.rockwell.expression_reader import (
    COUNTER,
    Routine,
    Token,
    bare,
    tokens_of,
)
from structured_text.projects.rockwell.sheets.blocks import CALLED, NO_TEXT
from structured_text.projects.rockwell.sheets.statements import no_array
from structured_text.projects.rockwell.subroutines import SubroutineReader
from structured_text.projects.rockwell.system import SYSTEM_HINT, is_known_class, note_of

__all__ = ["translated"]

#: Matches an index that is not a number.
_VARYING = re.compile(r"\[[^\]]*[^\d\s,\]]")
_ENDS = ("END_IF", "ELSIF", "ELSE", "END_CASE", "END_FOR", "END_WHILE", "UNTIL", "END_REPEAT", "")
#: Instructions for texts, with the number of arguments behind the first one.
_TEXTS = {"MID": 3, "DELETE": 3, "CONCAT": 2, "INSERT": 3}


def translated(lines: Sequence[Line], routine: Routine) -> tuple[Line, ...]:
    """Return the statements of a routine in the standard's language, or raise InputError."""
    last = lines[-1].at if lines else 1
    made = _Statements(tokens_of(lines), last, routine)
    return tuple(made.block("  ", whole=True))


class _Statements(SubroutineReader):
    # --- statements -----------------------------------------------------------------------

    def block(self, indent: str, *, whole: bool = False) -> list[Line]:
        """Return the statements up to an END, or to the end of the routine."""
        found: list[Line] = []
        while whole or self._peek().word not in _ENDS:
            if self._peek().kind == "end":
                break
            if self._take(";"):
                continue
            found += self._statement(indent)
        return found

    def _statement(self, indent: str) -> Iterator[Line]:
        token = self._peek()
        special = {
            "IF": self._if,
            "CASE": self._case,
            "FOR": self._for,
            "WHILE": self._while,
            "REPEAT": self._repeat,
        }.get(token.word)
        if special is not None:
            self._next()
            yield from special(indent, token)
            self._take(";")
            return
        if token.word in ("EXIT", "RETURN"):
            self._next()
            yield Line(f"{indent}{token.word};", token.at)
        elif token.kind == "name" and self._peek(1).text == "(":
            for text in self._call():
                yield Line(f"{indent}{text}", token.at)
        elif token.kind == "name":
            for text in self._assignment():
                yield Line(f"{indent}{text}", token.at)
        else:
            raise self._error(f"{token.text!r} is not expected here", token)
        self._expect(";")

    def _if(self, indent: str, token: Token) -> Iterator[Line]:
        yield Line(f"{indent}IF {self._condition()} THEN", token.at)
        self._expect("THEN")
        yield from self.block(indent + "  ")
        while self._peek().word in ("ELSIF", "ELSE"):
            branch = self._next()
            if branch.word == "ELSIF":
                yield Line(f"{indent}ELSIF {self._condition()} THEN", branch.at)
                self._expect("THEN")
            else:
                yield Line(f"{indent}ELSE", branch.at)
            yield from self.block(indent + "  ")
        yield self._end_of("IF", indent)

    def _case(self, indent: str, token: Token) -> Iterator[Line]:
        yield Line(f"{indent}CASE {self._whole(self._value())} OF", token.at)
        self._expect("OF")
        while self._peek().kind == "number" or self._peek().word == "-":
            yield self._labels(indent + "  ")
            yield from self._branch(indent + "    ")
        if self._peek().word == "ELSE":
            yield Line(f"{indent}ELSE", self._next().at)
            self._take(":")
            yield from self.block(indent + "  ")
        yield self._end_of("CASE", indent)

    def _branch(self, indent: str) -> Iterator[Line]:
        """Yield the statements of a CASE branch, up to the next label."""
        while self._peek().word not in ("ELSE", "END_CASE") and self._peek().kind != "end":
            if self._peek().kind == "number" or self._peek().word == "-":
                return
            if self._take(";"):
                continue
            yield from self._statement(indent)

    def _labels(self, indent: str) -> Line:
        first = self._peek()
        text = ""
        while self._peek().word != ":":
            token = self._next()
            if token.kind not in ("number", "sign"):
                raise self._error("a label of CASE must be a number", token)
            text += {",": ", "}.get(token.text, token.text)
        self._next()
        return Line(f"{indent}{text}:", first.at)

    def _for(self, indent: str, token: Token) -> Iterator[Line]:
        counter, data = self._variable()
        kind = data.type
        if data.sizes or kind not in INTEGERS:
            raise self._error(f"{counter} is not a whole number", token)
        self._expect(":=")
        start = self._converted(self._value(), kind, token)
        self._expect("TO")
        end = self._converted(self._value(), kind, token)
        step = ""
        if self._take("BY"):
            step = f" BY {self._converted(self._value(), kind, token)}"
        self._expect("DO")
        yield Line(f"{indent}FOR {counter} := {start} TO {end}{step} DO", token.at)
        yield from self.block(indent + "  ")
        yield self._end_of("FOR", indent)

    def _while(self, indent: str, token: Token) -> Iterator[Line]:
        yield Line(f"{indent}WHILE {self._condition()} DO", token.at)
        self._expect("DO")
        yield from self.block(indent + "  ")
        yield self._end_of("WHILE", indent)

    def _end_of(self, word: str, indent: str) -> Line:
        """Read the END of a statement, and return the translated line."""
        at = self._peek().at
        self._expect(f"END_{word}")
        return Line(f"{indent}END_{word};", at)

    def _repeat(self, indent: str, token: Token) -> Iterator[Line]:
        yield Line(f"{indent}REPEAT", token.at)
        yield from self.block(indent + "  ")
        until = self._peek()
        self._expect("UNTIL")
        yield Line(f"{indent}UNTIL {self._condition()}", until.at)
        self._take(";")
        yield self._end_of("REPEAT", indent)

    def _assignment(self) -> Iterator[str]:
        token = self._peek()
        target, data = self._variable(written=True)
        types = self._routine.types
        if self._take("[:=]"):
            self._routine.cleared.append(self._cleared(target, data, token))
        else:
            self._expect(":=")
        value = self._value()
        if types.is_string(data) or value[1] == "STRING":
            if not (types.is_string(data) and value[1] == "STRING"):
                raise self._error(f"{target} and the value are not both texts", token)
            yield f"{target} := {value[0]};"
        elif types.is_simple(data):
            text = self._converted(value, data.type, token)
            if data.stored:
                text = f"{data.type}_TO_{STORED[data.type]}({text})"
            yield f"{target} := {bare(text)};"
        else:
            raise self._error(f"{target} is copied by COP, not assigned", token)

    def _cleared(self, target: str, data: Data, token: Token) -> str:
        """Return the statement of the prescan for a tag left of `[:=]`."""
        if not self._routine.types.is_simple(data) or _VARYING.search(target):
            text = f"[:=] is not supported for {target}"
            raise self._error(text, token, "write :=, and clear it in the first scan")
        zero = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0"}.get(data.type, "0")
        return f"{target} := {f'{STORED[data.type]}#0' if data.stored else zero};"

    # --- calls ----------------------------------------------------------------------------

    def _call(self) -> Iterator[str]:
        token = self._next()
        name = token.word
        self._expect("(")
        types = self._routine.types
        if name == "JSR":
            yield self.jump(token)
        elif name == "SBR":
            yield from self.received(token)
        elif name == "RET":
            yield from self.left(token)
        elif name in types.protected:
            raise self._error(
                f"the source of {token.text} is protected and not in the file",
                token,
                "write it in Structured Text, and call that",
            )
        elif name in types.instructions:
            yield self._instruction(token)
        elif name in CALLED and name not in NO_TEXT:
            yield self._block(token)
        elif name in ("COP", "CPS"):
            yield from self._copy(token)
        elif name == "SIZE":
            yield self._size_of(token)
        elif name in ("GSV", "SSV", "EVENT"):
            self._system(token)
        elif name in _TEXTS:
            yield self._text_call(token)
        elif name == "FIND":
            yield from self._find(token)
        else:
            raise self._error(f"the instruction {token.text} is not supported", token)

    def _system(self, token: Token) -> None:
        """Read GSV, SSV or EVENT, of which only a note remains."""
        operands = [""]
        while self._peek().text not in (")", ""):
            if self._take(","):
                operands.append("")
                if len(operands) == len(("Class", "Instance", "Attribute", "Tag")):
                    start = self._place
                    self._variable(written=token.word == "GSV", element=False)
                    operands[-1] = "".join(one.text for one in self._tokens[start : self._place])
                    break
            else:
                operands[-1] += self._next().text
        while self._peek().text not in (")", ""):
            self._next()  # the index of the tag
        self._expect(")")
        if len(operands) != (1 if token.word == "EVENT" else 4):
            raise self._error(f"{token.text} has {len(operands)} operands", token)
        if token.word != "EVENT" and not is_known_class(operands[0]):
            text = f"{token.text} of {operands[0]} is not supported"
            raise self._error(text, token, SYSTEM_HINT)
        self._routine.notes.append((token.at, note_of(token.word, *operands)))

    def _instruction(self, token: Token) -> str:
        """Translate `Block(Instance, a, b)`; the arguments are the required parameters."""
        instance, data = self._variable()
        if data.type.upper() != token.word:
            raise self._error(f"{instance} is not a {token.text}", token)
        types = self._routine.types
        members = types.members[token.word]
        block = types.instructions[token.word]
        arguments = ["EnableIn := TRUE"] if block.false_routine else []
        for name, usage in block.parameters:
            if not self._take(","):
                raise self._error(f"{token.text} has no argument for {name}", token)
            kind = members[name.upper()]
            if usage == "Input":
                value = self._converted(self._value(), kind.type, token)
                arguments.append(f"{name} := {value}")
            else:
                target, given = self._variable()
                if usage == "Output" and given.type != kind.type:
                    raise self._error(f"{target} is not a {kind.type}, the type of {name}", token)
                arguments.append(f"{name} {'=>' if usage == 'Output' else ':='} {target}")
        if not self._take(")"):
            raise self._error(f"{token.text} has too many arguments", token)
        return f"{instance}({', '.join(arguments)});"

    def _block(self, token: Token) -> str:
        """Translate `TONR(Tag)`, and `MAVE(Tag, Storage, Weights)`."""
        called = CALLED[token.word]
        instance, data = self._variable()
        if data.type.upper() != called.type or data.sizes:
            raise self._error(f"{instance} is not a {called.type}", token)
        arguments = [called.settings] if called.settings else []
        if "ENABLEIN" in self._routine.types.read_members:  # a text executes it in any case
            arguments.insert(0, "EnableIn := TRUE")
        for name in called.arrays:
            self._expect(",")
            if name in called.optional and self._peek().text == "0":
                self._next()
                arguments.append(f"{name} := {no_array(self._routine)}")
                continue
            text, kind = self._variable(element=False)
            if kind.type != "REAL" or len(kind.sizes) != 1:
                raise self._error(f"{text} is not an array of REAL", token)
            arguments.append(f"{name} := {text}")
        self._expect(")")
        return f"{instance}({', '.join(arguments)});"

    def _copy(self, token: Token) -> Iterator[str]:
        """Translate COP(Source, Dest, Length): a whole tag, or elements of equal arrays."""
        source, target = self._place_of(), self._place_of()
        length = self._whole(self._value())
        self._expect(")")
        try:
            lines, counts = copied(Place(*source), Place(*target), length)
        except ValueError as error:
            hint = "convert element by element"
            raise self._error(f"{token.text} {error}", token, hint) from None
        if counts:
            self._routine.needs.add(COUNTER)
        yield from lines

    def _size_of(self, token: Token) -> str:
        """Translate SIZE(Source, Dimension, Dest)."""
        text, data, index = self._place_of()
        if index != "0":
            raise self._error(f"SIZE of {text}[{index}] is not supported", token, "use element 0")
        dimension = self._next().text
        self._expect(",")
        target, kind = self._variable(written=True)
        self._expect(")")
        if dimension not in ("0", "1", "2") or int(dimension) >= len(data.sizes):
            raise self._error(f"{text} has no dimension {dimension}", token)
        value = (str(data.sizes[int(dimension)]), "DINT")
        return f"{target} := {self._converted(value, kind.type, token)};"

    def _place_of(self) -> tuple[str, Data, str]:
        """Return an array, its type and the index at which a copy begins.

        For a tag without an index, the index is 0.
        """
        text, data = self._variable(element=False)
        index = "0"
        if data.sizes and self._take("["):
            index = self._whole(self._value())
            self._expect("]")
        self._expect(",")
        return text, data, index

    def _text_call(self, token: Token) -> str:
        name = token.word
        source = self._string()
        texts: list[str] = []
        while self._take(","):
            number = len(texts) < 2 if name in ("MID", "DELETE") else len(texts) == 1
            is_number = number and name != "CONCAT"
            texts.append(self._whole(self._value()) if is_number else self._string())
        self._expect(")")
        if len(texts) != _TEXTS[name]:
            raise self._error(f"{token.text} has {_TEXTS[name] + 1} arguments", token)
        target = texts.pop()
        if name == "INSERT":
            second, place = texts
            return f"{target} := INSERT({source}, {second}, {place} - 1);"
        return f"{target} := {name}({', '.join([source, *texts])});"

    def _find(self, token: Token) -> Iterator[str]:
        """Translate FIND(Source, Search, Start, Result).

        The standard's FIND has no start. The text is cut before Start, and the result is shifted
        back.
        """
        source = self._string()
        self._expect(",")
        searched = self._string()
        self._expect(",")
        start = self._whole(self._value())
        self._expect(",")
        target, kind = self._variable(written=True)
        self._expect(")")
        inside = source if start == "1" else f"MID({source}, LEN({source}), {start})"
        found = self._converted((f"FIND({inside}, {searched})", "INT"), kind.type, token)
        yield f"{target} := {found};"
        if start != "1":
            yield f"IF {target} > 0 THEN"
            first = self._converted((start, "DINT"), kind.type, token)
            yield f"  {target} := {target} + {first} - 1;"
            yield "END_IF;"

    def _string(self) -> str:
        token = self._peek()
        text, kind = self._value()
        if kind != "STRING":
            raise self._error("a text is needed here", token)
        return text


def _sum(start: str) -> str:
    return COUNTER if start == "0" else f"{start} + {COUNTER}"


def _element(text: str, data: Data, index: str) -> str:
    return f"{text}[{index}]" if data.sizes else text
