"""Generator of the statements that pack the pins of a block into its telegram."""

from __future__ import annotations

from rcx_harness.spec.telegram import WORDS, Field
from rcx_tools.library.checks import selector_groups
from rcx_tools.library.conditions import Conditions
from rcx_tools.library.st import case, guarded, indent, loop, real, statement, word
from rcx_tools.library.tables import Block, Input, Library

__all__ = ["packing"]

#: If a block has at least this number of words to clear, a loop clears them.
_MANY = 5


def packing(block: Block, tables: Library) -> list[str]:
    """Return the statements that fill Data. Words and fields without a pin stay 0."""
    conditions = Conditions(block, tables.enumerations)
    steps: list[tuple[str, list[str]]] = []
    for pin in block.inputs:
        for condition, lines in _pin(conditions, block, tables, pin):
            if steps and steps[-1][0] == condition and condition:
                steps[-1][1].extend(lines)
            else:
                steps.append((condition, lines))
    body = [line for condition, lines in steps for line in guarded(condition, lines, 3)]
    return [*_clear(block, body), *body]


def _clear(block: Block, body: list[str]) -> list[str]:
    """Return the statements that prepare the words for the pins: 0 or fixed values."""
    # A word needs no preparation if an unconditional statement assigns it. Such a statement is not
    # indented, and it does not contain OR, which would read the word. All other used words are
    # cleared first, in a loop if there are many.
    text = "\n".join(body)
    base = [0] * WORDS
    for part in block.requests.values():
        if part.fixed:
            base[part.at // 2] |= part.fixed << part.bits[0]
    sure = {
        line.split(" :=")[0] for line in body if line.startswith("Data[") and " OR " not in line
    }
    filled = [part for name, part in block.requests.items() if name not in block.zero]
    used = {k for part in filled for k in part.words}
    used = {k for k in used if f"Data[{k}]" not in sure or base[k]}
    if "Data[k" in text or len(used) >= _MANY:
        lines = loop(WORDS - 1, [f"Data[k] := {word(0)};"])
        return lines + [f"Data[{k}] := {word(base[k])};" for k in sorted(used) if base[k]]
    return [f"Data[{k}] := {word(base[k])};" for k in sorted(used)]


def _pin(
    conditions: Conditions, block: Block, tables: Library, pin: Input
) -> list[tuple[str, list[str]]]:
    """Return the condition and the statements of one pin."""
    if len(pin.to) > 1:
        members = tables.enumerations[pin.type].members[1:]
        flags = [block.requests[name] for name in pin.to]
        rows = [(one.name, _or(flag, 1)) for one, flag in zip(members, flags, strict=True)]
        return [(conditions.counts(pin), case(pin.pin, rows))]
    part = block.requests[pin.to[0]]
    condition = conditions.matters(pin, part)
    if pin.flag and block.requests[pin.flag].fixed is None:
        lines = [_or(block.requests[pin.flag], 1), *_store(conditions, tables, pin, part)]
    elif pin.scale_by:
        lines = []
        for values, _, scale in selector_groups(pin, part):
            chosen = conditions.among(part.by, values)
            begin = "ELSIF" if lines else "IF"
            lines += statement(f"{begin} {chosen} THEN", 3)
            lines += indent(_scalar(pin.type, pin.pin, pin, part, scale))
        return [(conditions.counts(pin), [*lines, "END_IF;"])]
    else:
        lines = _store(conditions, tables, pin, part)
    if pin.encoding == "bit" and _may_be_zero(pin, part):
        lines = guarded(f"{pin.pin} > 0", lines)
    return [(condition, lines)]


def _may_be_zero(pin: Input, part: Field) -> bool:
    if pin.range:
        return pin.range[0] == 0
    lows = [limits[0] for limits in part.ranges.values()] if part.by else []
    return not (part.range and part.range[0] > 0) or any(low == 0 for low in lows)


def _or(part: Field, value: int) -> str:
    """Return the statement that sets the bits of a value in a word."""
    k = part.at // 2
    if part.type != "bits":
        return f"Data[{k}] := {word(value)};"
    return f"Data[{k}] := Data[{k}] OR {word(value << part.bits[0])};"


def _store(conditions: Conditions, tables: Library, pin: Input, part: Field) -> list[str]:
    """Return the statements that put a pin into its field."""
    if pin.type in tables.enumerations:
        members = tables.enumerations[pin.type].members
        allowed = [
            one for one in members if one.value and (one.value in part.values or not part.values)
        ]
        rows = [(one.name, _or(part, one.value)) for one in allowed]
        others = [one for one in members if one not in allowed]
        refused = not any(conditions.accepted(pin, one) for one in others)
        why = "(* unreachable: other members are refused *)" if others and refused else ""
        return case(pin.pin, rows, why)
    if pin.type in tables.arrays:
        array = tables.arrays[pin.type]
        return loop(array.count, _scalar(array.of, f"{pin.pin}[k]", pin, part, pin.scale))
    if pin.type == "STRING":
        first = part.at // 2 - 1
        text = f"Data[k + {first}] := FC_RcxTextWord(Text := {pin.pin}, Number := k);"
        return loop(len(part.words), [text])
    return _scalar(pin.type, pin.pin, pin, part, pin.scale)


def _scalar(kind: str, name: str, pin: Input, part: Field, scale: float) -> list[str]:
    """Return the statements that write a number into a field, or into element k of the field."""
    k = part.at // 2
    if kind == "BOOL":
        return guarded(name, [_or(part, 1)])
    if part.type in ("s32", "u32"):
        return _long(kind, name, pin, part, scale)
    if kind == "REAL":
        value = f"FC_RcxLowWord(Value := {_scaled(name, scale)})"
    elif pin.encoding == "bit":
        value = f"SHL({word(1)}, {name} - 1)"
    elif pin.encoding == "bcd":
        value = f"INT_TO_WORD({name} + 6 * ({name} / 10))"
    elif kind == "DINT":
        value = f"FC_RcxLowWord(Value := {name})"
    else:
        value = name if kind == "WORD" else f"{kind}_TO_WORD({name})"
    if part.type != "bits":
        place = f"k + {k - 1}" if part.count > 1 else f"{k}"
        return [f"Data[{place}] := {value};"]
    low, high = part.bits
    if pin.signed:
        value = f"({value} AND {word((1 << (high - low + 1)) - 1)})"
    if low and value.startswith(f"SHL({word(1)}, "):
        value = f"SHL({word(1)}, {name} + {low - 1})"
    elif low:
        value = f"SHL({value.strip('()') if pin.signed else value}, {low})"
    if (low, high) == (0, 15):
        return [f"Data[{k}] := {value};"]
    return [f"Data[{k}] := Data[{k}] OR {value};"]


def _scaled(name: str, scale: float) -> str:
    """Return an expression for a REAL in the unit of its field."""
    return f"REAL_TO_DINT({name})" if scale == 1 else f"REAL_TO_DINT({name} * {real(scale)})"


def _long(kind: str, name: str, pin: Input, part: Field, scale: float) -> list[str]:
    """Return the statements that write a number into two words, the low word first."""
    if pin.encoding == "real":
        value = f"DWORD_TO_DINT(FC_RcxRealBits(Value := {name}))"
    elif kind == "REAL":
        value = _scaled(name, scale)
    else:
        value = name if kind == "DINT" else f"{kind}_TO_DINT({name})"
    k = part.at // 2
    low, high = (f"2 * k + {k - 2}", f"2 * k + {k - 1}") if part.count > 1 else (f"{k}", f"{k + 1}")
    return [
        f"Data[{low}] := FC_RcxLowWord(Value := {value});",
        f"Data[{high}] := FC_RcxHighWord(Value := {value});",
    ]
