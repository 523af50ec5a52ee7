"""A check of a program's own process image, read from its checked source.

A cell fills `InputArea` before each scan. If the program copies located variables into `InputArea`,
the cell fills these variables instead. A program that fills its image from other variables never
receives data of the robot, although it is legal Structured Text and breaks no rule of the manual.
Therefore such a program is reported.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, get_args

from rcx_harness.watch.calls_source import AREAS, CallFinding
from structured_text.language import cache
from structured_text.language import tree as t
from structured_text.language.checked import analysed
from structured_text.language.project import Project
from structured_text.language.syntax import Position
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.language.walk import nodes, statements

__all__ = ["ImageUse", "image_use", "reads_located"]

_HERE = Path(__file__)
_INPUT = "INPUTAREA"

#: A variable: its POU (empty for global variables), its name and its members; in upper case.
_Place = tuple[str, ...]


class ImageUse(NamedTuple):
    """The use of the process image by a program.

    Attributes:
        located: Whether FB_ReadArea reads from located variables. A cell then fills these, even if
            there is an `InputArea`.
        findings: A warning for each image that the program overwrites.
    """

    located: bool
    findings: tuple[CallFinding, ...]


class _Write(NamedTuple):
    """A statement that writes a variable, and the variables in its value."""

    file: str
    at: Position
    sources: tuple[_Place, ...]


def image_use(files: Sequence[Path], library: Sequence[Path] = ()) -> ImageUse:
    """Find the use of the process image by a program.

    If the files have errors, nothing is found.
    """
    every = (*files, *library)
    key = cache.sources_key((*files, _HERE, *library))
    return cache.made_of("image", key, every, lambda: _found(files, every))


def reads_located(project: Project) -> bool:
    """Return whether FB_ReadArea reads from located variables."""
    return _Images(project, {pou.file: Path(pou.file) for pou in project.pous.values()}).judge()[0]


def _found(files: Sequence[Path], every: Sequence[Path]) -> ImageUse:
    project, _ = analysed(every)
    if project is None:
        return ImageUse(False, ())
    return _Images(project, {str(file): file for file in files}).judge()


class _Images:
    """The process images of a program, with all writes to these images.

    Only the user's `files` are read, because no block of the library writes to the image from the
    robot.
    """

    def __init__(self, project: Project, files: dict[str, Path]) -> None:
        self._project, self._files = project, files
        self._globals = {id(symbol): key for key, symbol in project.global_symbols.items()}
        self._symbols: dict[_Place, t.Symbol] = {}
        self._images: dict[_Place, str] = {}
        self._writes: dict[_Place, list[_Write]] = defaultdict(list)
        self._feeds: dict[_Place, set[_Place]] = defaultdict(set)
        self._same: dict[_Place, set[_Place]] = defaultdict(set)
        for pou in project.pous.values():
            if pou.file in files:
                for one in (pou, *project.objects.all.get(pou.name.upper(), {}).values()):
                    self._read(one)

    def judge(self) -> ImageUse:
        """Find the faults of each process image that FB_ReadArea reads."""
        located, plain, found = False, False, []
        for image, name in self._all_images().items():
            writes = [one for place in self._alike(image) for one in self._written(place)]
            address = self._address(image)
            sources = [one for one in self._sources(image) if one != image[:2]] if writes else []
            of_scanner = any(self._address(one) for one in sources)
            of_cell = any(one[1] == _INPUT for one in sources)
            located = located or bool(address) or (of_scanner and not of_cell)
            plain = plain or of_cell or (name.upper() == _INPUT and not address and not of_scanner)
            if writes and (address or not (of_scanner or of_cell)):
                first = min(writes, key=lambda one: (one.file != writes[0].file, one.at))
                text = self._text(name, address, first)
                found.append(
                    CallFinding(self._files[first.file], first.at, text, False, "overwritten-image")
                )
        found.sort(key=lambda one: (str(one.file), one.at))
        return ImageUse(located and not plain, tuple(found))

    def _text(self, name: str, address: str, write: _Write) -> str:
        if address:
            return (
                f"{name} is at {address}, so the scanner fills it: this overwrites what the robot "
                "has sent; leave the assignment out"
            )
        large = [one for one in map(self._symbol, write.sources) if one and _is_large(one.type)]
        source = large[0] if large else None
        why = "rcx fills it before each scan, and " if name.upper() == _INPUT else ""
        if source is None:
            return (
                f"{name} is overwritten here: {why}FB_ReadArea no longer sees what the robot has "
                "sent; leave the assignment out"
            )
        return (
            f"{name} is overwritten here: {why}FB_ReadArea reads what is in {source.name}, which "
            f"nothing fills; give {source.name} an address, {source.name} AT %IB0 (%QB0 for what "
            "goes to the robot), or leave the copying out"
        )

    # --- reading the code ---

    def _read(self, pou: t.Pou) -> None:
        for statement in statements(pou.body):
            at = statement.at
            for node in nodes(statement, get_args(t.Statement)):
                if isinstance(node, t.Assign):
                    self._assign(node.target, node.value, at, pou)
                elif isinstance(node, t.CallBlock):
                    self._call(node, at, pou)
                elif isinstance(node, (t.CallFunction, t.CallMethod)):
                    given = [one for one in node.arguments if one is not None]
                    for _, variable in (*node.in_outs, *node.outputs):
                        self._assign(variable, tuple(given), at, pou)
                        self._feed(variable, tuple(one for _, one in node.in_outs), pou)

    def _call(self, node: t.CallBlock, at: Position, pou: t.Pou) -> None:
        block = node.block.name.upper()
        users = block in self._project.pous and self._project.pous[block].file in self._files
        for pin, value in node.inputs:
            self._feeds[block, pin.upper()].update(one[:2] for one in self._uses(value, pou))
        for pin, target in node.outputs:
            if (place := self._place(target, pou)) is not None:
                self._writes[place].append(_Write(pou.file, at, ()))
                self._feeds[place[:2]].add((block, pin.upper()))
        for pin, variable in node.in_outs:
            place = self._place(variable, pou)
            if place is None:
                continue
            if AREAS.get(block) == "read" and pin.upper() == "IMAGE":
                self._images.setdefault(place, _name(variable))
            if users:
                inner = (block, pin.upper())
                self._same[place].add(inner)
                self._feeds[place[:2]].add(inner)
                self._feeds[inner].add(place[:2])

    def _assign(self, target: t.Variable, value: object, at: Position, pou: t.Pou) -> None:
        place = self._place(target, pou)
        if place is not None:
            uses = tuple(self._uses(value, pou))
            self._writes[place].append(_Write(pou.file, at, uses))
            self._feed(target, value, pou)
            if isinstance(value, t.Address) and (seen := self._place(value.variable, pou)):
                through = _through(place)
                self._same[seen].add(through)
                self._feeds[through[:2]].add(seen[:2])

    def _feed(self, target: t.Variable, value: object, pou: t.Pou) -> None:
        place = self._place(target, pou)
        if place is not None:
            self._feeds[place[:2]].update(one[:2] for one in self._uses(value, pou))

    def _uses(self, value: object, pou: t.Pou) -> Iterator[_Place]:
        """Yield the variables in an expression.

        A pin of an instance is named by the block's type.
        """
        for node in nodes(value):
            if isinstance(node, (t.Use, t.Member)) and (place := self._place(node, pou)):
                yield place

    def _place(self, variable: object, pou: t.Pou) -> _Place | None:
        if isinstance(variable, t.Use):
            return self._of_symbol(variable.symbol, pou)
        if isinstance(variable, t.Member):
            if isinstance(variable.base.type, BlockType):
                return variable.base.type.name.upper(), variable.name.upper()
            base = self._place(variable.base, pou)
            whole = not isinstance(variable.base, t.Index)
            return (*base, variable.name.upper()) if base and whole else base
        if isinstance(variable, t.Index):
            return self._place(variable.base, pou)
        if isinstance(variable, t.Deref):
            base = self._place(variable.base, pou)
            return _through(base) if base else None
        return None

    def _of_symbol(self, symbol: t.Symbol, pou: t.Pou) -> _Place:
        key, owner = symbol.name.upper(), pou
        if symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL"):
            place = ("", symbol.source.upper() or self._globals.get(id(symbol), key))
            self._symbols[place] = self._project.global_symbols.get(place[1], symbol)
            return place
        if pou.owner is not None and pou.owner.symbols.get(key) is symbol:
            owner = pou.owner
        self._symbols[owner.name.upper(), key] = symbol
        return owner.name.upper(), key

    # --- conclusions from the writes ---

    def _all_images(self) -> dict[_Place, str]:
        """Return the process images with their names; arguments replace each VAR_IN_OUT."""
        found: dict[_Place, str] = {}
        for image, name in self._images.items():
            symbol = self._symbol(image)
            if symbol is None or symbol.section != "VAR_IN_OUT":
                found[image] = name
                continue
            for outer in list(self._same):
                if image in self._alike(outer):
                    own = self._symbol(outer)
                    if own is not None and own.section != "VAR_IN_OUT":
                        found[outer] = outer[-1] if len(outer) > 2 else own.name
        return found

    def _alike(self, image: _Place) -> list[_Place]:
        """Return a process image, the pins to which it is passed, and the pointers to it."""
        found, waiting = [image], [image]
        while waiting:
            for one in sorted(self._same.get(waiting.pop(), ())):
                if one not in found:
                    found.append(one)
                    waiting.append(one)
        return found

    def _written(self, image: _Place) -> Iterator[_Write]:
        """Yield the writes to a process image, to a part of it, or to a variable around it."""
        for place, writes in self._writes.items():
            shorter = min(len(place), len(image))
            if place[:shorter] == image[:shorter]:
                yield from writes

    def _sources(self, image: _Place) -> Iterator[_Place]:
        """Yield the variables whose values reach a process image, also through other variables."""
        seen, waiting = {image[:2]}, [one[:2] for one in self._alike(image)]
        while waiting:
            for one in sorted(self._feeds.get(waiting.pop(), ())):
                if one not in seen:
                    seen.add(one)
                    waiting.append(one)
                    yield one

    def _address(self, place: _Place) -> str:
        """Return the address of an input; empty if it has none."""
        symbol = self._symbol(place)
        if symbol is None:
            return ""
        address = symbol.address or (f"%{symbol.area}*" if symbol.area else "")
        return address if address[1:2].upper() in ("I", "M") else ""

    def _symbol(self, place: _Place) -> t.Symbol | None:
        """Return the declared variable at a path; None for the target of a pointer."""
        pou = self._project.pous.get(place[0])
        return self._symbols.get(place[:2]) or (pou.symbols.get(place[1]) if pou else None)


def _is_large(kind: Type) -> bool:
    return isinstance(kind, (ArrayType, StructType, BlockType))


def _through(pointer: _Place) -> _Place:
    """Return a name such as `P^` for the unknown target of a pointer."""
    return (*pointer[:-1], f"{pointer[-1]}^")


def _name(variable: t.Expression) -> str:
    if isinstance(variable, t.Use):
        return variable.symbol.name
    if isinstance(variable, t.Member):
        return variable.name
    return _name(variable.base) if isinstance(variable, (t.Index, t.Deref)) else "the image"
