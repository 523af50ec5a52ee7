"""The initial values of tags, from the decorated values of an L5X."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping

from structured_text.projects.rockwell.data import NUMBERS, Data, Types
from structured_text.projects.rockwell.expression_reader import plain_tag
from structured_text.projects.rockwell.sheets.structures import STRUCTURES
from structured_text.projects.xml import Element

__all__ = ["ENABLE", "Values"]

#: Parameters that each Add-On Instruction has.
ENABLE = ("ENABLEIN", "ENABLEOUT")
_INTEGER = re.compile(r"-?[0-9]{1,20}|(?:2|8|16)#[0-9A-Fa-f]{1,64}")
_REAL = re.compile(r"[-+]?[0-9]{1,400}(?:\.[0-9]{0,400})?(?:[eE][-+]?[0-9]{1,3})?")
_REAL_MOST = 3.4028235e38
_WIDTHS = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64}
#: Matches a timer or counter of a rung with a number as its preset.
_PRESET = re.compile(
    r"\b(?:TON|TOF|RTO|CTU|CTD)\(\s*(?P<tag>[^\W\d]\w*)(?P<rest>[^,()]*),\s*(?P<preset>\d{1,10})\s*,",
    re.IGNORECASE,
)


class Values:
    """The reader of initial values.

    Args:
        types: The types of the project.
        parameters: The elements of the parameters of each Add-On Instruction.
        data: The function from a declaring element to its type.
        note: The function that takes a message about a value that is not read, and its element.
    """

    def __init__(
        self,
        types: Types,
        parameters: Mapping[str, Mapping[str, Element]],
        data: Callable[[Element], Data],
        note: Callable[[str, Element], None],
    ) -> None:
        self._types, self._parameters = types, parameters
        self._data, self._note = data, note
        self._presets: dict[int, str] = {}

    def know_presets(self, texts: Iterable[str], tags: Mapping[str, Element]) -> None:
        """Take the presets that rungs show as the values of tags that have no data.

        `tags` has the tags that the rungs can use, by their names in upper case. A tag with data
        has its own preset; a note names a rung that shows another one.
        """
        for found in (one for text in texts for one in _PRESET.finditer(text)):
            tag = tags.get(found["tag"].upper())
            preset = int(found["preset"])
            if tag is None or not preset:
                continue
            name = f"{found['tag']}{found['rest'].strip()}"
            own = self._preset_of(tag)
            if found["rest"].strip():
                if not (tag.all("Data") or tag.all("DefaultData")):
                    text = f"{name} has no data, so its preset is 0, and not {preset} as a rung"
                    self._note(f"{text} shows; export it with decorated data", tag)
            elif own is None:
                self._presets[id(tag)] = str(preset)
            elif own != preset:
                text = f"the preset of {name} is {own}, as its data say; a rung shows {preset}"
                self._note(text, tag)

    def _preset_of(self, tag: Element) -> int | None:
        """Return the preset in the decorated data of a timer or counter; None without data."""
        for form in (*tag.all("Data"), *tag.all("DefaultData")):
            for one in form.all("Structure", "DataValueMember"):
                if _key(one) == "PRE":
                    value = _number(one.get("Value"), Data("DINT"))
                    return None if value is None else int(value)
        return None

    def initial(self, tag: Element) -> str:
        """Return the initial value of a tag; empty if the whole value is 0."""
        data = self._data(tag)
        if tag.get("Usage").upper() == "INOUT":
            return ""
        if data.type.upper() in self._types.instructions:
            return "" if data.sizes else self._given(tag, data)
        if id(tag) in self._presets and not data.sizes:
            return f"(PRE := {self._presets[id(tag)]})"
        for form in (*tag.all("Data"), *tag.all("DefaultData")):
            if form.get("Format") == "String" and self._types.is_string(data):
                text = form.text()
                return text if text.startswith("'") and len(text) > 2 else ""
            if form.get("Format") == "Decorated":
                for value in form.children:
                    return self._value(value, data)
        return ""

    def _given(self, tag: Element, data: Data) -> str:
        """Return the values in an instance that differ from the defaults of its instruction."""
        parameters = self._parameters[data.type.upper()]
        parts = []
        for form in (*tag.all("Data"), *tag.all("DefaultData")):
            for one in form.all("Structure", "DataValueMember"):
                parameter = parameters.get(_key(one))
                if parameter is None or _key(one) in ENABLE:
                    continue
                kind = self._data(parameter)
                text = self._scalar(one, kind)
                if text != self.initial(parameter):
                    parts.append(f"{plain_tag(one.get('Name'))} := {text or self._zero(kind)}")
        return f"({', '.join(parts)})" if parts else ""

    def _value(self, value: Element, data: Data) -> str:
        if value.name in ("DataValue", "DataValueMember"):
            return self._scalar(value, data)
        if value.name in ("Array", "ArrayMember"):
            items = [self._item(one, data.element) for one in value.all("Element")]
            if not any(items):
                return ""
            zero = self._zero(data.element)
            return f"[{', '.join(item or zero for item in items)}]" if zero else ""
        if value.name in ("Structure", "StructureMember"):
            if self._types.is_string(data):
                return ""
            members = self._types.members.get(data.type.upper(), {})
            defaults = self._defaults(data)
            parts = []
            for one in value.children:
                if _key(one) in ENABLE and data.type.upper() in self._types.instructions:
                    continue
                member = members.get(_key(one))
                text = self._value(one, member) if member is not None else ""
                default = defaults.get(_key(one), "") if member is not None else ""
                if member is not None and default:
                    text = text or self._zero(member)
                if text != default:
                    parts.append(f"{plain_tag(one.get('Name'))} := {text}")
            return f"({', '.join(parts)})" if parts else ""
        return ""

    def _defaults(self, data: Data) -> Mapping[str, str]:
        """Return the values of an instruction's structure that its declaration gives."""
        key = data.type.upper()
        defined = key in self._types.instructions
        return STRUCTURES[key].defaults() if key in STRUCTURES and not defined else {}

    def _item(self, element: Element, data: Data) -> str:
        for one in element.children:
            return self._value(one, data)
        return self._scalar(element, data)

    def _zero(self, data: Data) -> str:
        if data.type == "BOOL":
            return "FALSE"
        if data.type in ("REAL", "LREAL"):
            return "0.0"
        if self._types.is_string(data):
            return "''"
        if data.type in NUMBERS:
            return "0"
        for name, member in self._types.members.get(data.type.upper(), {}).items():
            zero = "" if member.sizes else self._zero(member)
            if zero:
                return f"({plain_tag(name)} := {zero})"
        return ""

    def _scalar(self, element: Element, data: Data) -> str:
        text = element.get("Value")
        if data.type == "BOOL":
            return "TRUE" if text in ("1", "true") else ""
        if data.type not in NUMBERS:
            return ""
        value = _number(text, data)
        if value is None:
            self._note(f"the initial value {text!r:.60} of a {data.type} is not read", element)
            return ""
        if data.stored and value < 0:
            value += 256 if data.type == "SINT" else 65536
        return repr(value) if value else ""


def _number(text: str, data: Data) -> int | float | None:
    """Return the number in a text; None if it is malformed or out of the type's range."""
    plain = text.replace("_", "").strip()
    if data.type in ("REAL", "LREAL"):
        found = float(plain) if _REAL.fullmatch(plain) else math.inf
        most = _REAL_MOST if data.type == "REAL" else math.inf
        return found if abs(found) <= most and math.isfinite(found) else None
    if not _INTEGER.fullmatch(plain):
        return None
    base, mark, digits = plain.partition("#")
    if not mark:
        return int(base)
    try:
        value = int(digits, int(base))
    except ValueError:
        return None
    width = _WIDTHS.get(data.type, 0)
    if not width or value < 1 << (width - 1):
        return value
    # a binary, octal or hexadecimal value of a signed type is its bit pattern
    return value - (1 << width) if value < 1 << width else None


def _key(element: Element) -> str:
    return element.get("Name").upper()
