"""The directly represented variables of a project and their addresses.

An array or structure with an address is listed element by element. Variables with an incomplete
address (`%I*`) get their addresses here. Variables of 48 bytes or more come first, because a
scanner fills them. Smaller variables follow in order of declaration. None of these addresses
overlaps a variable with an explicit address. VAR_CONFIG gives addresses to variables of instances.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import product
from typing import NamedTuple

from structured_text.language.configured import configured_paths
from structured_text.language.declare import Declarations
from structured_text.language.sizes import bits_of, places_of, size_of
from structured_text.language.tree import Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    Located,
    StructType,
    Type,
)

__all__ = ["located"]

_ADDRESS = re.compile(r"%([IQM])([XBWDL]?)(\d+)(?:\.(\d+))?", re.IGNORECASE)
_LETTERS = {0: "X", 1: "B", 2: "W", 4: "D", 8: "L"}
_WIDTHS = {letter: width for width, letter in _LETTERS.items()}
#: Types of a scalar in a located structure, in addition to integers and bit strings.
_LEAVES = ("BOOL", "REAL", "LREAL")
_WHOLE = re.compile(r"U?(SINT|INT|DINT|LINT)|BYTE|D?WORD|LWORD")
#: Least size of a robot's input or output area [bytes] (manual chapter 1, 4).
_AREA = 48


class _Open(NamedTuple):
    """A variable with an incomplete address."""

    area: str
    path: str
    type: Type


def located(instances: Mapping[str, BlockType], declarations: Declarations) -> tuple[Located, ...]:
    """Return the directly represented variables.

    The order is: variables of VAR_CONFIG, globals, variables of each program. Raise InputError if
    an entry of VAR_CONFIG is wrong.
    """
    found: list[Located] = []
    open_ones: list[_Open] = []

    def take(symbol: Symbol, path: str) -> None:
        if path in entries:
            return
        if symbol.address is not None:
            found.extend(_parts(symbol.address, path, symbol.type))
        elif symbol.area:
            open_ones.append(_Open(symbol.area, path, symbol.type))

    entries = configured_paths(instances, declarations)
    for path, (address, kind) in entries.items():
        found.extend(_parts(address, path, kind))
    for symbol in declarations.globals.values():
        take(symbol, symbol.name)
    named = {
        symbol.name: symbol.type
        for key, symbol in declarations.globals.items()
        if key in declarations.programs and isinstance(symbol.type, BlockType)
    }
    own = list(instances.values())
    others = {name: block for name, block in named.items() if block not in own}
    for instance, block in {**instances, **others}.items():
        for symbol, path in _symbols(instance, block, declarations):
            take(symbol, path)
    return (*found, *_placed(open_ones, found))


def _symbols(
    path: str, block: BlockType, declarations: Declarations
) -> Iterator[tuple[Symbol, str]]:
    """Yield the variables of a program, and of the blocks inside it, with their paths."""
    pou = declarations.pous.get(block.name.upper())
    if pou is None:
        return
    for symbol in pou.symbols.values():
        if "." in symbol.name:
            continue
        inner = f"{path}.{symbol.name}"
        yield symbol, inner
        if symbol.section == "VAR" and isinstance(symbol.type, BlockType):
            yield from _symbols(inner, symbol.type, declarations)


def _parts(address: str, path: str, kind: Type) -> Iterator[Located]:
    """Yield a located variable; for an array or structure, yield its elements or fields."""
    if isinstance(kind, ElementaryType):
        yield Located(address, path, kind)
        return
    parts = _ADDRESS.fullmatch(address)
    if parts is not None:
        width = max(_WIDTHS[(parts[2] or "X").upper()], 1)
        yield from _leaves(parts[1].upper(), int(parts[3]) * width, path, kind)


def _leaves(area: str, start: int, path: str, kind: Type) -> Iterator[Located]:
    """Yield the scalars of a located variable that begins at a byte.

    Types that cannot be sent over a network are left out.
    """
    if isinstance(kind, ArrayType):
        size = size_of(kind.element)
        ranges = [range(low, high + 1) for low, high in kind.bounds]
        for k, indices in enumerate(product(*ranges) if size else ()):
            place = f"{path}[{','.join(map(str, indices))}]"
            yield from _leaves(area, start + k * (size or 0), place, kind.element)
    elif isinstance(kind, StructType) and size_of(kind) is not None:
        each = zip(kind.fields, places_of(kind), bits_of(kind), strict=True)
        for (name, field), offset, bit in each:
            inner = f"{path}.{name}"
            if bit is not None:
                yield Located(f"%{area}X{start + offset}.{bit}", inner, field, start + offset)
                continue
            yield from _leaves(area, start + offset, inner, field)
    elif isinstance(kind, ElementaryType):
        if kind.name not in _LEAVES and not _WHOLE.fullmatch(kind.name):
            return
        width = 0 if kind.name == "BOOL" else size_of(kind) or 0
        index = f"{start}.0" if not width else str(start // width)
        yield Located(f"%{area}{_LETTERS[width]}{index}", path, kind, start)


def _placed(open_ones: list[_Open], found: list[Located]) -> Iterator[Located]:
    """Yield the variables with an incomplete address, in order, each at a free address."""
    taken = {(one.address[1].upper(), byte) for one in found for byte in _bytes_of(one)}
    large = [one for one in open_ones if (size_of(one.type) or 0) >= _AREA]
    small = [one for one in open_ones if one not in large]
    ends = dict.fromkeys("IQM", 0)
    for area, path, kind in (*large, *small):
        size = size_of(kind)
        if not size:
            continue
        step = 2 if size > 1 else 1
        start = -(-ends[area] // step) * step
        while any((area, start + byte) in taken for byte in range(size)):
            start += step
        ends[area] = start + size
        yield from _leaves(area, start, path, kind)


def _bytes_of(one: Located) -> range:
    """Return the byte numbers that a variable with an address occupies."""
    parts = _ADDRESS.fullmatch(one.address)
    if parts is None:
        return range(0)
    width = _WIDTHS[(parts[2] or "X").upper()]
    start = int(parts[3]) * max(width, 1) if one.start is None else one.start
    return range(start, start + max(width, 1))
