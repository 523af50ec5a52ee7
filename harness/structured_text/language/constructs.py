"""Constructs beyond the portable subset, with their names and portable alternatives.

The built-in engine runs all of them. A tool that knows only the portable subset refuses a program
with such a construct and names it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.objects import INIT
from structured_text.language.syntax import Position

__all__ = ["CONSTRUCTS", "TRANSLATED", "Use", "refuse"]

#: Constructs that the checker translates to nodes which `prove` supports. Each value is advice on
#: what to write instead in a portable program. `prove` itself refuses unsupported types,
#: conversions and functions.
_TRANSLATED = {
    "a comment with // or /* */": "write (* ... *)",
    "a comment inside a comment": "end the outer comment first",
    "a keyword in another spelling": "write FUNCTION_BLOCK",
    "an access specifier": "leave it out",
    "VAR_IN_OUT CONSTANT": "use VAR_INPUT",
    "a pragma": "remove it",
    "a REGION": "use a comment",
    "an empty statement": "remove the ;",
    "an empty branch": "leave the branch out, or invert the condition",
    "no ; after END": "write END_IF; and END_STRUCT; with semicolon",
    "no END of a POU": "write END_PROGRAM, END_FUNCTION_BLOCK or END_FUNCTION",
    "a ; behind the name of a POU": "remove the ;",
    "a comma behind the last argument": "remove the comma",
    "an empty initial value": "leave it out",
    "conditional compilation": "leave one of its branches",
    "a name with __ or _ at its end": "choose another name",
    "a reserved word as a name": "choose another name",
    "a variable called as something else": "choose a name that nothing else has",
    "a number such as 1E3": "write 1.0E3",
    "# before a name": "leave it out",
    "STRING with a length": "use plain STRING",
    "a subrange": "use its base type, and check the value",
    "a member with the name of its enumeration": "write the member alone",
    "a constant instead of a literal": "write the number",
    "a constant expression": "write its value",
    "an initial value without brackets": "write it in [ ]",
    "VAR_GLOBAL outside a CONFIGURATION": "declare it in the CONFIGURATION",
    "a global without VAR_EXTERNAL": "declare it in VAR_EXTERNAL",
    "several qualifiers": "use one",
    "PERSISTENT": "use RETAIN",
    "an incomplete address": "write the address",
    "a bit by its number": "use AND, SHL and SHR",
    "a part of a word": "use AND, SHL and SHR",
    "S= or R=": "use IF and an assignment",
    "several targets of an assignment": "write one assignment for each",
    "a CASE of bit strings": "convert to an integer first",
    "a written VAR_INPUT": "copy it to a variable of its own",
    "a variable of a block that is not a pin": "make it a VAR_OUTPUT",
    "an implicit conversion": "call the conversion",
    "arithmetic of bit strings": "convert to integers first",
    "a bitwise operation of integers": "convert to bit strings first",
    "the negative of an unsigned integer": "convert to a signed integer first",
    "a standard function with another meaning": "choose another name",
    "a number times a duration": "write the duration first",
    "a type of the third edition": "use a type of the second edition",
    "a standard block of the third edition": "use a block of the second edition",
    "a standard function beyond the second edition": "use a function of the second edition",
    "a standard function of dates or BCD": "use operators, or calculate it",
    "a number with 10#": "leave 10# out",
    "a text over several lines": "write $N for each line end",
    "a name with letters beyond ASCII": "use A to Z, digits and _",
    "RETURN with a condition": "use IF and RETURN",
    "the type BIT": "use BOOL",
    "EN or ENO": "use IF",
    "a negative step of an unsigned counter": "use a signed counter, or WHILE",
    "a source in Windows-1252": "save the file as UTF-8",
    "another name of a pin": "use the name of the second edition",
    "the name of a POU as a text": "write the text",
    "the size of a block": "write the number",
}
TRANSLATED = frozenset(_TRANSLATED)
#: All constructs beyond the portable subset, each with advice on what to write instead.
CONSTRUCTS = _TRANSLATED | {
    "an enumeration with values": "leave the values out",
    "an enumeration with a base type": "leave the base type out",
    "an enumeration without a name": "declare a TYPE",
    "a structure without a name": "declare a TYPE",
    "a UNION": "use a STRUCT and convert",
    "an array of blocks": "declare each block as a variable of its own",
    "a block in a structure": "declare the block as a variable of its own",
    "an initial value of a block": "give the inputs in the call",
    "the assignment of a block": "assign its variables",
    "VAR_STAT": "use VAR of a block",
    "VAR_INST": "use VAR of a block",
    "VAR_GENERIC": "write a block for each value",
    "VAR_EXTERNAL in a FUNCTION": "give it as an input",
    "a section in another place": "use VAR",
    "a located array": "locate each element as a variable of its own",
    "a located structure": "locate each field as a variable of its own",
    "a function without VAR_INPUT": "use a block",
    "a function without a result": "use a block",
    "a function that never sets its result": "assign to its name",
    "a function with VAR_OUTPUT or VAR_IN_OUT": "use a block",
    "a block in a function": "use a block",
    "a block in another section than VAR": "declare it in VAR",
    "a FOR counter that is not a plain variable": "use a variable of its own",
    "a number as an enumeration": "use a member",
    "an enumeration as a number": "use CASE",
    "inputs of a function left out": "give every input",
    "named and positional arguments together": "name them all",
    "a result that is not used": "assign it",
    "an ACTION": "use a block",
    "a PROGRAM called by its name": "use a block, and global variables",
    "several PROGRAMs without a CONFIGURATION": "write a CONFIGURATION",
    "an array of open length": "write the bounds",
    "the time as a function": "measure with a TON",
    "a calculated initial value": "assign it in the first scan",
    "a name as a statement": "remove it, or call the block with ()",
    "a CLASS": "use a FUNCTION_BLOCK",
    "VAR_CONFIG": "write the address at the variable",
    "a structure as its base": "assign the fields",
    "a METHOD": "use a block or function of its own",
    "a PROPERTY": "use VAR_INPUT and VAR_OUTPUT",
    "an INTERFACE": "call each block by its name",
    "EXTENDS": "declare the other block as a variable",
    "IMPLEMENTS": "leave it out, and call the block by its name",
    "THIS or SUPER": "name the variable itself",
    "POINTER TO": "use a VAR_IN_OUT",
    "REFERENCE TO": "use a VAR_IN_OUT",
    "ADR or REF": "use a VAR_IN_OUT",
    "memory looked at as another type": "convert, or use the functions of texts",
    "pointers compared by < or >": "compare indices",
    "a character of a text by its number": "use MID",
    "a NAMESPACE": "write the name without it",
    f"arguments of {INIT}": "give them as inputs of the call",
    "a CASE of texts": "use IF",
    "?=": "declare a variable of the interface that you need",
    "functions of one name": "give each function a name of its own",
    "ANY": "write a function for each type",
    "__QUERYINTERFACE or __QUERYPOINTER": "declare a variable of the interface that you need",
    "__NEW or __DELETE": "declare the variable",
    "a program of _INIT and _CYCLIC": "write one PROGRAM, and begin with IF in the first scan",
    "CONTINUE": "use IF",
    "a selection of pointers or interfaces": "use IF",
    "a pointer as a number": "compare pointers with each other, or with 0",
    "a VAR_IN_OUT read outside of its block": "read the variable that the call passes",
    "a function of memory": "assign or compare the variables",
    "__TRY": "test values before they are used",
    "an LTIME of more than 292 years": "use a shorter duration",
    "an assignment in an expression": "assign in a statement before",
    "AND_THEN or OR_ELSE": "use IF inside IF",
    "a member of a call's result": "assign the result to a variable first",
    "a written output of a block": "write it inside the block",
    "pins as VAR_IN_OUT": "copy them to a variable first",
}

#: Other advice on what to write instead, for details to which the advice on their construct does
#: not apply.
_DETAILS = {
    "a constant instead of a literal (a member of an enumeration)": (
        "declare the other operand, or the target, as that enumeration"
    ),
}


@dataclass(frozen=True)
class Use:
    """A construct at a position in the sources; `detail` describes the occurrence."""

    construct: str
    file: Path
    at: Position
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.construct} ({self.detail})" if self.detail else self.construct

    @property
    def instead(self) -> str:
        """Return the portable alternative for the message."""
        return _DETAILS.get(str(self), CONSTRUCTS[self.construct])


def refuse(uses: Iterable[Use], tool: str, carried: Collection[str] = ()) -> None:
    """Raise an error if a program has constructs that a tool does not support.

    `carried` are the names of the supported constructs.

    Raises:
        InputError: The program has an unsupported construct. The message names the first one.
    """
    left = [one for one in uses if one.construct not in carried]
    if left:
        first = min(left, key=lambda one: (str(one.file), one.at))
        names = sorted({one.construct for one in left} - {first.construct})
        more = f"; also {', '.join(names)}" if names else ""
        raise InputError(
            f"{tool} does not take {first}{more}",
            file=first.file,
            line=first.at.line,
            column=first.at.column,
            hint=first.instead,
        )
