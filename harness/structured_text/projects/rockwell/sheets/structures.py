"""Structures of function block instructions in Structured Text.

A structure that only one instruction has, or that remembers something, is a function block; the
others are data, and the statements of a sheet calculate their results. Structures whose names and
members are listed here need no values in the file.

Source: Rockwell 1756-RM003N and 1756-RM006K, Studio 5000 help; from memory where a comment says
"assumed".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from structured_text.projects.rockwell.data import Data

__all__ = ["STRUCTURES", "Structure"]


@dataclass(frozen=True)
class Structure:
    """A structure.

    Attributes:
        inputs: The input parameters with their types and default values, `BOOL EnableIn TRUE`.
        outputs: The output parameters.
        body: The statements of the function block; empty for a structure of data.
        others: Sections of the function block besides its inputs and outputs.
        disabled: What the function block does while EnableIn is FALSE, besides its EnableOut.
        kept: Whether the outputs keep their values when the controller starts.
    """

    inputs: str
    outputs: str
    body: str = ""
    others: str = ""
    disabled: str = ""
    kept: bool = True

    def _members(self) -> list[tuple[str, str, str]]:
        found = []
        for group in f"{self.inputs};{self.outputs}".split(";"):
            kind, *names = group.split()
            for given in names:
                name, _, default = given.partition("=")
                found.append((name, kind, default))
        return found

    def members(self) -> Mapping[str, Data]:
        """Return the types of the members, by their names in upper case."""
        return {name.upper(): Data(kind) for name, kind, _ in self._members()}

    def of_inputs(self) -> Mapping[str, Data]:
        """Return the types of the input parameters, by their names in upper case."""
        return Structure(self.inputs, "BOOL").members()

    def defaults(self) -> Mapping[str, str]:
        """Return the default values that are not 0, by the names of the members in upper case."""
        return {name.upper(): default for name, _, default in self._members() if default}

    def text(self, name: str) -> str:
        """Return the declaration."""
        if not self.body:
            members = "".join(
                f"    {member} : {kind}{f' := {default}' if default else ''};\n"
                for member, kind, default in self._members()
            )
            return f"TYPE {name} : STRUCT\n{members}  END_STRUCT;\nEND_TYPE"
        inputs = "".join(f"    {line}\n" for line in _declared(self.inputs))
        outputs = "".join(f"    {line}\n" for line in _declared(self.outputs))
        return (
            f"FUNCTION_BLOCK {name}\n"
            f"  VAR_INPUT RETAIN\n{inputs}  END_VAR\n"
            f"  VAR_OUTPUT{' RETAIN' if self.kept else ''}\n{outputs}  END_VAR\n"
            f"{self.others}{_ENABLED}{self.disabled}{_BEHIND}{self.body}END_FUNCTION_BLOCK"
        )


def _declared(text: str) -> list[str]:
    """Return the declarations of some members; those with a default value stand alone."""
    lines = []
    for group in text.split(";"):
        kind, *names = group.split()
        plain = [name for name in names if "=" not in name]
        for given in names:
            name, mark, default = given.partition("=")
            if mark:
                lines.append(f"{name} : {kind} := {default};")
        if plain:
            lines.append(f"{', '.join(plain)} : {kind};")
    return lines


_ENABLED = """\
  EnableOut := EnableIn;
  IF NOT EnableIn THEN
"""
_BEHIND = """\
    RETURN;
  END_IF;
"""
_IN, _OUT = "BOOL EnableIn=TRUE", "BOOL EnableOut"
_EIGHT = tuple(f"In{number}" for number in range(1, 9))


def _joined(word: str, default: str) -> Structure:
    """Return the structure of BAND or BOR. Inputs without a wire have the default value."""
    inputs = " ".join(f"{name}{default}" for name in _EIGHT)
    first, last = (f" {word} ".join(some) for some in (_EIGHT[:4], _EIGHT[4:]))
    body = f"  Out := {first}\n    {word} {last};\n"
    return Structure(f"{_IN} {inputs}", f"{_OUT} Out", body)


def _captured(sign: str) -> Structure:
    """Return the structure of MAXC or MINC. The first value is captured (assumed)."""
    body = (
        "  IF Reset THEN\n    Out := ResetValue;\n"
        f"  ELSIF In {sign} Out OR NOT HasRun THEN\n    Out := In;\n  END_IF;\n"
        "  HasRun := TRUE;\n"
    )
    inputs = f"{_IN} Reset;REAL In ResetValue"
    others = "  VAR\n    HasRun : BOOL;\n  END_VAR\n"
    return Structure(inputs, f"{_OUT};REAL Out", body, others, "    HasRun := FALSE;\n")


_MATH = "REAL SourceA SourceB"
#: Both inputs that are TRUE at the first execution are no edge: 1756-RM003N, page 151.
_COUNTER = """\
  IF Reset THEN
    Up := FALSE;
    Down := FALSE;
    CU := FALSE;
    CD := FALSE;
    DN := FALSE;
    OV := FALSE;
    UN := FALSE;
    ACC := 0;
    RETURN;
  END_IF;
  IF CUEnable AND NOT Up THEN
    IF ACC < 2147483647 THEN
      ACC := ACC + 1;
    ELSE
      ACC := -2147483648;
      OV := NOT UN;
      UN := FALSE;
    END_IF;
  END_IF;
  IF CDEnable AND NOT Down THEN
    IF ACC > -2147483648 THEN
      ACC := ACC - 1;
    ELSE
      ACC := 2147483647;
      UN := NOT OV;
      OV := FALSE;
    END_IF;
  END_IF;
  Up := CUEnable;
  Down := CDEnable;
  CU := CUEnable;
  CD := CDEnable;
  DN := OV OR ACC >= PRE AND NOT UN;
"""
_LIMITED = """\
  SelectLimitInv := SelectLimit < 0 OR SelectLimit > 2;
  LimitsInv := (SelectLimitInv OR SelectLimit = 0) AND LowLimit >= HighLimit;
  InstructFault := SelectLimitInv OR LimitsInv;
  Status := BOOL_TO_DINT(InstructFault) + 2 * BOOL_TO_DINT(LimitsInv)
    + 4 * BOOL_TO_DINT(SelectLimitInv);
  HighAlarm := SelectLimit <> 2 AND In >= HighLimit;
  LowAlarm := SelectLimit <> 1 AND In <= LowLimit;
  IF LimitsInv THEN
    Out := LowLimit;
  ELSIF HighAlarm THEN
    Out := HighLimit;
  ELSIF LowAlarm THEN
    Out := LowLimit;
  ELSE
    Out := In;
  END_IF;
"""
_SCALED = """\
  InRawRangeInv := InRawMin >= InRawMax;
  InstructFault := InRawRangeInv;
  Status := 3 * BOOL_TO_DINT(InRawRangeInv);
  IF InRawRangeInv THEN
    RETURN;
  END_IF;
  MaxAlarm := In > InRawMax;
  MinAlarm := In < InRawMin;
  IF Limiting AND MaxAlarm THEN
    Out := InEUMax;
  ELSIF Limiting AND MinAlarm THEN
    Out := InEUMin;
  ELSE
    Out := (In - InRawMin) * ((InEUMax - InEUMin) / (InRawMax - InRawMin)) + InEUMin;
  END_IF;
"""
#: A field that is not inside of 32 bits keeps the output (assumed).
_DISTRIBUTED = """\
  IF SourceBit < 0 OR SourceBit > 31 OR DestBit < 0 OR DestBit > 31 OR Length < 1 OR Length > 32
  THEN
    RETURN;
  END_IF;
  Mask := SHL(SHR(DWORD#16#FFFFFFFF, 32 - Length), DestBit);
  Field := SHL(SHR(DINT_TO_DWORD(Source), SourceBit), DestBit);
  Dest := DWORD_TO_DINT(Field AND Mask OR DINT_TO_DWORD(Target) AND NOT Mask);
"""
#: In is not finite only by a mistake of the program, so that this case is not computed.
_AVERAGED = """\
  IF NOT HasRun THEN
    Out := 0.0;
    HasRun := TRUE;
  END_IF;
  IF WasOff THEN
    Count := 0;
    WasOff := FALSE;
  END_IF;
  Size := UPPER_BOUND(StorageArray, 1) + 1;
  IF UseWeights AND UPPER_BOUND(WeightArray, 1) + 1 < Size THEN
    Size := UPPER_BOUND(WeightArray, 1) + 1;
  END_IF;
  InFaulted := InFault;
  NumberOfSampInv := NumberOfSamples < 1 OR NumberOfSamples > Size;
  InstructFault := InFaulted OR NumberOfSampInv;
  Status := BOOL_TO_DINT(InstructFault) + 2 * BOOL_TO_DINT(InFaulted)
    + 4 * BOOL_TO_DINT(NumberOfSampInv);
  IF NumberOfSampInv THEN
    Count := 0;
    RETURN;
  ELSIF InFaulted THEN
    RETURN;
  ELSIF Initialize THEN
    Count := 0;
    Out := In;
    RETURN;
  ELSIF NOT SampleEnable THEN
    RETURN;
  END_IF;
  IF Count < NumberOfSamples THEN
    Count := Count + 1;
  END_IF;
  IF Count > NumberOfSamples THEN
    Count := NumberOfSamples;
  END_IF;
  FOR Place := UPPER_BOUND(StorageArray, 1) TO 1 BY -1 DO
    StorageArray[Place] := StorageArray[Place - 1];
  END_FOR;
  StorageArray[0] := In;
  Sum := 0.0;
  FOR Place := 0 TO Count - 1 DO
    IF UseWeights THEN
      Sum := Sum + StorageArray[Place] * WeightArray[Place];
    ELSE
      Sum := Sum + StorageArray[Place];
    END_IF;
  END_FOR;
  IF UseWeights THEN
    Out := Sum;
  ELSE
    Out := Sum / DINT_TO_REAL(Count);
  END_IF;
"""
#: The first run clears the timer. A negative preset stops it. ACC counts whole milliseconds; the
#: rest of the time counts in the next call. Source: 1756-RM003N, TONR, TOFR and RTOR.
_TIMED = """\
  IF NOT HasRun THEN
    EN := FALSE;
    TT := FALSE;
    DN := FALSE;
    IF OffDelay THEN
      ACC := PRE;
    ELSIF NOT Retentive THEN
      ACC := 0;
    END_IF;
    HasRun := TRUE;
  END_IF;
  PresetInv := PRE < 0;
  InstructFault := PresetInv;
  Status := 0;
  IF PresetInv THEN
    Status := 3;
    RETURN;
  END_IF;
  Clock(IN := TRUE, PT := T#100s);
  Rest := Rest + Clock.ET;
  Clock(IN := FALSE, PT := T#100s);
  Clock(IN := TRUE, PT := T#100s);
  IF NOT Runs THEN
    Rest := T#0s;
  END_IF;
  EN := TimerEnable AND NOT Reset;
  Runs := SEL(OffDelay, EN, DN AND NOT TimerEnable AND NOT Reset);
  IF Reset THEN
    DN := FALSE;
    ACC := SEL(OffDelay, 0, PRE);
  ELSIF OffDelay AND TimerEnable OR NOT OffDelay AND NOT TimerEnable AND NOT Retentive THEN
    ACC := 0;
  END_IF;
  WHILE Rest >= T#1s DO
    Rest := Rest - T#1s;
    IF Runs AND (OffDelay OR NOT DN) THEN
      ACC := ACC + 1000;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#10ms DO
    Rest := Rest - T#10ms;
    IF Runs AND (OffDelay OR NOT DN) THEN
      ACC := ACC + 10;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#1ms DO
    Rest := Rest - T#1ms;
    IF Runs AND (OffDelay OR NOT DN) THEN
      ACC := ACC + 1;
    END_IF;
  END_WHILE;
  IF OffDelay THEN
    DN := EN OR Runs AND ACC < PRE;
    TT := Runs AND DN;
  ELSE
    IF EN OR NOT Retentive THEN
      DN := EN AND ACC >= PRE;
    END_IF;
    TT := EN AND NOT DN;
  END_IF;
"""
#: OSRI and OSFI.
_ONE_SHOT = """\
  IF Falling THEN
    OutputBit := Before AND NOT InputBit;
  ELSE
    OutputBit := InputBit AND NOT Before;
  END_IF;
  Before := InputBit;
"""
#: The structures by their names. Defaults are those of the manual and of exported projects.
STRUCTURES: dict[str, Structure] = {
    "FBD_MATH": Structure(f"{_IN};{_MATH}", f"{_OUT};REAL Dest"),
    "FBD_MATH_ADVANCED": Structure(f"{_IN};REAL Source", f"{_OUT};REAL Dest"),
    "FBD_COMPARE": Structure(f"{_IN};{_MATH}", f"{_OUT} Dest"),
    "FBD_LOGICAL": Structure(f"{_IN};DINT SourceA SourceB", f"{_OUT};DINT Dest"),
    "FBD_CONVERT": Structure(f"{_IN};DINT Source", f"{_OUT};DINT Dest"),
    "FBD_TRUNCATE": Structure(f"{_IN};REAL Source", f"{_OUT};DINT Dest"),
    "FBD_LIMIT": Structure(f"{_IN};REAL LowLimit Test HighLimit", f"{_OUT} Dest"),
    "FBD_MASK_EQUAL": Structure(f"{_IN};DINT Source Mask Compare", f"{_OUT} Dest"),
    "FBD_MASKED_MOVE": Structure(f"{_IN};DINT Source Mask Target", f"{_OUT};DINT Dest"),
    "FBD_BOOLEAN_AND": _joined("AND", "=TRUE"),
    "FBD_BOOLEAN_OR": _joined("OR", ""),
    "FBD_BOOLEAN_XOR": Structure(f"{_IN} In1 In2", f"{_OUT} Out", "  Out := In1 XOR In2;\n"),
    "FBD_BOOLEAN_NOT": Structure(f"{_IN} In", f"{_OUT} Out", "  Out := NOT In;\n"),
    "FBD_TIMER": Structure(
        f"{_IN} TimerEnable Reset;DINT PRE",
        f"{_OUT} EN TT DN InstructFault PresetInv;DINT ACC Status",
        _TIMED,
        "  VAR_INPUT\n    OffDelay, Retentive : BOOL;\n  END_VAR\n"
        "  VAR\n    HasRun, Runs : BOOL;\n    Clock : TON;\n    Rest : TIME;\n  END_VAR\n",
        "    Runs := FALSE;\n",
        kept=False,
    ),
    "FBD_ONESHOT": Structure(
        f"{_IN} InputBit",
        f"{_OUT} OutputBit",
        _ONE_SHOT,
        "  VAR_INPUT RETAIN\n    Falling : BOOL;\n  END_VAR\n"
        "  VAR\n    Before : BOOL;\n  END_VAR\n",
        kept=False,
    ),
    "FBD_COUNTER": Structure(
        f"{_IN} CUEnable CDEnable;DINT PRE;BOOL Reset",
        f"{_OUT};DINT ACC;BOOL CU CD DN OV UN",
        _COUNTER,
        "  VAR\n    Up, Down : BOOL := TRUE;\n  END_VAR\n",
        "    Up := TRUE;\n    Down := TRUE;\n",
    ),
    "DOMINANT_SET": Structure(
        f"{_IN} Set Reset",
        f"{_OUT} Out OutNot",
        "  Out := Set OR Out AND NOT Reset;\n  OutNot := NOT Out;\n",
    ),
    "DOMINANT_RESET": Structure(
        f"{_IN} Set Reset",
        f"{_OUT} Out OutNot",
        "  Out := (Set OR Out) AND NOT Reset;\n  OutNot := NOT Out;\n",
    ),
    "FBD_BIT_FIELD_DISTRIBUTE": Structure(
        f"{_IN};DINT Source SourceBit Length=1 DestBit Target",
        f"{_OUT};DINT Dest",
        _DISTRIBUTED,
        "  VAR\n    Mask, Field : DWORD;\n  END_VAR\n",
    ),
    "MAXIMUM_CAPTURE": _captured(">"),
    "MINIMUM_CAPTURE": _captured("<"),
    "SELECT": Structure(
        f"{_IN};REAL In1 In2;BOOL SelectorIn",
        f"{_OUT};REAL Out",
        "  Out := SEL(SelectorIn, In1, In2);\n",
    ),
    "HL_LIMIT": Structure(
        f"{_IN};REAL In HighLimit LowLimit;DINT SelectLimit",
        f"{_OUT};REAL Out;BOOL HighAlarm LowAlarm;DINT Status;"
        "BOOL InstructFault LimitsInv SelectLimitInv",
        _LIMITED,
    ),
    "SCALE": Structure(
        f"{_IN};REAL In InRawMax InRawMin InEUMax InEUMin;BOOL Limiting",
        f"{_OUT};REAL Out;BOOL MaxAlarm MinAlarm;DINT Status;BOOL InstructFault InRawRangeInv",
        _SCALED,
    ),
    "MOVING_AVERAGE": Structure(
        f"{_IN};REAL In;BOOL InFault Initialize SampleEnable=TRUE;DINT NumberOfSamples=1;"
        "BOOL UseWeights",
        f"{_OUT};REAL Out;DINT Status;BOOL InstructFault InFaulted NumberOfSampInv",
        _AVERAGED,
        "  VAR_IN_OUT\n    StorageArray, WeightArray : ARRAY [*] OF REAL;\n  END_VAR\n"
        "  VAR\n    WasOff : BOOL := TRUE;\n    HasRun : BOOL;\n"
        "    Count, Size, Place : DINT;\n    Sum : REAL;\n  END_VAR\n",
        "    WasOff := TRUE;\n",
    ),
}
