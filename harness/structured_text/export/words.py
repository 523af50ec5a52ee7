"""The functions, blocks and operators in the Structured Text of each tool, with their sources.

The lists are in `words/*.toml`. An export uses only functions, blocks and operators on the tool's
list.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from structured_text.errors import BLOCKS
from structured_text.export.losses import missing
from structured_text.export.output import Missing
from structured_text.export.parts import Part
from structured_text.language import syntax as s
from structured_text.language.standard import BLOCKS as STANDARD
from structured_text.language.standard import FUNCTIONS, conversion, reserved
from structured_text.language.walk import nodes
from structured_text.output.toml_files import load_toml

__all__ = ["FOLDER", "Form", "Words", "blocks_of", "mentioned", "unwritten", "words"]

#: The folder with the lists of all tools.
FOLDER = Path(__file__).parent / "words"

#: Placeholder in the lists for the prefix of blocks that an export adds.
_ADDED = "{added}"
_CALL = re.compile(r"(\w+)\((.*)\)")
_COMPARED = ("=", "<>", "<", ">", "<=", ">=")
_CHAINED = ("CONCAT", "MAX", "MIN")
_OF_EDITION_3 = ("AND_THEN", "OR_ELSE")
_OTHERWISE = {
    **dict.fromkeys(("SEL", "MAX", "MIN", "LIMIT"), "write IF"),
    "MUX": "write CASE",
    "MOVE": "write :=",
    "EXPT": "write a product",
    "**": "write EXPT(IN1 := a, IN2 := b)",
    **dict.fromkeys(("SHL", "SHR", "ROL", "ROR"), "multiply or divide by a power of 2"),
    "EXP": "compute it before, or pass it in",
    "LOG": "write LN(IN := x) / 2.302585",
    "SR": "write Q1 := S1 OR (NOT R AND Q1)",
    "RS": "write Q1 := NOT R1 AND (S OR Q1)",
    "F_TRIG": "write R_TRIG with NOT before its input",
    **dict.fromkeys(("TOF", "TP"), "write it with TON"),
    **dict.fromkeys(("MULTIME", "DIVTIME"), "compute in milliseconds"),
    "RETURN": "put the following statements into an IF",
    "FOR": "write WHILE",
}


@dataclass(frozen=True)
class Form:
    """The form of a function or block in a tool.

    Attributes:
        name: Name of the function or block; for an operator, its sign.
        parameters: Names in the tool. A name with `:=` is written in calls; `...` stands for more
            parameters.
    """

    name: str
    parameters: tuple[str, ...]

    @property
    def is_operator(self) -> bool:
        """Return whether the function is an operator, which is written between its operands."""
        return not self.parameters

    def text(self, key: str, arguments: list[str]) -> str:
        """Return a call of the standard function `key`.

        If the tool's function takes fewer arguments, calls are nested.
        """
        if self.is_operator:
            return self._operation([f"({one.strip()})" for one in arguments])
        listed = len(self.parameters)
        if key in _CHAINED and "..." not in self.parameters and len(arguments) > listed:
            first = self.text(key, arguments[:listed])
            return self.text(key, [first, *arguments[listed:]])
        named = (f"{self._named(at)}{one.lstrip()}" for at, one in enumerate(arguments))
        plain = zip(named, arguments, strict=True)
        kept = (f"{one[: len(one) - len(one.lstrip())]}{text}" for text, one in plain)
        return f"{self.name}({','.join(kept)})"

    def _named(self, at: int) -> str:
        """Return the parameter name that the tool writes before an argument.

        The result is "" if the tool writes no name.
        """
        last = len(self.parameters) - (self.parameters[-1] == "...")
        parameter = self.parameters[min(at, last - 1)]
        if not parameter.endswith(":="):
            return ""
        name = parameter.removesuffix(":=").strip()
        if at >= last:
            stem = name.rstrip("0123456789")
            name = f"{stem}{int(name[len(stem) :]) + at - last + 1}"
        return f"{name} := "

    def _operation(self, operands: list[str]) -> str:
        if self.name in _COMPARED and len(operands) > 2:
            pairs = (operands[at : at + 2] for at in range(len(operands) - 1))
            return f"({' AND '.join(map(self._operation, pairs))})"
        return operands[0] if len(operands) == 1 else f"({f' {self.name} '.join(operands)})"

    def takes(self, key: str, count: int) -> bool:
        """Return whether the tool's function can be called with this number of arguments."""
        if self.is_operator or key in _CHAINED or "..." in self.parameters:
            return True
        return count <= len(self.parameters)


@dataclass(frozen=True)
class Words:
    """The list of a tool.

    Attributes:
        functions: Standard functions by their names in IEC 61131-3.
        blocks: Standard blocks by their names in IEC 61131-3, with pins in the standard's order.
        conversions: Types among which each conversion `X_TO_Y` exists.
        operators: Signs and words of expressions.
        statements: Words that statements begin with.
        instructions: The instructions that statements of Logix call.
        instead: For Logix, what to write instead of something that it does not have.
    """

    tool: str
    functions: Mapping[str, Form]
    blocks: Mapping[str, Form]
    conversions: Collection[str]
    operators: Collection[str]
    statements: Collection[str]
    instructions: Mapping[str, Form]
    instead: Mapping[str, str]

    def lacks(self, part: Part, functions: Collection[str]) -> Missing | None:
        """Return the first item in a declaration that is not on the list, with its replacement.

        The result is None if all items are on the list.

        `functions` are the names of the sources' functions, in upper case.
        """
        if isinstance(part.node, s.Configuration):
            return None
        first = next(self.lacking(part.node, functions), None)
        return missing(part, first[1], at=first[0]) if first is not None else None

    def lacking(
        self, node: s.Pou | s.TypeDecl, functions: Collection[str]
    ) -> Iterator[tuple[s.Position, str]]:
        """Yield the position of each item that is not on the list, and what to write instead.

        Items of the third edition of IEC 61131-3 are skipped, because they are reported as
        constructs beyond the portable subset. `functions` are the names of the sources' functions,
        in upper case.
        """
        for what, name, at in _used(node, functions):
            if not self._has(what, name):
                key, _, count = name.partition("/")
                if what in ("function", "block") and not reserved(key):
                    continue
                of = f" of {count} arguments" if key in self.functions else ""
                said = f"{key}{of} is not on the list for {self.tool}"
                yield at, f"{said}; {self._otherwise(what, key)}"

    def _has(self, what: str, name: str) -> bool:
        if what == "function":
            key, _, count = name.partition("/")
            types = conversion(key)
            if types is not None:
                return set(types) <= set(self.conversions)
            return key in self.functions and self.functions[key].takes(key, int(count))
        known = {"block": self.blocks, "operator": self.operators, "statement": self.statements}
        return name in known[what]

    def _otherwise(self, what: str, name: str) -> str:
        if name == "**" and "EXPT" not in self.functions:
            return _OTHERWISE["EXPT"]
        if name in _OTHERWISE:
            return _OTHERWISE[name]
        types = conversion(name)
        if types is not None and "STRING" in types:
            return "texts of numbers differ from tool to tool; write your own"
        if types is not None:
            return "its unit differs from tool to tool, and some tools do not have it"
        if name.startswith(("CTU", "CTD")):
            return "count with R_TRIG and an addition"
        return "use functions that are on the list" if what == "function" else "write it otherwise"


@cache
def words(name: str) -> Words:
    """Return the list of functions, blocks and operators in a file of `FOLDER`."""
    content = load_toml(FOLDER / f"{name}.toml")

    def forms(section: str) -> dict[str, Form]:
        made = {}
        for key, (text, _) in content.get(section, {}).items():
            text = text.replace(_ADDED, BLOCKS)
            call = _CALL.fullmatch(text)
            listed = tuple(one.strip() for one in call[2].split(",")) if call else ()
            made[key] = Form(call[1] if call else text, listed)
        return made

    lists = {key: tuple(listed) for key, (listed, _) in content["language"].items()}
    return Words(
        content["tool"],
        forms("functions"),
        forms("blocks"),
        lists["conversions"],
        lists["operators"],
        lists["statements"],
        forms("instructions"),
        {key: text.replace(_ADDED, BLOCKS) for key, text in content.get("instead", {}).items()},
    )


def unwritten(
    parts: Collection[Part], list_of: Words, barred: Mapping[str, str] | None = None
) -> dict[str, Missing]:
    """Return the declarations that cannot be written, by upper-case name, with the reason.

    A declaration cannot be written if it uses something that is not on the list, or needs another
    declaration that cannot be written. In `parts`, each declaration follows the declarations that
    it needs. `barred` are other reasons by upper-case name; an empty text means no reason.
    """
    functions = {part.name.upper() for part in parts if part.kind == "FUNCTION"}
    names = {part.name.upper(): part.name for part in parts}
    found: dict[str, Missing] = {}
    for part in parts:
        if part.kind == "CONFIGURATION":
            continue
        why = (barred or {}).get(part.name.upper())
        lost = missing(part, why) if why else list_of.lacks(part, functions)
        needed = next((names[one] for one in mentioned(part) if one in found), None)
        if lost is None and needed is not None:
            lost = missing(part, f"needs {needed}, which cannot be exported")
        if lost is not None:
            found[part.name.upper()] = lost
    return found


def blocks_of(part: Part) -> set[str]:
    """Return the standard blocks of which a declaration contains instances."""
    used = () if isinstance(part.node, s.Configuration) else _used(part.node, ())
    return {name for what, name, _ in used if what == "block"}


def mentioned(part: Part) -> Iterator[str]:
    """Yield all names in a declaration, in upper case."""
    every = nodes(part.node, names=True)
    return (node.key for node in every if isinstance(node, s.Name))


def _used(
    node: s.Pou | s.TypeDecl, functions: Collection[str]
) -> Iterator[tuple[str, str, s.Position]]:
    """Yield kind, name and position of each standard function, operator, block and statement.

    The name of a function is followed by `/` and its number of arguments.
    """
    for one in nodes(node):
        if isinstance(one, s.Call) and one.function.key not in functions:
            key = one.function.key
            if key in FUNCTIONS or conversion(key) is not None:
                yield "function", f"{key}/{len(one.arguments)}", one.at
        elif isinstance(one, s.Binary) and one.op not in _OF_EDITION_3:
            yield "operator", "AND" if one.op == "&" else one.op, one.at
        elif isinstance(one, s.Unary):
            yield "operator", one.op, one.at
        elif isinstance(one, s.NamedSpec) and one.name.key in STANDARD:
            yield "block", one.name.key, one.name.at
        elif isinstance(one, s.If | s.Case | s.For | s.While | s.Repeat | s.Exit | s.Return):
            yield "statement", type(one).__name__.upper(), one.at
