"""Code for the data of a program: a class per structure and block, with copy, save and load.

Scalars are slots, arrays are flat lists in row-major order, structures and blocks are objects. An
object or list lives as long as its program instance. Assignment and `restore` fill it and never
replace it, so references to it remain valid.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from structured_text.engines.builtin.blocks import CLASSES
from structured_text.language.scalars import ANY_STRING, MOMENTS, SIGNED, WIDTH
from structured_text.language.sizes import bits_of, block_size, places_of, size_of
from structured_text.language.tree import Pou, Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.language.values import array_length, describe

__all__ = [
    "Storage",
    "address_slot",
    "in_cell",
    "is_scalar",
    "needs_globals",
    "slot_name",
    "stored",
]


def is_scalar(kind: Type) -> bool:
    """Return whether a value of the type is a single Python number, bool or str, or a pointer."""
    return isinstance(kind, (ElementaryType, EnumType, ReferenceType, InterfaceType))


def in_cell(symbol: Symbol) -> bool:
    """Return whether a local variable is held in a list of length 1.

    A pointer to a local scalar needs an object to refer to; the list is that object.
    """
    return symbol.addressed and is_scalar(symbol.type)


def slot_name(name: str) -> str:
    """Return the name of a variable or POU in the generated code.

    A method `Block.Method` becomes a single name without a dot.
    """
    return name.upper().replace(".", "_m_")


def stored(symbols: Iterable[Symbol]) -> list[Symbol]:
    """Return the variables of a block that are stored in its instances."""
    kept = ("VAR", "VAR_INPUT", "VAR_OUTPUT")
    return [item for item in symbols if item.section in kept and item.address is None]


def needs_globals(pou: Pou) -> bool:
    """Return whether a body reads the time, or uses global or located variables."""
    return pou.clock or any(
        item.section == "VAR_EXTERNAL" or item.address is not None for item in pou.symbols.values()
    )


def address_slot(address: str) -> str:
    """Return the slot of the globals for a located variable such as `%QX0.1`."""
    return "at_" + address[1:].replace(".", "_")


class Storage:
    """The writer of the data part of the generated module.

    For each type T that is neither a scalar nor a list of scalars, the module has `copy_T(to, by)`,
    `save_T(of)` and `load_T(to, saved)`. Structures and blocks also have a class, `s_T` or `b_T`.
    The code of a type is written when the type is first used, after the code of the types in it.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._names: dict[Type, str] = {}
        self._layouts: dict[str, str] = {}

    def layout(self, kind: Type) -> str:
        """Return the name that the layout of a type has in the generated code."""
        code = _layout_of(kind)
        if code not in self._layouts:
            self._layouts[code] = name = f"y{len(self._layouts)}"
            self.lines.append(f"{name} = {code}")
        return self._layouts[code]

    def create(self, kind: Type, initial: Any) -> str:
        """Return the Python code that makes a new variable with its initial value."""
        if isinstance(kind, BlockType):
            types = {pin.name: pin.type for pin in kind.variables}
            return self._started(types, f"b_{self._name(kind)}(g)", initial)
        if isinstance(kind, StructType) and kind.union:
            made = f"Union({self.layout(kind)})"
            return self._started(dict(kind.fields), made, initial)
        if isinstance(kind, StructType):
            values = ", ".join(self.create(field, initial[name]) for name, field in kind.fields)
            return f"s_{self._name(kind)}({values})"
        if isinstance(kind, ArrayType):
            return self._created(kind.element, initial)
        if isinstance(kind, ReferenceType):
            return "null"
        return "no_block" if isinstance(kind, InterfaceType) else repr(initial)

    def made(self, kind: Type, values: Sequence[str]) -> str:
        """Return code that makes a structure; `values` is the code of its fields."""
        return f"s_{self._name(kind)}({', '.join(values)})"

    def _created(self, kind: Type, initial: Sequence[Any]) -> str:
        """Return the code that makes the elements of an array.

        Equal elements are made by a loop.
        """
        first = initial[0]
        if not all(item is first for item in initial):
            items = [self.create(kind, item) for item in initial]
            if len(set(items)) > 1:
                return f"[{', '.join(items)}]"
        code = self.create(kind, first)
        if is_scalar(kind):
            return f"[{code}] * {len(initial)}"
        return f"[{code} for _ in range({len(initial)})]"

    def _started(self, types: Mapping[str, Type], made: str, initial: Any) -> str:
        """Return the code for a block or union with initial values for some of its variables."""
        if not initial:
            return made
        pairs = "".join(
            f"({name.upper()!r}, {self.create(types[name], value)}), "
            for name, value in initial.items()
        )
        return f"started({made}, ({pairs}))"

    def own(self, symbol: Symbol) -> str:
        """Return a statement by which a function replaces its argument by a copy."""
        name = symbol.name.upper()
        if _is_flat(symbol.type):
            return f"{name} = {name}[:]"
        made = self.create(symbol.type, symbol.initial)
        return f"{self.copy(symbol.type, f'(t_ := {made})', name)}; {name} = t_"

    def copy(self, kind: Type, to: str, by: str) -> str:
        """Return a statement that assigns the value of `by` to the variable `to`."""
        if is_scalar(kind):
            return f"{to} = {by}"
        if isinstance(kind, BlockType):
            name = self._name(kind)
            return f"load_{name}({to}, save_{name}({by}))"
        return f"{to}[:] = {by}" if _is_flat(kind) else f"copy_{self._name(kind)}({to}, {by})"

    def copied(self, kind: Type, to: str, by: str) -> str:
        """Return an expression that copies a structure or array, as `copy` does in a statement."""
        if _is_flat(kind):
            return f"{to}.__setitem__(slice(None), {by})"
        return f"copy_{self._name(kind)}({to}, {by})"

    def save(self, kind: Type, of: str) -> str:
        """Return an expression for a copy of the variable `of`."""
        if is_scalar(kind):
            return of
        return f"{of}[:]" if _is_flat(kind) else f"save_{self._name(kind)}({of})"

    def load(self, kind: Type, to: str, saved: str) -> str:
        """Return a statement that sets the variable `to` from the result of `save`."""
        if is_scalar(kind):
            return f"{to} = {saved}"
        return f"{to}[:] = {saved}" if _is_flat(kind) else f"load_{self._name(kind)}({to}, {saved})"

    def _name(self, kind: Type) -> str:
        if kind not in self._names:
            if isinstance(kind, ArrayType):
                self._array(kind)
            elif isinstance(kind, StructType):
                self._structure(kind)
            else:
                self._standard_block(kind)
        return self._names[kind]

    def _array(self, kind: ArrayType) -> None:
        copy = self.copy(kind.element, "a", "b")
        save, load = self.save(kind.element, "a"), self.load(kind.element, "a", "b")
        name = self._names[kind] = f"array{len(self._names)}"
        self.lines += [
            f"def copy_{name}(to, by):",
            f"    for a, b in zip(to, by): {copy}",
            f"def save_{name}(of): return [{save} for a in of]",
            f"def load_{name}(to, saved):",
            f"    for a, b in zip(to, saved): {load}",
        ]

    def _structure(self, kind: StructType) -> None:
        fields = [(name.upper(), field) for name, field in kind.fields]
        name = kind.name.upper()
        if kind.union:
            self._names[kind] = name
            layout = self.layout(kind)
            self.lines += [
                f"def copy_{name}(to, by): {layout}.write(to, 0, save_{name}(by))",
                f"def save_{name}(of): return {layout}.read(of, 0, {layout}.size)",
                f"def load_{name}(to, saved): {layout}.write(to, 0, saved)",
            ]
            return
        copies = [self.copy(field, f"to.{slot}", f"by.{slot}") for slot, field in fields]
        functions = self._save_and_load(name, fields)
        self._names[kind] = name
        self.lines += [
            f"class s_{name}:",
            f"    __slots__ = {tuple(slot for slot, _ in fields)!r}",
            f"    def __init__(self, {', '.join(slot for slot, _ in fields)}):",
            *(f"        self.{slot} = {slot}" for slot, _ in fields),
            f"def copy_{name}(to, by):",
            *(f"    {line}" for line in copies),
            *functions,
        ]

    def _save_and_load(self, name: str, slots: list[tuple[str, Type]]) -> list[str]:
        saves = "".join(f"{self.save(kind, f'of.{slot}')}, " for slot, kind in slots)
        targets: list[str] = []
        loads: list[str] = []
        for slot, kind in slots:
            if is_scalar(kind) or _is_flat(kind):
                targets.append(f"to.{slot}" if is_scalar(kind) else f"to.{slot}[:]")
            else:
                targets.append(f"v{len(loads)}")
                loads.append(self.load(kind, f"to.{slot}", targets[-1]))
        return [
            f"def save_{name}(of): return ({saves})",
            f"def load_{name}(to, saved):",
            f"    {', '.join(targets)}, = saved" if slots else "    pass",
            *(f"    {line}" for line in loads),
        ]

    def _standard_block(self, kind: Type) -> None:
        assert isinstance(kind, BlockType)
        slots = [slot for slot in CLASSES[kind.name].__slots__ if slot != "clock"]
        scalar = ElementaryType("LINT")
        self.lines += self._save_and_load(kind.name, [(slot, scalar) for slot in slots])
        self._names[kind] = kind.name

    def block(self, pou: Pou) -> None:
        """Write the class of a function block or program, after the classes of the blocks in it."""
        assert pou.block is not None
        name = pou.name.upper()
        symbols = stored(pou.symbols.values())
        creates = [(slot_name(item.name), self.create(item.type, item.initial)) for item in symbols]
        slots = [(slot_name(item.name), item.type) for item in symbols]
        functions = self._save_and_load(name, slots)
        self._names[pou.block] = name
        shared = [slot_name(one.name) for one in pou.section("VAR_IN_OUT") if one.shared]
        self.lines += [
            f"class b_{name}:",
            f"    __slots__ = {('g', *(slot for slot, _ in slots), *shared)!r}",
            "    def __init__(self, g):",
            "        self.g = g",
            *(f"        self.{slot} = uncalled" for slot in shared),
            *(f"        self.{slot} = {code}" for slot, code in creates),
            *functions,
        ]

    def globals(self, symbols: Iterable[Symbol]) -> None:
        """Write the class of a program's shared data: global and located variables, the time."""
        slots: dict[str, tuple[Type, str]] = {}
        for item in symbols:
            slot = item.name.upper() if item.address is None else address_slot(item.address)
            slots.setdefault(slot, (item.type, self.create(item.type, item.initial)))
        functions = self._save_and_load(
            "globals", [("now", ElementaryType("TIME")), *((k, v[0]) for k, v in slots.items())]
        )
        self.lines += [
            "class b_globals:",
            f"    __slots__ = {('now', 'heap', *slots)!r}",
            "    def __init__(self):",
            "        g = self",
            "        self.now = 0",
            "        self.heap = Heap()",
            *(f"        self.{slot} = {code}" for slot, (_, code) in slots.items()),
            *functions,
        ]


def _is_flat(kind: Type) -> bool:
    return isinstance(kind, ArrayType) and is_scalar(kind.element)


# --- layouts: the order and size of values in memory (see `byte_views`) ---

_CODES = {8: "B", 16: "H", 32: "I", 64: "Q"}
_REALS = {"REAL": "<f", "LREAL": "<d"}
#: Unit of a time or date in memory [ns]: milliseconds, or seconds if it has a date.
_UNITS = {"TIME": 1_000_000, "TOD": 1_000_000, "DATE": 1_000_000_000, "DT": 1_000_000_000}


def _layout_of(kind: Type) -> str:
    """Return the code that makes the layout of a type; the type must have a size (`size_of`)."""
    if size_of(kind) is None:
        return _opaque(kind)
    if isinstance(kind, EnumType):
        return _layout_of(ElementaryType(kind.base))
    if isinstance(kind, ElementaryType):
        return _scalar(kind)
    if isinstance(kind, ArrayType):
        return f"Row({_layout_of(kind.element)}, {array_length(kind)})"
    if isinstance(kind, StructType):
        each = zip(kind.fields, places_of(kind), bits_of(kind), strict=True)
        fields = "".join(
            f"({name.upper()!r}, {place}, {_layout_of(field) if bit is None else f'Bit({bit})'}), "
            for (name, field), place, bit in each
        )
        return f"Record(({fields}), {size_of(kind)}, {kind.union})"
    return "Pointer()"


def _opaque(kind: Type) -> str:
    slots: list[str] = []
    if isinstance(kind, BlockType):
        none = ("VAR_IN_OUT", "VAR_EXTERNAL")
        slots = [one.name.upper() for one in kind.variables if one.section not in none]
    elif isinstance(kind, StructType):
        slots = [name.upper() for name, _ in kind.fields]
    return f"Opaque({describe(kind)!r}, {block_size(kind) or 4}, {tuple(slots)!r})"


def _scalar(kind: ElementaryType) -> str:
    name, size = kind.name, size_of(kind)
    if name == "BOOL":
        return "Number('?', 1)"
    if name in ANY_STRING:
        return f"Text({size}, {1 if name == 'STRING' else 2})"
    if name in ("CHAR", "WCHAR"):
        return f"Character({size})"
    if name in MOMENTS:
        return f"Moment({_UNITS.get(name, 1)}, {size}, {name == 'LTIME'})"
    if name in _REALS:
        return f"Number({_REALS[name]!r}, {size})"
    code = _CODES[WIDTH[name]]
    return f"Number({'<' + (code.lower() if name in SIGNED else code)!r}, {size})"
