"""The tags of modules: `Local:1:I` of the inputs, `:O` of the outputs, `:C` of the configuration.

An L5X does not list these tags. Their names follow from the modules' places, and their types from
the decorated values. A module in a chassis has its parent's name and its slot, a module of a
network its own name.

Source: 1756-PM004, I/O tag addresses: Location:Slot:Type.Member.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from structured_text.language.source import Line
from structured_text.projects.rockwell.data import NUMBERS
from structured_text.projects.rockwell.decorated import value_of
from structured_text.projects.rockwell.ladder.model import LadderError, instructions
from structured_text.projects.rockwell.ladder.neutral_text import read_rung
from structured_text.projects.rockwell.values import ENABLE
from structured_text.projects.xml import Element

__all__ = ["ModuleTags", "module_tags"]

#: Networks on which a module has an address, but no slot.
_NETWORKS = ("ETHERNET", "CONTROLNET", "DEVICENET", "SERIAL", "DH+", "RIO", "USB")
#: Matches a tag of a module in a rung or statement, with its members, elements and bits.
_USED = re.compile(
    r"(?:\b(?P<bit>XIC|XIO|OTE|OTL|OTU)\s*\(\s*)?"
    r"(?P<tag>\b[^\W\d]\w*(?::\w+)?:[A-Z]{1,2}\d?\b)"
    r"(?P<rest>(?:\.\w+|\[[^\[\]]*\])*)(?P<closed>\s*\))?",
    re.IGNORECASE,
)
#: Matches a name that is not a part of another one.
_WORD = re.compile(r"(?<![\w.:\\])[^\W\d]\w*(?![\w:])")
#: Marks a text that is the target of an alias.
_ALIAS = "alias"
_STEP = re.compile(r"\.(\w+)|\[([^\[\]]*)\]")
#: Index of the highest bit of a member that is declared only by its uses.
_TOP_BIT = 31
#: Largest index of an array that is declared only by its uses.
_TOP_INDEX = 9_999


@dataclass
class ModuleTags:
    """The tags of the modules of a file that its routines use.

    Attributes:
        tags: A Tag element for each tag.
        images: The names of inputs and outputs, in upper case. A connection overwrites them.
        aliases: The tags that are parts of the tag of a rack's adapter, with the part.
        guessed: The tags whose types come from their uses.
    """

    tags: list[Element] = field(default_factory=list)
    images: set[str] = field(default_factory=set)
    aliases: dict[str, str] = field(default_factory=dict)
    guessed: list[Element] = field(default_factory=list)


def module_tags(root: Element) -> ModuleTags:
    """Return the tags of modules that the routines and aliases of a file use."""
    found = ModuleTags()
    uses = _uses(root)
    modules = list(_modules(root))
    made = {one.get("Name").upper(): one for module in modules for one in _tags_of(module)}
    for module in modules:
        for key, target in _parts_of(module, made):
            if key in uses:
                found.aliases[key] = target
                uses.setdefault(target.partition(".")[0].upper(), _Use(module.at))
    for key, use in uses.items():
        if key in found.aliases:
            continue
        tag = made.get(key)
        if tag is None and use.name and (shape := use.shape()) is not None:
            tag = Element("Tag", {"Name": use.name}, use.at, [], use.at)
            tag.content.append(_value_element(shape, f"{use.name}_USED", use.at))
            tag.attributes["DataType"] = tag.children[0].children[0].get("DataType")
            found.guessed.append(tag)
        if tag is not None:
            image = not key.endswith(":C")
            # a connection to the module overwrites inputs and outputs, so they begin with 0
            found.tags.append(replace(tag, content=[]) if image else tag)
            if image:
                found.images.add(key)
    return found


# --- tags that a module describes -------------------------------------------------------------


def _modules(root: Element) -> Iterator[Element]:
    for owner in root.below("Modules"):
        yield from owner.all("Module")


def _place(module: Element) -> str:
    """Return the first part of the names of a module's tags."""
    for port in module.all("Ports", "Port"):
        kind, slot = port.get("Type").upper(), port.get("Address")
        if port.get("Upstream") == "true" and kind not in _NETWORKS and slot.isdigit():
            return f"{module.get('ParentModule')}:{slot}"
    return module.get("Name")


def _tags_of(module: Element) -> Iterator[Element]:
    place = _place(module)
    for one in module.all("Communications", "ConfigTag"):
        yield from _tag(f"{place}:C", one)
    seen: set[str] = set()
    for connection in module.all("Communications", "Connections", "Connection"):
        for kind, letter in (("Input", "I"), ("Output", "O")):
            suffix = connection.get(f"{kind}TagSuffix") or letter
            for one in connection.all(f"{kind}Tag"):
                if suffix not in seen:
                    yield from _tag(f"{place}:{suffix}", one)
                seen.add(suffix)


def _tag(name: str, owner: Element) -> Iterator[Element]:
    """Yield the tag of a connection, if its type is known."""
    value = value_of(owner)
    if value is None or not value.get("DataType"):
        return
    named = {
        "Name": name,
        "DataType": value.get("DataType"),
        "Dimensions": value.get("Dimensions"),
    }
    yield Element("Tag", named, owner.at, list(owner.content), owner.end)


def _parts_of(module: Element, tags: dict[str, Element]) -> Iterator[tuple[str, str]]:
    """Yield the tags that are a slot of the adapter's tag, for a module of a rack connection."""
    slot = _place(module).rpartition(":")[2]
    for kind, letter in (("In", "I"), ("Out", "O")):
        for _ in module.all("Communications", "RackConnection", f"{kind}AliasTag"):
            adapter = f"{module.get('ParentModule')}:{letter}"
            tag = tags.get(adapter.upper())
            value = value_of(tag) if tag is not None else None
            names = [one.get("Name") for one in value.children] if value is not None else []
            for member in ("Slot", "Data"):
                if slot.isdigit() and member in names:
                    yield f"{_place(module)}:{letter}".upper(), f"{adapter}.{member}[{slot}]"
                    break


# --- tags that only their uses describe -------------------------------------------------------


@dataclass
class _Use:
    """The uses of a tag, or of a member or element of it."""

    at: int
    name: str = ""
    whole: bool = False
    flag: bool = False
    bits: bool = False
    refused: bool = False
    number: str = ""
    size: int = 0
    members: dict[str, _Use] = field(default_factory=dict)
    element: _Use | None = None

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
            self.members.setdefault(member.upper(), _Use(self.at, member)).add(
                rest, flag=flag, number=number
            )
        elif index.strip().isdigit() and int(index.strip()[:9]) <= _TOP_INDEX:
            self.size = max(self.size, int(index) + 1)
            self.element = self.element or _Use(self.at)
            self.element.add(rest, flag=flag, number=number)
        else:
            self.refused = True

    def shape(self) -> str | _Use | None:
        """Return DINT or BOOL, or the use itself if it is a structure or an array.

        Return None if the uses do not show a type: nothing tells the type of a whole number.
        """
        kinds = (self.bits, self.flag, bool(self.members), self.element is not None)
        if self.number and not self.refused and not any(kinds):
            return self.number  # an instruction tells the type of the number
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


def _uses(root: Element) -> dict[str, _Use]:
    found: dict[str, _Use] = {}
    for text, at, kind in _pieces(root):
        for one in _USED.finditer(text) if ":" in text else ():
            steps = _STEP.findall(one["rest"])
            use = found.setdefault(one["tag"].upper(), _Use(at, one["tag"]))
            if kind != _ALIAS:  # an alias shows no type; the uses of its name do
                flag = kind == "BOOL" or bool(one["bit"] and one["closed"])
                use.add(steps, flag=flag, number="" if kind == "BOOL" else kind)
    return found


def _pieces(root: Element) -> Iterator[tuple[str, int, str]]:
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

    kinds = {
        aoi.get("Name").upper(): _kinds_of(aoi) for aoi in root.below("AddOnInstructionDefinition")
    }
    for routine in root.below("Routine"):
        for part in routine.below("Text"):
            yield from ((plain(text), at, kind) for text, at, kind in _operands(part, kinds))
        for part in routine.below("Line", "IRef", "ORef", "ICon"):
            yield plain(part.get("Operand") or part.text()), part.at, ""
    for tag in root.below("Tag", "LocalTag"):
        if tag.get("AliasFor"):
            yield tag.get("AliasFor"), tag.at, _ALIAS


def _kinds_of(aoi: Element) -> list[str]:
    """Return the types of the required parameters that are numbers or BOOL; empty for others."""
    return [
        one.get("DataType").upper()
        if one.get("Usage") != "InOut" and one.get("DataType").upper() in ("BOOL", *NUMBERS)
        else ""
        for one in aoi.all("Parameters", "Parameter")
        if one.get("Required") == "true" and one.get("Name").upper() not in ENABLE
    ]


def _operands(part: Element, kinds: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, int, str]]:
    """Yield the operands of a rung; an operand of a bit instruction with the instruction."""
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


def _value_element(shape: str | _Use, name: str, at: int) -> Element:
    """Return decorated data from which a type can be derived."""
    return Element("Data", {"Format": "Decorated"}, at, [_value(shape, "", name, at)], at)


def _value(shape: str | _Use, member: str, name: str, at: int) -> Element:
    behind = "Member" if member else ""
    named = {"Name": member} if member else {}
    if isinstance(shape, str):
        return Element(f"DataValue{behind}", {**named, "DataType": shape}, at, [], at)
    if shape.element is not None:
        kind = shape.element.shape()
        attributes = {**named, "DataType": str(kind), "Dimensions": str(shape.size)}
        return Element(f"Array{behind}", attributes, at, [], at)
    content = [
        _value(inner, one.name, f"{name}_{one.name}", at)
        for one in shape.members.values()
        if (inner := one.shape()) is not None
    ]
    attributes = {**named, "DataType": name}
    return Element(f"Structure{behind}", attributes, at, list(content), at)
