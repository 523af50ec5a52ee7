"""The shapes of tags that only their uses in rungs and statements describe.

A member in a bit instruction is a BOOL, a member with bits is a DINT. An instruction with typed
parameters tells the type of its operands. Nothing tells the type of another number.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from structured_text.language.source import Line
from structured_text.projects.rockwell.data import NUMBERS
from structured_text.projects.rockwell.expression_reader import plain_tag
from structured_text.projects.rockwell.ladder.model import LadderError, instructions
from structured_text.projects.rockwell.ladder.neutral_text import read_rung
from structured_text.projects.rockwell.values import ENABLE
from structured_text.projects.xml import Element

__all__ = [
    "MODULE",
    "STEP",
    "Use",
    "module_names",
    "module_uses",
    "operands",
    "shape_value",
    "value_element",
]

#: Matches a tag of a module in a rung or statement, with its members, elements and bits.
_USED = re.compile(
    r"(?:\b(?P<bit>XIC|XIO|OTE|OTL|OTU)\s*\(\s*)?"
    r"(?P<tag>\b[^\W\d]\w*(?::\w+)?:[A-Z]{1,2}\d?\b)"
    r"(?P<rest>(?:\.\w+|\[(?!:=)[^\[\]]*\])*)(?P<closed>\s*\))?",
    re.IGNORECASE,
)
#: Matches a name that is not a part of another one.
_WORD = re.compile(r"(?<![\w.:\\])[^\W\d]\w*(?![\w:])")
#: The type of a parameter that stands for a module itself.
MODULE = "MODULE"
#: The flag of the first scan, which has the form of a module's tag.
_FIRST_SCAN = "S:FS"
#: Marks a text that is the target of an alias.
_ALIAS = "alias"
#: Marks a text that is the target of an alias for a floating-point number.
_FLOAT = "alias of a number with a point"
#: Matches a member, an element or a bit, but not the assignment `[:=]`.
STEP = re.compile(r"\.(\w+)|\[(?!:=)([^\[\]]*)\]")
#: Index of the highest bit of a member that is declared only by its uses.
_TOP_BIT = 31
#: Largest index of an array that is declared only by its uses.
_TOP_INDEX = 9_999


@dataclass
class Use:
    """The uses of a tag, or of a member or element of it."""

    at: int
    name: str = ""
    whole: bool = False
    flag: bool = False
    bits: bool = False
    refused: bool = False
    number: str = ""
    size: int = 0
    members: dict[str, Use] = field(default_factory=dict)
    element: Use | None = None

    def add(self, steps: list[tuple[str, str]], *, flag: bool, number: str) -> None:
        """Record a use with members, elements and bits."""
        if not steps and number:
            self.refused = self.refused or self.number not in ("", number)
            self.number = number
            return
        if not steps:
            self.flag, self.whole = self.flag or flag, self.whole or not flag
            return
        (member, index), rest = steps[0], steps[1:]
        if member.isdigit():
            self.bits = True
            self.refused = self.refused or bool(rest) or int(member[:9]) > _TOP_BIT
        elif member:
            self.members.setdefault(member.upper(), Use(self.at, member)).add(
                rest, flag=flag, number=number
            )
        elif index.strip().isdigit() and int(index.strip()[:9]) <= _TOP_INDEX:
            self.size = max(self.size, int(index) + 1)
            self.element = self.element or Use(self.at)
            self.element.add(rest, flag=flag, number=number)
        else:
            self.refused = True

    def merge(self, other: Use) -> None:
        """Add the uses of the same member elsewhere."""
        self.whole, self.flag = self.whole or other.whole, self.flag or other.flag
        self.bits, self.size = self.bits or other.bits, max(self.size, other.size)
        differ = bool(self.number and other.number) and self.number != other.number
        self.refused = self.refused or other.refused or differ
        self.number = self.number or other.number
        for key, member in other.members.items():
            self.members.setdefault(key, Use(member.at, member.name)).merge(member)
        if other.element is not None:
            self.element = self.element or Use(other.at)
            self.element.merge(other.element)

    def shape(self) -> str | Use | None:
        """Return DINT or BOOL, or the use itself if it is a structure or an array.

        Return None if the uses do not show a type: nothing tells the type of a whole number.
        """
        kinds = (self.bits, self.flag, bool(self.members), self.element is not None)
        if self.number and not self.refused and not any(kinds):
            return self.number  # an instruction tells the type of the number
        if self.number and not self.refused and self.number not in NUMBERS and kinds[2]:
            return self.number if sum(kinds) == 1 else None  # the members are those of its type
        if self.number:
            return None
        if self.refused or self.whole or sum(kinds) != 1:
            return None
        if self.bits or self.flag:
            return "DINT" if self.bits else "BOOL"
        parts = [*self.members.values()]
        if self.element is not None:
            if not isinstance(self.element.shape(), str):
                return None
            return self
        return None if any(one.shape() is None for one in parts) else self


def module_uses(root: Element) -> dict[str, Use]:
    """Return the uses of the tags of modules in a file, by the name of the tag."""
    found: dict[str, Use] = {}
    for text, at, kind in pieces_of_file(root):
        for one in _USED.finditer(text) if ":" in text else ():
            if one["tag"].upper() == _FIRST_SCAN:
                continue
            steps = STEP.findall(one["rest"])
            use = found.setdefault(one["tag"].upper(), Use(at, one["tag"]))
            if kind == _FLOAT:  # the alias of a REAL has this radix, no other type has it
                use.add(steps, flag=False, number="REAL")
            elif kind != _ALIAS:  # another alias shows no type; the uses of its name do
                flag = kind == "BOOL" or bool(one["bit"] and one["closed"])
                use.add(steps, flag=flag, number="" if kind == "BOOL" else kind)
    return found


def module_names(root: Element) -> Iterator[tuple[str, int]]:
    """Yield the operands that name a module, not a tag, and their lines."""
    kinds = _parameters(root)
    for routine in root.below("Routine"):
        for part in routine.below("Text"):
            for text, at, kind in operands(part, kinds):
                if kind.upper() == MODULE:
                    yield text, at


def _parameters(root: Element) -> dict[str, list[str]]:
    """Return the types of the required parameters of each instruction."""
    return {
        aoi.get("Name").upper(): _kinds_of(aoi) for aoi in root.below("AddOnInstructionDefinition")
    }


def pieces_of_file(root: Element) -> Iterator[tuple[str, int, str]]:
    """Yield the texts that mention tags, their lines, and the type that a whole text must have.

    An alias of a module's tag, or of a part of it, is replaced by the tag. The type is that of the
    parameter of an Add-On Instruction; it is empty if it is not known.
    """
    aliases = {
        tag.get("Name").upper(): tag.get("AliasFor")
        for tag in root.below("Tag")
        if ":" in tag.get("AliasFor")
    }

    def plain(text: str) -> str:
        return _WORD.sub(lambda word: aliases.get(word[0].upper(), word[0]), text)

    kinds = _parameters(root)
    for routine in root.below("Routine"):
        for part in routine.below("Text"):
            yield from ((plain(text), at, kind) for text, at, kind in operands(part, kinds))
        for part in routine.below("Line", "IRef", "ORef", "ICon"):
            yield plain(part.get("Operand") or part.text()), part.at, ""
    for tag in root.below("Tag", "LocalTag"):
        if tag.get("AliasFor"):
            floats = tag.get("Radix") in ("Float", "Exponential")
            yield tag.get("AliasFor"), tag.at, _FLOAT if floats else _ALIAS


def _kinds_of(aoi: Element) -> list[str]:
    """Return the types of the required parameters; empty for arrays and for InOut numbers."""
    return [
        _kind_of(one)
        for one in aoi.all("Parameters", "Parameter")
        if one.get("Required") == "true" and one.get("Name").upper() not in ENABLE
    ]


def _kind_of(parameter: Element) -> str:
    kind, in_out = parameter.get("DataType"), parameter.get("Usage") == "InOut"
    if kind.upper() in ("BOOL", *NUMBERS):
        return "" if in_out else kind.upper()
    sizes = (parameter.get("Dimensions") or "0").replace(",", " ").split()
    return plain_tag(kind) if in_out and not any(one != "0" for one in sizes) else ""


def operands(part: Element, kinds: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, int, str]]:
    """Yield the operands of a rung, their lines, and the types of the parameters in `kinds`.

    The first operand is written with its instruction, which may be a bit instruction.
    """
    try:
        rung = read_rung(part.lines() or [Line("", part.at)])
    except LadderError:
        yield part.text(), part.at, ""
        return
    for instruction in instructions(rung):
        known = ["", *kinds.get(instruction.name, ())]
        for number, operand in enumerate(instruction.operands):
            kind = known[number] if number < len(known) else ""
            text = f"{instruction.name}({operand})" if number == 0 else operand
            yield text, instruction.at, kind


def value_element(shape: str | Use, name: str, at: int) -> Element:
    """Return decorated data from which a type can be derived."""
    return Element("Data", {"Format": "Decorated"}, at, [shape_value(shape, "", name, at)], at)


def shape_value(shape: str | Use, member: str, name: str, at: int) -> Element:
    """Return the decorated value of a member, or of a tag if `member` is empty."""
    behind = "Member" if member else ""
    named = {"Name": member} if member else {}
    if isinstance(shape, str):
        return Element(f"DataValue{behind}", {**named, "DataType": shape}, at, [], at)
    if shape.element is not None:
        kind = shape.element.shape()
        attributes = {**named, "DataType": str(kind), "Dimensions": str(shape.size)}
        return Element(f"Array{behind}", attributes, at, [], at)
    content = [
        shape_value(inner, one.name, f"{name}_{one.name}", at)
        for one in shape.members.values()
        if (inner := one.shape()) is not None
    ]
    attributes = {**named, "DataType": name}
    return Element(f"Structure{behind}", attributes, at, list(content), at)
