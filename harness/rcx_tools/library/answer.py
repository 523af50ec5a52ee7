"""Generator of the statements that copy the words of a response to the outputs of a block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rcx_harness.spec.telegram import Field
from rcx_tools.library.st import WIDTH, case, guarded, loop, real, word
from rcx_tools.library.tables import Block, Enumeration, Library, Output, When

__all__ = ["answer"]

#: Greatest indentation of a statement that copies a response.
_DEEPEST = 10

_EMPTY = {"BOOL": "FALSE", "WORD": "WORD#16#0000", "REAL": "0.0", "STRING": "''"}


def answer(block: Block, tables: Library) -> list[str]:
    """Return the statements that clear the outputs of a block and fill them from the response."""
    if not block.outputs:
        return []
    lines = _cleared(block, tables)
    filled: list[str] = []
    done: set[str] = set()
    for pin in block.outputs:
        alike = [one for one in block.outputs if one.source == pin.source]
        if len(alike) > 1 and all(one.type in tables.arrays for one in alike):
            if pin.source not in done:
                filled += _shared_loop(block, tables, alike)
            done.add(pin.source)
            continue
        condition = _holds(block, pin.when) if pin.when else ""
        filled += guarded(condition, _take(block, tables, pin), 3)
    return guarded("Job.Ended", [*lines, *guarded("Job.Done", filled)])


def _cleared(block: Block, tables: Library) -> list[str]:
    """Return statements that clear the outputs to 0, or to the first member of an enumeration."""
    lines, loops = [], dict[int, list[str]]()
    for pin in block.outputs:
        array = tables.arrays.get(pin.type)
        kind = array.of if array else pin.type
        empty = _EMPTY.get(kind, "0")
        if kind in tables.enumerations:
            empty = tables.enumerations[kind].members[0].name
        if array:
            loops.setdefault(array.count, []).append(f"{pin.pin}[k] := {empty};")
        else:
            lines.append(f"{pin.pin} := {empty};")
    return lines + [line for count, body in loops.items() for line in loop(count, body)]


def _shared_loop(block: Block, tables: Library, pins: Sequence[Output]) -> list[str]:
    """Return a loop that fills several arrays from the same 32-bit fields.

    Every array is filled under a separate condition.
    """
    part = block.responses[pins[0].source]
    body: list[str] = []
    for pin in pins:
        array = tables.arrays[pin.type]
        take = _scalar(tables.enumerations, array.of, f"{pin.pin}[k]", pin, part)
        body += guarded(_holds(block, pin.when) if pin.when else "", take, 4)
    return loop(part.count, body)


def _holds(block: Block, when: When) -> str:
    """Return the condition that a field has a value.

    The field is part of the response. If it is not, the field of the request is used.
    """
    name, low, high = when
    if name in block.responses:
        part, source = block.responses[name], "Robot.Response"
    else:
        part, source = block.requests[name], "Data"
    k = part.at // 2
    if part.type == "bits" and low == high:
        return f"({source}[{k}] AND {word(part.mask)}) = {word(low << part.bits[0])}"
    number = f"WORD_TO_INT({source}[{k}])"
    return f"{number} = {low}" if low == high else f"{number} >= {low} AND {number} <= {high}"


def _take(block: Block, tables: Library, pin: Output) -> list[str]:
    part = block.responses[pin.source]
    if pin.type == "STRING":
        first = part.at // 2
        words = [f"Robot.Response[{first + k}]" for k in range(part.length // 2)]
        words += [word(0)] * (8 - len(words))
        inputs = [f"Word{k} := {text}" for k, text in enumerate(words, 1)]
        rows = [", ".join(inputs[k : k + 2]) for k in range(0, 8, 2)]
        return [f"{pin.pin} := FC_RcxText({rows[0]},", *(f"  {row}," for row in rows[1:3]),
                f"  {rows[3]});"]  # fmt: skip
    array = tables.arrays.get(pin.type)
    if array:
        return loop(array.count, _scalar(tables.enumerations, array.of, f"{pin.pin}[k]", pin, part))
    return _scalar(tables.enumerations, pin.type, pin.pin, pin, part)


def _scalar(
    enumerations: Mapping[str, Enumeration], kind: str, name: str, pin: Output, part: Field
) -> list[str]:
    k = part.at // 2
    many = part.count > 1
    if part.type in ("s32", "u32"):
        low, high = (f"2 * k + {k - 2}", f"2 * k + {k - 1}") if many else (f"{k}", f"{k + 1}")
        if kind in enumerations:
            return [
                *_double_word("Number := ", low, high, ";"),
                *_members(enumerations[kind], name, "Number"),
            ]
        if pin.encoding == "real":
            return [
                *_double_word("Number := ", low, high, ";"),
                f"{name} := FC_RcxBitsReal(Pattern := DINT_TO_DWORD(Number));",
            ]
        if kind == "REAL":
            behind = f") / {real(round(1 / pin.scale))};"
            return _double_word(f"{name} := DINT_TO_REAL(", low, high, behind)
        return _double_word(f"{name} := ", low, high, ";")
    place = f"k + {k - 1}" if many else f"{k}"
    source = f"Robot.Response[{place}]"
    if part.type == "bits" and part.bits != (0, 15):
        source = f"{source} AND {word(part.mask)}"
        if part.bits[0] and kind != "BOOL":
            source = f"SHR({source}, {part.bits[0]})"
    if kind == "BOOL":
        return [f"{name} := ({source}) <> {word(0)};"]
    if kind == "WORD":
        return [f"{name} := {source};"]
    if kind in enumerations:
        return _members(enumerations[kind], name, f"WORD_TO_INT({source})")
    if pin.encoding == "rotation":
        return [f"{name} := FC_RcxArmRotation(Bits := {source});"]
    lines = [f"{name} := WORD_TO_{kind}({source});"]
    if pin.encoding == "bcd":
        lines.append(f"{name} := {name} - 6 * ({name} / 16);")
    return lines


def _double_word(before: str, low: str, high: str, behind: str) -> list[str]:
    """Return a statement with the 32-bit number from two words of the response."""
    call = f"{before}FC_RcxDoubleWord("
    rest = f"HighWord := Robot.Response[{high}]){behind}"
    room = len(call) if len(call) + len(rest) + _DEEPEST <= WIDTH else 4
    return [f"{call}LowWord := Robot.Response[{low}],", f"{' ' * room}{rest}"]


def _members(enumeration: Enumeration, name: str, number: str) -> list[str]:
    """Return a CASE that assigns the member of an enumeration for a number.

    The first member is assigned before the CASE.
    """
    rows = [(f"{one.value}", f"{name} := {one.name};") for one in enumeration.members[1:]]
    return case(number, rows)
