"""The entries of VAR_CONFIG: addresses of variables inside the instances of a program.

An entry names the whole path, `Main.Front.Ready AT %IX1.0 : BOOL`. The variable has no address of
its own, or an incomplete one (`%I*`) of the same area.

Source: IEC 61131-3, edition 3, 6.8.2; help of CODESYS, variable configuration.
"""

from __future__ import annotations

from collections.abc import Mapping

from structured_text.language import syntax as s
from structured_text.language.declare import Declarations
from structured_text.language.registry import Declared
from structured_text.language.types import ArrayType, BlockType, Type
from structured_text.language.values import describe

__all__ = ["configured_paths"]

_SPELLING = "name the program, then each instance up to the variable"


def configured_paths(
    instances: Mapping[str, BlockType], declarations: Declarations
) -> dict[str, tuple[str, Type]]:
    """Return address and type of each variable in VAR_CONFIG, by its path.

    Raises:
        InputError: The variable does not exist or has another type, or the address does not fit.
    """
    found: dict[str, tuple[str, Type]] = {}
    for entry, where in declarations.registry.entries:
        path, kind = _Entry(entry, where, instances, declarations).resolved()
        if path in found:
            raise where.error(f"{path} has two addresses in VAR_CONFIG", entry.at)
        found[path] = declarations.configured_address(entry, kind, where), kind
    return found


class _Entry:
    """Resolves the path of one entry of VAR_CONFIG."""

    def __init__(
        self,
        entry: s.ConfigEntry,
        where: Declared,
        instances: Mapping[str, BlockType],
        declarations: Declarations,
    ) -> None:
        self._entry, self._where = entry, where
        self._instances, self._declarations = instances, declarations

    def resolved(self) -> tuple[str, Type]:
        """Return path and type of the variable that the entry names, or raise InputError."""
        entry, where = self._entry, self._where
        if entry.initial is not None:
            hint = "write it at the variable, or at the instance"
            raise where.error("an initial value in VAR_CONFIG is not supported", entry.at, hint)
        if entry.address is None:
            raise where.error(
                "an entry of VAR_CONFIG needs an address", entry.at, "write AT %IX0.0"
            )
        steps = self._steps(entry.path)
        path, block = self._root(steps)
        kind: Type = block
        area, own = "", None
        for step in steps:
            path, kind, area, own = self._step(path, kind, step)
        wanted, _ = self._declarations.resolve(entry.spec, where)
        if wanted != kind:
            text = f"{path} is a {describe(kind)}, not a {describe(wanted)}"
            raise where.error(text, entry.spec.at)
        letter = entry.address.text[1:2].upper()
        if own is not None:
            hint = f"write AT %{letter}* there"
            raise where.error(f"{path} has the address {own} at its declaration", entry.at, hint)
        if area and area != letter:
            text = f"{path} is declared AT %{area}*, which {entry.address.text} does not fit"
            raise where.error(text, entry.address.at)
        return path, kind

    def _steps(self, node: s.Variable) -> list[s.Name | s.Index]:
        """Return the names of a path; an element of an array is an Index."""
        if isinstance(node, s.Name):
            return [node]
        if isinstance(node, s.Field):
            return [*self._steps(node.base), node.name]
        if isinstance(node, s.Index):
            return [*self._steps(node.base), node]
        raise self._where.error("VAR_CONFIG needs the path of a variable", node.at, _SPELLING)

    def _root(self, steps: list[s.Name | s.Index]) -> tuple[str, BlockType]:
        """Take the program instance from the beginning of the path.

        A RESOURCE or application before it is left out.
        """
        for skipped, step in enumerate(steps[:3]):
            key = step.key if isinstance(step, s.Name) else ""
            named = [one for one in self._instances.items() if one[0].upper() == key]
            named = named or [one for one in self._instances.items() if one[1].name.upper() == key]
            if len(named) == 1:
                del steps[: skipped + 1]
                return named[0]
        first = steps[0]
        shown = first.text if isinstance(first, s.Name) else "this"
        hint = f"the programs are {', '.join(self._instances)}"
        raise self._where.error(f"there is no program instance {shown}", first.at, hint)

    def _step(
        self, path: str, kind: Type, step: s.Name | s.Index
    ) -> tuple[str, Type, str, str | None]:
        """Return path, type, area and address after one more step of the path."""
        if isinstance(step, s.Index):
            return self._element(path, kind, step)
        pou = None
        if isinstance(kind, BlockType):
            pou = self._declarations.pous.get(kind.name.upper())
        symbol = pou.symbols.get(step.key) if pou is not None else None
        if symbol is None or symbol.section not in ("VAR", "VAR_INPUT", "VAR_OUTPUT"):
            raise self._where.error(f"{path} has no variable {step.text}", step.at, _SPELLING)
        return f"{path}.{symbol.name}", symbol.type, symbol.area, symbol.address

    def _element(self, path: str, kind: Type, step: s.Index) -> tuple[str, Type, str, str | None]:
        if not isinstance(kind, ArrayType) or len(step.indices) != len(kind.bounds):
            raise self._where.error(f"{path} is a {describe(kind)}", step.at, _SPELLING)
        numbers = [self._declarations.integer(one, self._where) for one in step.indices]
        for number, (low, high) in zip(numbers, kind.bounds, strict=True):
            if not low <= number <= high:
                raise self._where.error(f"index {number} is outside {low}..{high}", step.at)
        return f"{path}[{','.join(map(str, numbers))}]", kind.element, "", None
