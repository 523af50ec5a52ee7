"""Generated client programs of the library, as users write them; every pin is free.

Some use the library correctly, others do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rcx_tools.evidence.prove.library import Library
from structured_text.language.types import ElementaryType

__all__ = ["IMAGE_BYTES", "Client", "less"]

#: Bytes of RCX_IMAGE and of RCX_IMAGE_WORDS.
IMAGE_BYTES = 512


def less(block: int, pin: str) -> str:
    """Return the name of the variable for negative durations at a pin.

    A stimulus cannot set a TIME below zero. The client subtracts this variable from zero instead.
    """
    return f"Less{block}{pin}"


@dataclass(frozen=True)
class Client:
    """A program with some blocks between FB_ReadArea and FB_WriteArea.

    Each block is called early (`Call1`), late (`Late1`), twice or not at all. With `out_of_place`
    it is also called before FB_ReadArea (`Before1`) and after FB_WriteArea (`Behind1`). A scan may
    skip the areas (`SkipRead`, `SkipWrite`), or write them a second time with the same instance
    (`Again`) or with another one (`Other`).

    Attributes:
        blocks: Their types.
        steady: Blocks and areas are called exactly once in every scan.
        words: The process image is an array of words.
        functions: Functions that are called in every scan, with free inputs.
        out_of_place: The blocks are also called outside of the areas.
    """

    blocks: tuple[str, ...]
    steady: bool = False
    words: bool = False
    functions: tuple[str, ...] = ()
    out_of_place: bool = False

    @property
    def places(self) -> tuple[str, ...]:
        """Return the prefixes of the variables that select where a block is called."""
        return ("Call", "Late", *(("Before", "Behind") if self.out_of_place else ()))

    def source(self, library: Library) -> str:
        """Return the program as Structured Text."""
        more = "Words" if self.words else ""
        image = "RCX_IMAGE_WORDS" if self.words else "RCX_IMAGE"
        lines = [
            "(* All pins are free: they are set between the scans. *)",
            "PROGRAM Client",
            "  VAR",
            f"    InputArea, OutputArea : {image};",
            "    Connected, EmergencyStopOk, StopOk : BOOL;",
            "    Interval, Margin, LessInterval, LessMargin : TIME;",
            "    m, n : INT;",
            "    InSize, OutSize : INT := 48;",
            f"    ImageSize : INT := {IMAGE_BYTES};",
            "    Robot : RCX_REF;",
            f"    ReadArea : FB_ReadArea{more};",
            f"    WriteArea : FB_WriteArea{more};",
            *self._variables(library, more),
            "  END_VAR",
            "",
        ]
        read = (
            "ReadArea(Robot := Robot, Image := InputArea, m := m, Size := InSize,"
            " ImageSize := ImageSize, Connected := Connected);"
        )
        if self.out_of_place:
            lines += self._calls(library, "Before")
        lines.append(f"  {read}" if self.steady else f"  IF NOT SkipRead THEN {read} END_IF;")
        lines += self._functions(library)
        lines += self._calls(library, "Call")
        if not self.steady:
            lines += self._calls(library, "Late")
            lines += [
                "  IF NOT SkipWrite THEN",
                _written("WriteArea", ""),
                "  END_IF;",
                "  IF Again THEN",
                _written("WriteArea", "Again"),
                "  END_IF;",
                "  IF Other THEN",
                _written("OtherArea", "Again"),
                "  END_IF;",
            ]
            if self.out_of_place:
                lines += self._calls(library, "Behind")
        else:
            lines.append(_written("WriteArea", ""))
        return "\n".join([*lines, "END_PROGRAM", ""])

    def _variables(self, library: Library, more: str) -> Iterator[str]:
        for number, block in enumerate(self.blocks, 1):
            yield f"    B{number} : {block};"
            for pin in library.pou(block.upper()).section("VAR_IN_OUT"):
                if pin.name not in ("Robot", "Image"):
                    yield f"    B{number}{pin.name} : {pin.type.name};"
            for duration in _durations(library, block):
                yield f"    {less(number, duration)} : TIME;"
            if not self.steady:
                called = ", ".join(f"{place}{number}" for place in self.places)
                yield f"    {called} : BOOL;"
        for number, name in enumerate(self.functions, 1):
            yield f"    F{number} : {_result(library, name)};"
            for symbol in library.pou(name.upper()).section("VAR_INPUT"):
                yield f"    F{number}{symbol.name} : {symbol.type.name};"
        if not self.steady:
            yield f"    OtherArea : FB_WriteArea{more};"
            yield "    SkipRead, SkipWrite, Again, Other : BOOL;"
            yield "    AgainEmergencyStopOk, AgainStopOk : BOOL;"

    def _calls(self, library: Library, when: str) -> Iterator[str]:
        for number, block in enumerate(self.blocks, 1):
            area = "OutputArea" if block.startswith("FB_Write") else "InputArea"
            names = (one.name for one in library.pou(block.upper()).section("VAR_IN_OUT"))
            known = {"Robot": "Robot", "Image": area}
            arguments = (f"{name} := {known.get(name, f'B{number}{name}')}" for name in names)
            if when == "Call":
                for pin in _durations(library, block):
                    taken = less(number, pin)
                    yield (f"  IF {taken} > T#0s THEN B{number}.{pin} := T#0s - {taken}; END_IF;")
            call = f"B{number}({', '.join(arguments)});"
            yield f"  {call}" if self.steady else f"  IF {when}{number} THEN {call} END_IF;"

    def _functions(self, library: Library) -> Iterator[str]:
        for number, name in enumerate(self.functions, 1):
            pins = (one.name for one in library.pou(name.upper()).section("VAR_INPUT"))
            yield f"  F{number} := {name}({', '.join(f'{p} := F{number}{p}' for p in pins)});"


def _written(instance: str, other: str) -> str:
    return (
        f"    {instance}(Robot := Robot, Image := OutputArea, n := n, Size := OutSize,"
        f" ImageSize := ImageSize,\n"
        f"      EmergencyStopOk := {other}EmergencyStopOk, StopOk := {other}StopOk,\n"
        "      Interval := Interval - LessInterval, Margin := Margin - LessMargin);"
    )


def _durations(library: Library, block: str) -> list[str]:
    pins = library.pou(block.upper()).section("VAR_INPUT")
    return [pin.name for pin in pins if pin.type == ElementaryType("TIME")]


def _result(library: Library, name: str) -> str:
    result = library.pou(name.upper()).result
    kind = result.type if result is not None else None
    return str(getattr(kind, "name", kind))
