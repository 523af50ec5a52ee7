"""The operands of instructions for arrays: places in arrays, their elements, and CONTROL tags."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.projects.rockwell.copies import Place
from structured_text.projects.rockwell.data import INTEGERS, STORED, Data
from structured_text.projects.rockwell.expression_reader import bare
from structured_text.projects.rockwell.instructions import BLOCKS
from structured_text.projects.rockwell.ladder.call import Call

__all__ = ["array_of", "control_of", "element_for", "length_lines", "moved", "place_of"]
__all__ += ["whole_of", "words_of", "zero_of"]


def place_of(call: Call, number: int, *, written: bool = False) -> Place:
    """Return an array with the index at which it begins, or a tag."""
    text, data, first = call.operand(number).place(written=written)
    if not data.sizes and "," in text.rpartition("[")[2] and call.raw(2) != "1":
        text = "of a part of an array with several dimensions is not supported"
        raise call.error(f"{call.entry.name} {text}", "copy element by element")
    return Place(text, data, first)


def array_of(call: Call, number: int) -> Place:
    """Return an array of one dimension that the instruction changes."""
    place = place_of(call, number, written=True)
    if len(place.data.sizes) != 1:
        raise call.error(f"{call.raw(number)} is not an array with one dimension")
    return place


def words_of(call: Call, number: int) -> Place:
    """Return an array of DINT."""
    place = place_of(call, number, written=True)
    if place.data.type != "DINT" or len(place.data.sizes) != 1:
        raise call.error(f"{call.raw(number)} is not an array of DINT")
    return place


def whole_of(call: Call, number: int) -> str:
    """Return an operand that is a whole number."""
    text, kind = call.number(number)
    if kind not in INTEGERS:
        raise call.error(f"{call.raw(number)} is a {kind}, not a whole number")
    return bare(text)


def control_of(call: Call, number: int) -> str:
    """Return an operand that is a CONTROL."""
    text, data = call.tag(number)
    if data != Data("CONTROL") and (data.type.upper() != "CONTROL" or data.sizes):
        raise call.error(f"{call.raw(number)} is not a CONTROL")
    return text


def length_lines(call: Call, control: int, length: int) -> Iterator[str]:
    """Yield the statement for a length in the rung, which is that of a tag without data."""
    if call.raw(length).isdigit() and int(call.raw(length)):
        tag = control_of(call, control)
        yield f"{tag}.LEN := SEL({tag}.LEN = 0, {tag}.LEN, {int(call.raw(length))});"


def element_for(call: Call, number: int, element: Data) -> str:
    """Return the value of an operand for an element of an array."""
    types = call.body.routine.types
    if types.is_simple(element):
        value = call.operand(number).converted(call.number(number), element.type)
        return _stored(value, element)
    if call.raw(number) == "0":
        return zero_of(call, element)
    value, data = call.tag(number, written=False)
    if (data.type.upper(), data.sizes) != (element.type.upper(), ()):
        name = call.entry.name
        raise call.error(f"{name} of a {element.type} with a {data.type} is not supported")
    return value


def moved(call: Call, number: int, text: str, element: Data) -> str:
    """Return the assignment of an element to the tag in an operand."""
    reader = call.operand(number)
    target, data = reader.tag(written=True)
    if call.body.routine.types.is_simple(element):
        return reader.assigned((target, data), reader.read(text, element))
    if (data.type.upper(), data.sizes) != (element.type.upper(), ()):
        name = call.entry.name
        raise call.error(f"{name} of a {element.type} to a {data.type} is not supported")
    return f"{target} := {text};"


def zero_of(call: Call, data: Data) -> str:
    """Return 0, a text without characters, or a structure of which no statement sets a member."""
    types = call.body.routine.types
    if types.is_simple(data):
        zero = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0"}.get(data.type, "0")
        return _stored(zero, data)
    if types.is_string(data):
        return "''"
    if data.type.upper() not in types.members or data.type.upper() in (
        *types.instructions,
        *BLOCKS,
    ):
        raise call.error(f"{call.entry.name} of a {data.type} with 0 is not supported")
    return call.body.variable(f"Zero_{data.type}", data.type)


def _stored(value: str, data: Data) -> str:
    """Return a value as it is stored: an element of an array of INT is a WORD."""
    return f"{data.type}_TO_{STORED[data.type]}({bare(value)})" if data.stored else value
