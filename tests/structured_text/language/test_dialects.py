"""Programs compute as the tool of their dialect does, for each row of `language/dialects.toml`.

Expected values come from the makers' documents, which the table names as sources.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from structured_text.bench import Bench
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.load import build as build_on
from structured_text.errors import InputError
from structured_text.language.dialects import dialect_of, dialects, rows, rules_of, using
from structured_text.language.load import load
from structured_text.language.source import in_dialect
from structured_text.projects.sources import source_files

Build = Callable[..., BuiltinProgram]

_MILLISECONDS = ("codesys", "twincat", "tia", "ax", "logix")
_AS_MATIEC = ("iec", "openplc")


@pytest.fixture
def speak(files_of: Callable[..., list[Path]]) -> Build:
    """Return a function that compiles a source in a dialect."""
    return lambda dialect, text: BuiltinProgram.build(
        load([in_dialect(file, dialect) for file in files_of(text)])
    )


def test_each_tool_has_one_row_of_each_rule_with_its_meaning_and_source() -> None:
    """For each rule, the table has one row for each tool.

    Source: language/dialects.toml.
    """
    rules = {row.rule for row in rows()}
    found = sorted((row.rule, tool) for row in rows() for tool in row.tools)
    assert found == sorted((rule, tool) for rule in rules for tool in dialects())
    assert all(row.meaning and row.source and row.title for row in rows())
    assert {name for name in dialects() if rules_of(name).is_matiec} == set(_AS_MATIEC)
    assert [name for name in dialects() if rules_of(name).is_standard] == ["iec"]


# --- TIME as a number -------------------------------------------------------------------------

_TIMES = """
PROGRAM Main
VAR
  FromNumber : TIME; Five, Cut : DINT; Text : REAL; Bits : DWORD; Clock : UDINT; Long : LINT;
  FromReal, Half : TIME := T#1500ms; Day : UDINT; OfBool : TIME; Midnight : TOD;
END_VAR
FromNumber := UDINT_TO_TIME(500); Five := TIME_TO_DINT(T#5m); Cut := TIME_TO_DINT(Half);
Text := TIME_TO_REAL(Half); Bits := TIME_TO_DWORD(T#5m); Clock := TOD_TO_UDINT(TOD#00:00:00.012);
Long := LTIME_TO_LINT(LTIME#2us1ns); FromReal := REAL_TO_TIME(2.5);
Day := DATE_TO_UDINT(D#1970-01-02); Midnight := UDINT_TO_TOD(1000);
END_PROGRAM
"""


@pytest.mark.parametrize("dialect", _MILLISECONDS)
def test_time_is_a_number_of_milliseconds(speak: Build, dialect: str) -> None:
    """Conversions between TIME and numbers count milliseconds in these dialects.

    Source: CODESYS help, TIME_TO: TIME_TO_DWORD(T#5m) is 300000, TOD#00:00:00.012 is 12.
    """
    program = speak(dialect, _TIMES)
    program.scan(0)
    read = _milliseconds(program)
    assert read("FromNumber") == 500
    assert program.read("Main.Five") == program.read("Main.Bits") == 300_000
    assert program.read("Main.Cut") == 1500
    assert program.read("Main.Text") == 1500.0
    assert program.read("Main.Clock") == 12
    assert program.read("Main.Long") == 2001
    assert read("FromReal") == 2.5
    assert program.read("Main.Day") == 86_400


@pytest.mark.parametrize("dialect", _AS_MATIEC)
def test_time_is_a_number_of_seconds_as_in_matiec(speak: Build, dialect: str) -> None:
    """Conversions between TIME and numbers count seconds in matiec's dialects.

    Source: matiec, iec_std_functions.h: __time_to_int is tv_sec.
    """
    program = speak(dialect, _TIMES)
    program.scan(0)
    read = _milliseconds(program)
    assert read("FromNumber") == 500_000
    assert program.read("Main.Five") == 300
    assert program.read("Main.Cut") == 1
    assert program.read("Main.Text") == 1.5
    assert program.read("Main.Clock") == 0
    assert read("FromReal") == 2500


def _milliseconds(program: BuiltinProgram) -> Callable[[str], float]:
    return lambda name: program.read(f"Main.{name}").total_seconds() * 1000


# --- texts ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "kind", "short", "digits"),
    [
        ("REAL#44.4", "REAL", "44.4", "44.40000153"),
        ("REAL#-0.5", "REAL", "-0.5", "-0.5"),
        ("LREAL#6.0", "LREAL", "6.0", "6"),
        ("BYTE#16#AB", "BYTE", "171", "16#ab"),
        ("T#12h34m15s10ms", "TIME", "T#12h34m15s10ms", "T#0d12h34m15s10ms"),
        ("T#12ms", "TIME", "T#12ms", "T#0d0h0m0s12ms"),
        ("T#0ms", "TIME", "T#0ms", "T#0d"),
        ("T#-1h5s", "TIME", "T#-1h5s", "T#0d-1h0m-5s"),
        ("LTIME#1d34ms2us44ns", "LTIME", "LTIME#1d34ms2us44ns", "LT#1d0h0m0s34.002044ms"),
        ("TOD#14:01:05.123", "TOD", "TOD#14:01:05.123", "TOD#14:01:05.123000"),
        ("TOD#14:01:05", "TOD", "TOD#14:01:05", "TOD#14:01:05"),
        ("INT#-7", "INT", "-7", "-7"),
    ],
)
def test_texts_of_values_are_those_of_the_tool(
    speak: Build, value: str, kind: str, short: str, digits: str
) -> None:
    """A value that is converted to a text has the form of the dialect's tool.

    Source: Beckhoff Infosys, TIME_TO, TOD_TO; TcUnit-Verifier; matiec, __real_to_string.
    """
    text = f"""PROGRAM Main VAR Found : STRING; Given : {kind} := {value}; END_VAR
    Found := {kind}_TO_STRING(Given); END_PROGRAM"""
    for dialect, expected in (("twincat", short), ("codesys", short), ("iec", digits)):
        program = speak(dialect, text)
        program.scan(0)
        assert program.read("Main.Found") == expected


# --- counters ---------------------------------------------------------------------------------

_COUNTERS = """
PROGRAM Main
VAR
  Entry, Leave : BOOL; Up : CTU; Down : CTD; Parts : CTUD; Free : CTUD; Wide : CTD_UDINT;
END_VAR
Up(CU := Entry, R := FALSE, PV := 2);
Down(CD := Entry, LD := FALSE, PV := 2);
Parts(CU := Entry, CD := Leave, R := FALSE, LD := FALSE, PV := 3);
Free(CU := Entry, CD := Leave, R := FALSE, LD := FALSE);
Wide(CD := Entry, LD := FALSE, PV := 2);
END_PROGRAM
"""


def _count(program: BuiltinProgram, pin: str, pulses: int) -> None:
    for number in range(2 * pulses):
        program.write(f"Main.{pin}", number % 2 == 0)
        program.scan(0)


@pytest.mark.parametrize(
    ("dialect", "up", "down", "parts", "free"),
    [
        # With PV 3, five edges up and two down: matiec stops counting at 3.
        ("iec", 5, -5, 3, 3),
        ("openplc", 2, 0, 1, 0),
        ("codesys", 5, 0, 3, 3),
        ("twincat", 5, 0, 3, 3),
        ("tia", 5, -5, 3, 3),
        ("ax", 5, -5, 3, 3),
        ("logix", 5, -5, 3, 3),
    ],
)
def test_counters_count_beyond_pv_to_the_limits_of_their_type(
    speak: Build, dialect: str, up: int, down: int, parts: int, free: int
) -> None:
    """In these dialects a counter counts beyond PV, up to the limits of its type.

    Source: IEC 61131-3, counters (PVmax, PVmin); the sources in dialects.toml.
    """
    program = speak(dialect, _COUNTERS)
    _count(program, "Entry", 5)
    _count(program, "Leave", 2)
    found = [program.read(f"Main.{name}.CV") for name in ("Up", "Down", "Parts", "Free", "Wide")]
    assert found == [up, down, parts, free, 0]
    assert program.read("Main.Parts.QU") is (parts >= 3)
    assert program.read("Main.Up.Q")
    assert program.read("Main.Down.Q")


@pytest.mark.parametrize(("dialect", "least"), [("iec", -32768), ("tia", -32768), ("twincat", 0)])
def test_counters_stop_at_the_limits_of_their_type(speak: Build, dialect: str, least: int) -> None:
    """At a limit of its type, a counter stops and does not wrap.

    Source: IEC 61131-3, counters; Siemens A5E00739858, SFB 2: -32768 and 32767.
    """
    program = speak(dialect, _COUNTERS)
    program.write("Main.Up.CV", 32766)
    program.write("Main.Down.CV", least + 1)
    _count(program, "Entry", 3)
    assert program.read("Main.Up.CV") == 32767
    assert program.read("Main.Down.CV") == least


# --- AND, OR ----------------------------------------------------------------------------------

_CALLS = """
VAR_GLOBAL Calls : INT; Zero : INT; END_VAR
FUNCTION F_Count : BOOL
VAR_INPUT Given : BOOL; END_VAR
Calls := Calls + 1; F_Count := Given;
END_FUNCTION
PROGRAM Main
VAR No : BOOL; A, B, C, D, E : BOOL; END_VAR
A := No AND F_Count(TRUE);
B := NOT No OR F_Count(TRUE);
IF No & F_Count(TRUE) THEN A := TRUE; END_IF
C := AND(No, F_Count(TRUE), F_Count(FALSE));
D := No XOR F_Count(TRUE);
E := No AND_THEN F_Count(TRUE);
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("dialect", "calls"), [("iec", 1), ("tia", 1), ("codesys", 6), ("twincat", 6)]
)
def test_and_or_evaluate_both_operands_where_the_tool_does(
    speak: Build, dialect: str, calls: int
) -> None:
    """In the dialects of CODESYS and TwinCAT, AND and OR always evaluate both operands.

    Source: CODESYS help and Infosys, AND_THEN.
    """
    program = speak(dialect, _CALLS)
    program.scan(0)
    assert program.read("Calls") == calls
    assert [program.read(f"Main.{one}") for one in "ABCDE"] == [False, True, False, True, False]


def test_a_division_on_the_right_of_and_ends_the_run_where_both_are_evaluated(
    speak: Build,
) -> None:
    """A division by 0 on the right of AND ends the run if AND evaluates both operands.

    Source: Infosys, AND_THEN and DIV: an exception, which AND_THEN avoids.
    """
    text = """PROGRAM Main VAR N : INT; R : BOOL; END_VAR
    R := (N <> 0) AND (10 / N > 1);
    END_PROGRAM"""
    speak("iec", text).scan(0)
    with pytest.raises(InputError, match="division by zero"):
        speak("twincat", text).scan(0)


# --- INT * INT --------------------------------------------------------------------------------

_INTEGERS = """
PROGRAM Main
VAR
  A, B : INT := 300; X, Y : INT := 20000; W : BYTE := 200; Max : WORD := 65535; Zero : WORD;
  Least : SINT := -128; Third : WORD; Field : ARRAY[0..500] OF INT; Tiny : USINT;
  Long, Negative : DINT; Mean : REAL; Sum : UINT; Big : DWORD; Equal, Less, Stored, Cut : BOOL;
  Wraps : INT; Place : INT; Above : BOOL; Chosen : INT; Wrong : BOOL;
END_VAR
Long := A * B;
Mean := (X + Y) / 2;
Sum := W + W;
Big := Max + 1;
Equal := (Max + 1) = Zero;
Less := (Zero - 1) = Max;
Third := Max + 1; Stored := Third = Zero;
Cut := TO_WORD(Max + 1) = Zero;
Wraps := A * B;
Negative := -Least;
Field[400] := 7; Place := Field[W + W];
Above := X + Y > 30000;
CASE X + Y OF 0..10: Chosen := 1; ELSE Chosen := 2; END_CASE
Wrong := Tiny - 1 <> 255;
END_PROGRAM
"""


@pytest.mark.parametrize("dialect", ["codesys", "twincat", "logix"])
def test_short_integers_are_calculated_as_dint(speak: Build, dialect: str) -> None:
    """In CODESYS, SINT and INT are calculated as DINT.

    Source: CODESYS help, operators, overflow in the data type; Static Analysis SA0066.
    """
    program = speak(dialect, _INTEGERS)
    program.scan(0)
    read = {name: program.read(f"Main.{name}") for name in
            ("Long", "Mean", "Sum", "Big", "Equal", "Less", "Stored", "Cut", "Wraps", "Negative",
             "Place", "Above", "Wrong")}  # fmt: skip
    assert read == {
        "Long": 90_000,
        "Mean": 20_000.0,
        "Sum": 400,
        "Big": 65_536,
        "Equal": False,
        "Less": False,
        "Stored": True,
        "Cut": True,
        "Wraps": 90_000 - 65_536,
        "Negative": 128,
        "Place": 7,
        "Above": True,
        "Wrong": True,
    }


@pytest.mark.parametrize("dialect", ["iec", "tia"])
def test_short_integers_are_calculated_in_their_own_type(speak: Build, dialect: str) -> None:
    """In these dialects, sums of SINT or INT wrap in their own type.

    Source: IEC 61131-3, arithmetic functions: the result has the type of the operands.
    """
    text = _INTEGERS.replace("Place := Field[W + W];", "")
    program = speak(dialect, text)
    program.scan(0)
    read = {name: program.read(f"Main.{name}") for name in
            ("Long", "Mean", "Sum", "Equal", "Negative", "Above", "Wrong")}  # fmt: skip
    assert read == {
        "Long": 90_000 - 65_536,
        "Mean": -12_768.0,
        "Sum": 144,
        "Equal": True,
        "Negative": -128,
        "Above": False,
        "Wrong": False,
    }


def test_a_place_that_takes_no_int_refuses_a_sum_of_int_in_each_dialect(speak: Build) -> None:
    """A sum of INT cannot be assigned to a SINT or STRING in any dialect.

    Source: IEC 61131-3, assignment: the value has the type of the variable.
    """
    text = "PROGRAM Main VAR A : INT; U : UDINT; T : STRING; END_VAR\n{} END_PROGRAM"
    for dialect in ("iec", "codesys"):
        with pytest.raises(InputError, match=r"a STRING.* is expected here, not a INT"):
            speak(dialect, text.format("T := A + A;"))
        with pytest.raises(InputError, match="a SINT is expected here, not a INT"):
            speak(dialect, text.replace("U : UDINT", "U : SINT").format("U := A + A;"))


# --- texts, reals -----------------------------------------------------------------------------

_TEXTS = """
PROGRAM Main
VAR S : STRING; Two : STRING[255]; N, M, Size : INT; END_VAR
S := '{}'; N := LEN(S); Two := CONCAT(S, S); M := LEN(Two);
END_PROGRAM
""".format("0123456789" * 30)


@pytest.mark.parametrize(
    ("dialect", "length", "joined"),
    [
        ("iec", 126, 126),
        ("codesys", 80, 160),
        ("twincat", 80, 160),
        ("tia", 254, 255),
        ("logix", 82, 164),
    ],
)
def test_a_plain_string_has_the_length_of_the_tool(
    speak: Build, dialect: str, length: int, joined: int
) -> None:
    """A STRING without a length has the default length of the dialect's tool.

    Source: CODESYS help and Infosys, STRING: 80; S7-SCL: 254; Rockwell: 82; matiec: 126.
    """
    program = speak(dialect, _TEXTS)
    program.scan(0)
    assert program.read("Main.N") == length
    assert program.read("Main.M") == joined


_REALS = """
PROGRAM Main
VAR N, Z, M, R, Low : REAL; L, LZ : LREAL := 2.0; Same, Big : BOOL; END_VAR
N := 1.0 / Z; M := N - N; Same := M = M; Big := N > 1.0E38; Low := (Z - 1.0) / Z;
LZ := 0.0; L := L / LZ;
END_PROGRAM
"""


@pytest.mark.parametrize("dialect", ["tia", "ax", "logix"])
def test_a_real_divided_by_zero_is_infinite(speak: Build, dialect: str) -> None:
    """In S7 and Logix dialects a division by 0.0 gives an infinite value.

    Source: S7, 1.0 / 0.0 is 16#7F800000; Rockwell 1756-RM003, DIV: a minor fault only.
    """
    program = speak(dialect, _REALS)
    program.scan(0)
    assert program.read("Main.N") == program.read("Main.L") == float("inf")
    assert program.read("Main.Low") == float("-inf")
    assert program.read("Main.M") != program.read("Main.M")
    assert (program.read("Main.Same"), program.read("Main.Big")) == (False, True)


@pytest.mark.parametrize("dialect", ["iec", "codesys", "twincat"])
def test_a_real_divided_by_zero_ends_the_run_with_the_line(speak: Build, dialect: str) -> None:
    """In these dialects, a REAL divided by 0.0 ends the run with the line.

    Source: Infosys, DIV: always an exception.
    """
    with pytest.raises(InputError, match="division by zero") as caught:
        speak(dialect, _REALS).scan(0)
    assert caught.value.line == 4


_ROOT = "PROGRAM Main VAR X, R : REAL := -4.0; END_VAR\nR := SQRT(X);\nEND_PROGRAM"


def test_the_root_of_a_negative_number_depends_on_the_dialect(speak: Build) -> None:
    """SQRT(-4.0) is 2.0 in Logix, not a number in S7, and an error in TwinCAT.

    Source: Rockwell, SQRT: the absolute value is taken; S7: not a number; Infosys: a stop.
    """
    found: dict[str, Any] = {}
    for dialect in ("tia", "logix"):
        program = speak(dialect, _ROOT)
        program.scan(0)
        found[dialect] = program.read("Main.R")
    assert found["logix"] == 2.0
    assert found["tia"] != found["tia"]
    for dialect in ("iec", "twincat"):
        with pytest.raises(InputError, match="not defined"):
            speak(dialect, _ROOT).scan(0)


# --- tasks ------------------------------------------------------------------------------------

_TASKS = """
PROGRAM Fast VAR N : DINT; END_VAR N := N + 1; END_PROGRAM
PROGRAM Slow VAR K : DINT; END_VAR K := K + 1; END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T2(INTERVAL := T#{}, PRIORITY := 2);
    PROGRAM F : Fast;
    PROGRAM S WITH T2 : Slow;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.mark.parametrize(
    ("interval", "scan", "fast", "slow"),
    [
        ("1s", None, 200, 2),
        ("1s", "5ms", 400, 2),
        ("1s", "20ms", 100, 2),
        ("25ms", None, 400, 80),  # A scan of 5 ms fits the interval of the task.
        ("4ms", None, 1000, 500),  # A task of 4 ms needs a scan of 2 ms.
    ],
)
def test_a_program_without_a_task_runs_in_each_scan_and_the_task_at_its_interval(
    files_of: Callable[..., list[Path]], interval: str, scan: str | None, fast: int, slow: int
) -> None:
    """A program without a task runs in each scan, the other program at its task's interval.

    Source: IEC 61131-3, tasks; Rockwell 1756-PM005: the continuous task restarts at once.
    """
    with Bench.build(files_of(_TASKS.format(interval)), scan=scan, engine="builtin") as bench:
        bench.run("2s")
        assert (bench["F.N"], bench["S.K"]) == (fast, slow)


# --- which dialect ----------------------------------------------------------------------------

_POU = """<TcPlcObject Version="1.1.0.1"><POU Name="MAIN"><Declaration><![CDATA[PROGRAM MAIN
VAR t : TIME; END_VAR]]></Declaration><Implementation><ST>t := UDINT_TO_TIME(500);</ST>
</Implementation></POU></TcPlcObject>"""
_SCL = """FUNCTION_BLOCK "Clk"
VERSION : 0.1
VAR_OUTPUT t : Time; END_VAR
BEGIN
 #t := UDINT_TO_TIME(500);
END_FUNCTION_BLOCK
"""
_XML = """<project xmlns="http://www.plcopen.org/xml/tc6_0200">
<fileHeader companyName="" productName="{}" productVersion="1" creationDateTime="2026-01-01"/>
<types><dataTypes/><pous><pou name="Main" pouType="program">
<interface><localVars><variable name="t"><type><TIME/></type></variable></localVars></interface>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">t := UDINT_TO_TIME(500);</xhtml></ST></body>
</pou></pous></types>{}</project>"""
_ADDED = (
    '<addData><data name="http://www.3s-software.com/plcopenxml/x" handleUnknown="x"/></addData>'
)


@pytest.mark.parametrize(
    ("name", "text", "dialect"),
    [
        ("a.TcPOU", _POU, "twincat"),
        ("a.scl", _SCL, "tia"),
        ("a.xml", _XML.format("CODESYS", ""), "codesys"),
        ("a.xml", _XML.format("Machine Expert", _ADDED), "codesys"),
        ("a.xml", _XML.format("TwinCAT PLC Control", _ADDED), "twincat"),
        ("a.xml", _XML.format("Beremiz", ""), "openplc"),
        ("a.xml", _XML.format("OpenPLC Editor", ""), "openplc"),
        ("a.xml", _XML.format("another tool", ""), "iec"),
    ],
)
def test_the_format_of_a_project_says_its_dialect(
    tmp_path: Path, name: str, text: str, dialect: str
) -> None:
    """The file format of a project selects the dialect, unless the user gives one.

    Source: docs/how-to/projects.md.
    """
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    assert source_files(file, None).dialect == dialect
    assert source_files(file, None, dialect="logix").dialect == "logix"
    with using("iec"):
        assert source_files(file, None).dialect == "iec"
    assert source_files(file, None).dialect == dialect


def test_files_of_simatic_ax_are_known_by_their_apax_yml(tmp_path: Path) -> None:
    """ST files in a folder with apax.yml have the dialect of SIMATIC AX.

    Source: docs/how-to/projects.md.
    """
    (tmp_path / "src").mkdir()
    file = tmp_path / "src/main.st"
    file.write_text("PROGRAM Main VAR A : INT; END_VAR A := 1; END_PROGRAM", encoding="utf-8")
    assert source_files(file, None).dialect == "iec"
    (tmp_path / "apax.yml").write_text("name: cell\n", encoding="utf-8")
    assert source_files(file, None).dialect == "ax"


def test_files_of_two_tools_need_the_users_choice(tmp_path: Path) -> None:
    """Files of two tools are refused until the user chooses a dialect.

    Source: docs/how-to/projects.md.
    """
    files = [tmp_path / "a.TcPOU", tmp_path / "b.scl"]
    files[0].write_text(_POU, encoding="utf-8")
    files[1].write_text(_SCL, encoding="utf-8")
    with pytest.raises(InputError, match="the files are of two tools") as caught:
        source_files(files, None)
    assert "--dialect tia or twincat" in caught.value.hint
    assert source_files(files, None, dialect="tia").dialect == "tia"


def test_an_unknown_dialect_is_refused_with_the_nearest_name() -> None:
    """The error for an unknown dialect proposes the nearest name.

    Source: language/dialects.py.
    """
    with pytest.raises(InputError, match="there is no dialect 'codsys'") as caught:
        rules_of("codsys")
    assert "codesys" in caught.value.hint


def test_two_dialects_of_one_file_are_two_programs(files_of: Callable[..., list[Path]]) -> None:
    """One file in two dialects gives two different programs, which the caches do not mix up.

    Source: language/cache.py.
    """
    files = files_of("PROGRAM Main VAR D : DINT; END_VAR D := TIME_TO_DINT(T#2s); END_PROGRAM")
    for dialect, value in (("iec", 2), ("tia", 2000), ("iec", 2)):
        with Bench.build(files, engine="builtin", dialect=dialect) as bench:
            bench.scan()
            assert bench["Main.D"] == value
    with using("tia"), Bench.build(files, engine="builtin") as bench:
        bench.scan()
        assert bench["Main.D"] == 2000
    assert dialect_of(files) == "iec"


def test_auto_does_not_take_matiec_for_another_dialect_and_says_why(
    files_of: Callable[..., list[Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Engine auto does not use matiec for the dialect of another tool.

    Source: docs/reference/language.md, dialects.
    """
    monkeypatch.setattr("structured_text.engines.load.find_matiec", lambda: "an installation")
    plain = files_of("PROGRAM Main VAR A : INT; END_VAR A := 1; END_PROGRAM")
    built = build_on([in_dialect(file, "twincat") for file in plain])
    assert built.program.engine == "builtin"
    assert built.notice == (
        "matiec does not compute in the dialect twincat: running on the built-in engine"
    )
    built = build_on(files_of(_TASKS.format("1s")))
    assert built.program.engine == "builtin"
    assert "matiec runs F, which has no task, only at the pace of the tasks" in built.notice


# --- a second reading of the arithmetic -------------------------------------------------------

_SHORT = {"A": "INT", "B": "SINT", "C": "UINT", "D": "USINT", "W": "BYTE", "V": "WORD"}
_RANGES = {
    "INT": (-32768, 32767),
    "SINT": (-128, 127),
    "UINT": (0, 65535),
    "USINT": (0, 255),
    "BYTE": (0, 255),
    "WORD": (0, 65535),
}


def _expression(draw: random.Random, depth: int, given: dict[str, int]) -> tuple[str, int]:
    """Return a random calculation and its value in 32 bits, by the rule of CODESYS."""
    if depth == 0 or draw.random() < 0.2:
        name = draw.choice([*_SHORT, "7", "300"])
        return name, given.get(name, 0) if name in _SHORT else int(name)
    left, a = _expression(draw, depth - 1, given)
    op = draw.choice("+-*/M")
    if op in "/M":
        divisor = draw.choice((2, 3, 100))
        quotient = abs(a) // divisor * (1 if a >= 0 else -1)
        value = quotient if op == "/" else a - quotient * divisor
        return f"({left} {'MOD' if op == 'M' else op} {divisor})", value
    right, b = _expression(draw, depth - 1, given)
    value = {"+": a + b, "-": a - b, "*": a * b}[op]
    return f"({left} {op} {right})", _wrapped(value, 32)


def _wrapped(value: int, bits: int) -> int:
    half = 1 << bits - 1
    return (value + half) % (1 << bits) - half


@pytest.mark.exhaustive
@pytest.mark.parametrize("dialect", ["codesys", "twincat", "logix"])
def test_random_calculations_of_short_integers_have_32_bits(speak: Build, dialect: str) -> None:
    """Random calculations of SINT and INT give the values of 32-bit arithmetic in CODESYS.

    Source: CODESYS help, operators, overflow in the data type.
    """
    draw = random.Random(47)
    for _ in range(40):
        given = {name: draw.randint(*_RANGES[kind]) for name, kind in _SHORT.items()}
        rows = [_expression(draw, 3, given) for _ in range(30)]
        rows = [(text, value) for text, value in rows if any(name in text for name in _SHORT)]
        declared = "".join(
            f"{name} : {kind} := {given[name]};" for name, kind in _SHORT.items()
        ) + "".join(f"D{k}, Cut{k} : DINT; L{k} : BOOL; S{k} : INT;" for k in range(len(rows)))
        body = "".join(
            f"D{k} := {text}; L{k} := {text} = DINT#{value}; S{k} := DINT_TO_INT(D{k});\n"
            if value >= 0
            else f"D{k} := {text}; L{k} := {text} < 0;\n"
            for k, (text, value) in enumerate(rows)
        )
        program = speak(dialect, f"PROGRAM Main\nVAR\n{declared}\nEND_VAR\n{body}END_PROGRAM")
        program.scan(0)
        for k, (text, value) in enumerate(rows):
            assert program.read(f"Main.D{k}") == value, (text, given)
            assert program.read(f"Main.L{k}") is True, (text, given)
