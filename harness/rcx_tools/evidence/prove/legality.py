"""A formula about the words of a telegram that holds if spec/remote_commands.toml permits it.

This is an independent interpretation of the table. It shares no code with the modules that build
and judge telegrams.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import z3

from rcx_tools.evidence.results import ROOT
from structured_text.output.toml_files import load_toml

__all__ = ["CODE_BITS", "legal"]

#: Bits 11 to 0 of word n are the code, bits 15 to 12 the robot number.
CODE_BITS = 12
_ROBOTS = 4
#: Words n+2 to n+30.
_WORDS = 15
_WIDTH = {"u16": 16, "s16": 16, "u32": 32, "s32": 32, "text": 8}
#: Range of the characters that the guide permits, and characters that may fill the rest of a text.
_CHARACTERS, _FILLERS = [0x20, 0x7E], (0x20, 0x00)
_KEYS = {"name", "at", "type", "bits", "count", "length", "values", "range", "by", "ranges"}
_KEYS |= {"one_bit", "unit", "meaning"}

Field = Mapping[str, Any]
Words = Sequence[Any]


@cache
def _commands() -> Mapping[int, tuple[Mapping[str, Any], tuple[Field, ...]]]:
    """Map each command code to its table, and to the fields of its request with group fields."""
    table = load_toml(ROOT / "spec/remote_commands.toml")
    groups = {group["name"]: group.get("request", []) for group in table["group"]}
    found = {}
    for command in table["command"]:
        lists = [groups[name] for name in command.get("groups", ())]
        fields = tuple(field for each in (*lists, command.get("request", [])) for field in each)
        for field in fields:
            if set(field) - _KEYS or field.get("type", "u16") not in _WIDTH:
                raise ValueError(f"{command['name']}: {field['name']} is not understood: {field}")
        found[command["code"]] = (command, fields)
    return found


def legal(code: Any, words: Words, codes: Sequence[int]) -> Any:
    """Return the claim that the telegram is a legal telegram of one of these commands.

    Args:
        code: Word n with the robot number.
        words: Words n+2 to n+30.
        codes: Codes of the possible commands.
    """
    return z3.Or([_legal(code, words, one) for one in codes])


def _legal(code: Any, words: Words, wanted: int) -> Any:
    command, fields = _commands()[wanted]
    robots = z3.Extract(15, CODE_BITS, code)
    by_name = {field["name"]: field for field in fields}
    rules = [z3.Extract(CODE_BITS - 1, 0, code) == wanted]
    rules.append(z3.ULE(robots, _ROBOTS) if command["robot"] else robots == 0)
    rules += [words[number] & mask == 0 for number, mask in enumerate(_free(fields)) if mask]
    for field in fields:
        if "by" not in field:
            rules.append(_holds(field, field.get("range"), words))
            continue
        (chosen,) = _values(by_name[field["by"]], words)
        for value, limits in field["ranges"].items():
            rules.append(z3.Implies(chosen == int(value, 0), _holds(field, limits, words)))
    for names in command.get("exclusive", ()):
        rules.append(z3.Not(z3.And([_values(by_name[name], words)[0] != 0 for name in names])))
    if "product" in command:
        limits = command["product"]["range"]
        rules += _product([by_name[name] for name in command["product"]["fields"]], limits, words)
    return z3.And(rules)


def _free(fields: Sequence[Field]) -> list[int]:
    """Return the bits of each word that do not belong to a field."""
    free = [0xFFFF] * _WORDS
    for field in fields:
        first = field["at"] // 2 - 1
        if "bits" in field:
            low, high = field["bits"]
            free[first] &= ~((1 << high + 1) - (1 << low))
        else:
            size = _WIDTH[field["type"]] * field.get("count", field.get("length", 1))
            for number in range(first, first + size // 16):
                free[number] = 0
    return free


def _values(field: Field, words: Words) -> list[Any]:
    """Return the values of a field as a list. Its length is the field's count."""
    first = field["at"] // 2 - 1
    if "bits" in field:
        low, high = field["bits"]
        return [z3.Extract(high, low, words[first])]
    if field["type"] == "text":
        places = range(field["length"])
        return [z3.Extract(i % 2 * 8 + 7, i % 2 * 8, words[first + i // 2]) for i in places]
    if _WIDTH[field["type"]] == 16:
        return [words[first + k] for k in range(field.get("count", 1))]
    starts = (first + 2 * k for k in range(field.get("count", 1)))
    return [z3.Concat(words[start + 1], words[start]) for start in starts]


def _holds(field: Field, limits: list[int] | None, words: Words) -> Any:
    """Return the claim that each value of a field is legal."""
    values = _values(field, words)
    if field.get("type") == "text":
        return _text(values, limits or _CHARACTERS)
    rules = []
    signed = field.get("type", "u").startswith("s")
    for value in values:
        if "values" in field:
            rules.append(z3.Or([value == int(one, 0) for one in field["values"]]))
        if limits:
            rules.append(z3.Or([_between(value, *pair, signed=signed) for pair in _pairs(limits)]))
        if field.get("one_bit"):
            rules.append(value & value - 1 == 0)
    return z3.And(rules)


def _pairs(limits: list[int]) -> Iterator[tuple[int, int]]:
    return zip(limits[::2], limits[1::2], strict=True)


def _between(value: Any, low: int, high: int, *, signed: bool) -> Any:
    if signed:
        return z3.And(value >= low, value <= high)
    return z3.And(z3.UGE(value, low), z3.ULE(value, high))


def _text(characters: Sequence[Any], limits: list[int]) -> Any:
    """Return the claim that a text has legal characters, then the same filler up to its end."""
    either = []
    for filler in _FILLERS:
        rules, rest = [], z3.BoolVal(True)
        for character in reversed(characters):
            rest = z3.And(character == filler, rest)
            good = [_between(character, *pair, signed=False) for pair in _pairs(limits)]
            rules.append(z3.Or(*good, rest))
        either.append(z3.And(rules))
    return z3.Or(either)


def _product(fields: Sequence[Field], limits: list[int], words: Words) -> list[Any]:
    """Return the claims that the product of these 16-bit fields stays within its limits.

    No factor is 0, so no partial product exceeds the limit. Factors are at most 32767, so signed
    and unsigned products are equal. The signed form gives the solver the same products as in the
    blocks.
    """
    low, high = limits
    if not all(1 <= one["range"][0] <= one["range"][1] <= 0x7FFF for one in fields):
        raise ValueError(f"a product of other numbers than 1 to 32767: {fields}")
    first, *others = (z3.SignExt(16, _values(field, words)[0]) for field in fields)
    products = [first]
    for factor in others:
        products.append(products[-1] * factor)
    return [*(_between(one, low, high, signed=True) for one in products)]
