"""Generated code that adds the methods to the classes of blocks, and that starts a program."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from structured_text.engines.builtin.storage import is_scalar, slot_name, stored
from structured_text.language.objects import EXIT, INIT, START, Objects
from structured_text.language.project import Project
from structured_text.language.tree import Pou, Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    inside,
)

__all__ = ["attribute", "handed_back", "holds_pointers", "is_dynamic", "linking"]


def attribute(name: str) -> str:
    """Return the attribute for a method in the class of its block.

    A property `P` has the methods `P.GET` and `P.SET`.
    """
    return f"m_{slot_name(name)}"


def handed_back(method: Pou) -> list[Symbol]:
    """Return the variables that a method returns after its result.

    These are its outputs and then its scalar VAR_IN_OUT.
    """
    in_outs = [symbol for symbol in method.section("VAR_IN_OUT") if is_scalar(symbol.type)]
    return [*method.section("VAR_OUTPUT"), *in_outs]


def is_dynamic(objects: Objects, block: BlockType, project: Project) -> bool:
    """Return whether a call of a block may run the body of a derived block.

    This is the case if derived blocks exist and all have the same VAR_IN_OUT.
    """
    own = _in_outs(block)
    blocks = [project.blocks[key] for key in objects.derived(block.name.upper())]
    return bool(blocks) and all(_in_outs(one) == own for one in blocks)


def _in_outs(block: BlockType) -> list[str]:
    return [pin.name for pin in block.variables if pin.section == "VAR_IN_OUT"]


def linking(project: Project) -> list[str]:
    """Return the generated lines that follow the functions of the POUs.

    These lines make the methods attributes of the classes, and define `start`. The list is empty
    for a program without methods and without start actions.
    """
    objects, lines = project.objects, []
    for key in objects.blocks:
        for name, method in objects.all[key].items():
            if method.owner is not None:
                lines.append(f"b_{key}.{attribute(name)} = f_{slot_name(method.name)}")
        if key in objects.extended or objects.derived(key):
            lines.append(f"b_{key}.body = lambda s, *a: f_{key}(s, *a)")
    starts = _Starts(project)
    lines += starts.lines()
    if any(use.construct == "__NEW or __DELETE" for use in project.uses):
        lines += starts.heap_lines()
    return lines


class _Starts:
    """The writer of `start`, and of `start_X(s)` for each block that has start actions.

    `start` begins with the blocks among the globals. Then it assigns the initial values in the
    lists of globals and of the program instances. For each block, the instances inside the block
    start first. The start methods of the block run next, those of a base block before those of a
    derived block. The `INIT` methods run last, unless `INIT` needs arguments from a declaration.
    """

    def __init__(self, project: Project) -> None:
        self._project = project
        self._objects = project.objects
        self._needed: dict[str, bool] = {}

    def lines(self) -> list[str]:
        result: list[str] = []
        for key in self._objects.blocks:
            if self._is_needed(key):
                result += [f"def start_{key}(s):", *self._block(key)]
        roots = [
            f"    start_{block.name.upper()}(roots[{name!r}])"
            for name, block in self._project.instances.items()
            if self._is_needed(block.name.upper()) and not self._is_shared(block)
        ]
        shared = list(self._inside(self._project.global_symbols.values(), "g"))
        lists = [
            f"    f_{slot_name(pou.name)}(g)"
            for pou in self._project.pous.values()
            if START in pou.words
        ]
        if roots or shared or lists:
            result += ["def start(g, roots):", *shared, *lists, *roots]
        return result

    def heap_lines(self) -> Iterator[str]:
        """Yield the code that starts and ends blocks which `__NEW` has made.

        The exit method of a derived block runs before the exit method of its base block.
        """
        for key in self._objects.blocks:
            if self._is_needed(key):
                yield f"b_{key}.begin = start_{key}"
            chain = [key]
            while chain[-1] in self._objects.extended:
                chain.append(self._objects.extended[chain[-1]])
            names = [f"f_{one}_m_{EXIT.upper()}" for one in chain if self._ends(one)]
            if names:
                yield f"b_{key}.exits = ({', '.join(names)},)"

    def _ends(self, key: str) -> bool:
        return EXIT.upper() in self._objects.own.get(key, {})

    def _is_shared(self, block: BlockType) -> bool:
        """Return whether other POUs call a program by its name; the program is then a global."""
        symbol = self._project.global_symbols.get(block.name.upper())
        return symbol is not None and symbol.type is block

    def _block(self, key: str) -> Iterator[str]:
        objects = self._objects
        yield from self._inside(stored(self._project.pous[key].symbols.values()), "s")
        chain = [key]
        while chain[-1] in objects.extended:
            chain.append(objects.extended[chain[-1]])
        for block in reversed(chain):
            if START.upper() in objects.own[block]:
                yield f"    f_{block}_m_{START.upper()}(s)"
        yield "    pass"
        if objects.starter(key) is None:
            for method in objects.starters(key):
                arguments = ", False" * len(method.section("VAR_INPUT"))
                yield f"    f_{slot_name(method.name)}(s{arguments})"

    def _inside(self, symbols: Iterable[Symbol], holder: str) -> Iterator[str]:
        for symbol in symbols:
            slot = slot_name(symbol.name)
            yield from self._one(symbol.type, f"{holder}.{slot}", 1)

    def _one(self, kind: Type, code: str, depth: int) -> Iterator[str]:
        indent = "    " * depth
        if isinstance(kind, BlockType) and self._is_needed(kind.name.upper()):
            yield f"{indent}start_{kind.name.upper()}({code})"
        elif isinstance(kind, ArrayType):
            inner = list(self._one(kind.element, f"a{depth}", depth + 1))
            if inner:
                yield f"{indent}for a{depth} in {code}:"
                yield from inner
        elif isinstance(kind, StructType):
            for name, field in kind.fields:
                yield from self._one(field, f"{code}.{name.upper()}", depth)

    def _is_needed(self, key: str) -> bool:
        if key not in self._objects.own:
            return False
        if key not in self._needed:
            self._needed[key] = False
            chain = [key, *self._objects.closure(key)]
            own = any(
                name in self._objects.own[block]
                for block in chain
                for name in (START.upper(), INIT.upper())
            )
            symbols = stored(self._project.pous[key].symbols.values())
            self._needed[key] = own or bool(list(self._inside(symbols, "s")))
        return self._needed[key]


def holds_pointers(project: Project) -> bool:
    """Return whether any stored variable is a pointer, a reference or of an interface type."""
    symbols = [*project.global_symbols.values()]
    for pou in project.pous.values():
        symbols += stored(pou.symbols.values()) if pou.block is not None else []
    kinds = (one for symbol in symbols for one in inside(symbol.type))
    return any(isinstance(one, (ReferenceType, InterfaceType)) for one in kinds)
