"""From L5X back to Structured Text: its instructions as blocks, with what Logix means by them.

A witness of `l5x`, not an importer: it knows what that writes, refuses everything else, and takes
each statement as Rockwell's manuals say that a controller takes it. A SINT is a BYTE here and an
INT a WORD, read and written as the signed numbers that they are, so that a cell can drive them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from l5x_reader_body import (
    Scope,
    iec_statements,
    iec_type,
    single,
)
from l5x_structure import faults
from structured_text.errors import InputError
from structured_text.export.l5x.blocks import FBD_TIMER
from structured_text.export.l5x.model import Data
from structured_text.export.output import Output

__all__ = ["read_l5x"]

_SECTIONS = {"Input": "VAR_INPUT", "Output": "VAR_OUTPUT", "InOut": "VAR_IN_OUT"}
_PRESCANNED = "Rcx_Prescanned"

#: The instruction TONR: ACC counts whole milliseconds while TimerEnable is set.
_TONR = """\
FUNCTION_BLOCK RCX_TONR
  VAR_INPUT
    TimerEnable, Reset : BOOL;
    PRE : DINT;
  END_VAR
  VAR_OUTPUT
    Runs, TT, DN : BOOL;
    ACC : DINT;
  END_VAR
  VAR
    Clock : TON;
    Rest : TIME;
  END_VAR
  Clock(IN := TRUE, PT := T#100s);
  Rest := Rest + Clock.ET;
  Clock(IN := FALSE, PT := T#100s);
  Clock(IN := TRUE, PT := T#100s);
  IF NOT Runs THEN
    Rest := T#0s;
  END_IF;
  Runs := TimerEnable AND NOT Reset;
  IF NOT Runs THEN
    ACC := 0;
  END_IF;
  WHILE Rest >= T#1s DO
    Rest := Rest - T#1s;
    IF Runs AND NOT DN THEN
      ACC := ACC + 1000;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#10ms DO
    Rest := Rest - T#10ms;
    IF Runs AND NOT DN THEN
      ACC := ACC + 10;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#1ms DO
    Rest := Rest - T#1ms;
    IF Runs AND NOT DN THEN
      ACC := ACC + 1;
    END_IF;
  END_WHILE;
  DN := Runs AND ACC >= PRE;
  TT := Runs AND NOT DN;
END_FUNCTION_BLOCK
"""


def read_l5x(file: Path) -> Output:
    """Read the structures, the instructions and the program of a file.

    Args:
        file: An L5X as `l5x` writes it.

    Returns:
        One ST file with all of them; a CONFIGURATION is not among them.

    Raises:
        InputError: the file cannot be read, is not as it must be, or has something that this
            reader does not know.
    """
    try:
        root = ET.fromstring(file.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", file=file) from None
    except ET.ParseError as error:
        line, column = error.position
        raise InputError("is no well-formed XML", file=file, line=line, column=column) from None
    for fault in faults(root):
        raise InputError(fault, file=file)
    try:
        return Output({"": _Reader(root).text()})
    except InputError as error:
        raise InputError(error.message, file=file, hint=error.hint) from None


class _Reader:
    def __init__(self, root: ET.Element) -> None:
        self._root = root
        self._aois = {one.get("Name", ""): one for one in root.iter("AddOnInstructionDefinition")}
        self._arrays: dict[str, Data] = {}
        self._members = {
            "FBD_TIMER": {name.upper(): Data(kind) for name, kind in FBD_TIMER.items()},
            "STRING": {"LEN": Data("DINT")},
        }
        for kind in root.iter("DataType"):
            fields = [one for one in kind.iter("Member") if one.get("Hidden") != "true"]
            self._members[kind.get("Name", "")] = {_key(one): self._data(one) for one in fields}
        for name, aoi in self._aois.items():
            own = [one for one in aoi.iter("Parameter") if one.get("Usage") != "InOut"]
            self._members[name] = {_key(one): self._data(one) for one in own}
        self._calls = {
            name: tuple(
                one.get("Name", "") for one in aoi.iter("Parameter") if one.get("Usage") == "InOut"
            )
            for name, aoi in self._aois.items()
        }

    def text(self) -> str:
        parts = [_TONR]
        for kind in self._root.iter("DataType"):
            parts.append("\n".join(self._structure(kind)))
        for aoi in self._aois.values():
            parts.append("\n".join(self._pou(aoi, "FUNCTION_BLOCK")))
        for program in self._root.iter("Program"):
            parts.append("\n".join(self._pou(program, "PROGRAM")))
        for name, data in self._arrays.items():
            element = iec_type(Data(data.type))
            parts.append(f"TYPE\n  {name} : ARRAY [0..{data.size - 1}] OF {element};\nEND_TYPE")
        return "\n".join(parts) + "\n"

    def _data(self, element: ET.Element) -> Data:
        kind = element.get("DataType", "")
        size = int(element.get("Dimensions", element.get("Dimension", "0")))
        data = Data({"BIT": "BOOL"}.get(kind, kind), size)
        if size:
            self._arrays[iec_type(data)] = data
        return data

    def _structure(self, kind: ET.Element) -> Iterator[str]:
        yield f"TYPE\n  {kind.get('Name')} : STRUCT"
        for one in kind.iter("Member"):
            if one.get("Hidden") != "true":
                yield f"    {one.get('Name')} : {iec_type(self._data(one))};"
        yield "  END_STRUCT;\nEND_TYPE"

    def _pou(self, element: ET.Element, kind: str) -> Iterator[str]:
        name = element.get("Name", "")
        yield f"{kind} {name}"
        tags = {}
        for one in (
            *element.iter("Parameter"),
            *element.iter("LocalTag"),
            *element.iter("Tag"),
        ):
            tags[_key(one)] = self._data(one)
            if one.get("Name") not in ("EnableIn", "EnableOut"):
                section = _SECTIONS.get(one.get("Usage", ""), "VAR")
                yield f"  {section}\n    {self._declared(one)}\n  END_VAR"
        scope = Scope(name, tags, self._members, self._calls)
        routines = {
            one.get("Name"): iec_statements(_lines(one), scope) for one in element.iter("Routine")
        }
        if "Prescan" in routines:
            yield f"  VAR\n    {_PRESCANNED} : BOOL;\n  END_VAR\n  IF NOT {_PRESCANNED} THEN"
            yield from routines["Prescan"]
            yield f"    {_PRESCANNED} := TRUE;\n  END_IF;"
        yield from routines.get("Logic", routines.get("Main", []))
        yield f"END_{kind}"

    def _declared(self, one: ET.Element) -> str:
        data = self._data(one)
        value = one.find("*/DataValue")
        initial = "" if value is None else _initial(value.get("Value", "0"), data)
        for text in one.iterfind("*[@Format='String']"):
            initial = f" := {(text.text or '').strip()}"
        if data.type in self._aois:
            self._check_instance(one, data.type)
        return f"{one.get('Name')} : {iec_type(data)}{initial};"

    def _check_instance(self, one: ET.Element, name: str) -> None:
        """The values of an instruction inside another one must be those of its definition."""
        inside = {
            value.get("Name"): value.get("Value")
            for value in one.iterfind("*/Structure/DataValueMember")
        }
        wanted: dict[str | None, str | None] = {"EnableIn": "1", "EnableOut": "0"}
        for parameter in self._aois[name].iter("Parameter"):
            value = parameter.find("*/DataValue")
            if value is not None:
                wanted[parameter.get("Name")] = value.get("Value")
        if inside != wanted:
            raise InputError(f"{one.get('Name')} does not begin with the values of {name}")


def _key(element: ET.Element) -> str:
    return element.get("Name", "").upper()


def _lines(routine: ET.Element) -> str:
    return "\n".join((line.text or "").strip("\n") for line in routine.iter("Line"))


def _initial(value: str, data: Data) -> str:
    if data.type == "REAL":
        value = single(value)
    if data.type == "BOOL":
        value = "TRUE" if value == "1" else "FALSE"
    return f" := {value}"
