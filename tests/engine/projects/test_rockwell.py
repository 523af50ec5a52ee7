"""An L5X project behaves as in a Logix controller: timers, operators, and initial values."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cell.sources import source_files
from structured_text.engines.base import Program
from structured_text.engines.load import Built, build

_L5X = """\
<RSLogix5000Content><Controller Name="C">
<AddOnInstructionDefinitions><AddOnInstructionDefinition Name="Scale"><Parameters>
<Parameter Name="EnableIn" DataType="BOOL" Usage="Input" Required="false"/>
<Parameter Name="Raw" DataType="DINT" Usage="Input" Required="true"/>
<Parameter Name="Factor" DataType="DINT" Usage="Input" Required="false"><DefaultData
 Format="Decorated"><DataValue DataType="DINT" Value="3"/></DefaultData></Parameter>
<Parameter Name="Offset" DataType="DINT" Usage="Input" Required="false"/>
<Parameter Name="Value" DataType="DINT" Usage="Output" Required="false"/>
</Parameters><LocalTags><LocalTag Name="Sum" DataType="DINT"/></LocalTags><Routines>
<Routine Name="Logic" Type="ST"><STContent>
<Line Number="0"><![CDATA[Value := Raw * Factor + Offset;]]></Line>
</STContent></Routine><Routine Name="Prescan" Type="ST"><STContent>
<Line Number="0"><![CDATA[Value := 0;]]></Line>
</STContent></Routine></Routines></AddOnInstructionDefinition></AddOnInstructionDefinitions>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>{tags}</Tags>
<Routines><Routine Name="Main" Type="ST"><STContent>
<Line Number="0"><![CDATA[{code}]]></Line>
</STContent></Routine></Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""


def _tag(name: str, kind: str, **members: int) -> str:
    values = "".join(
        f'<DataValueMember Name="{key}" DataType="DINT" Value="{value}"/>'
        for key, value in members.items()
    )
    data = f'<Data Format="Decorated"><Structure DataType="{kind}">{values}</Structure></Data>'
    return f'<Tag Name="{name}" TagType="Base" DataType="{kind}">{data if members else ""}</Tag>'


def _built(folder: Path, code: str, *tags: str) -> Built:
    file = folder / "cell.L5X"
    file.write_text(_L5X.format(code=code, tags="".join(tags)), encoding="utf-8")
    return build(list(source_files([file], None).all), "builtin")


def _program(folder: Path, code: str, *tags: str) -> Program:
    return _built(folder, code, *tags).program


def _timer(folder: Path, preset: int, *, accumulated: int = 0) -> Program:
    timer = _tag("T", "FBD_TIMER", EnableIn=1, TimerEnable=1, PRE=preset, ACC=accumulated)
    return _program(folder, "TONR(T);", timer)


def test_tonr_counts_whole_milliseconds_and_loses_no_part_of_one(tmp_path: Path) -> None:
    """With a call every 0.4 ms, a TONR of 5 ms is done at 5.2 ms, the first call after 5 ms.

    Source: Rockwell 1756-RM003, TONR: the accumulator has units of 1 ms; DN is set when ACC is
    greater than or equal to PRE.
    """
    program = _timer(tmp_path, 5)
    seen = []
    for scan in range(15):
        program.scan(scan * 400)
        seen.append(tuple(program.read(f"Main.T.{pin}") for pin in ("ACC", "TT", "DN")))
    counted = [0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5, 5]
    assert [one[0] for one in seen] == counted
    assert [one[1:] for one in seen] == [(True, False)] * 13 + [(False, True)] * 2


def test_tonr_adds_all_the_time_since_its_last_call(tmp_path: Path) -> None:
    """ACC increases by the time since the last call.

    Source: Rockwell 1756-RM003, timers: ACC = ACC + (current_time - last_time).
    """
    program = _timer(tmp_path, 1000)
    program.scan(0)
    program.scan(1_734_000)
    assert program.read("Main.T.ACC") == 1734
    program.write("Main.T.TimerEnable", False)
    program.scan(1_740_000)
    assert [program.read(f"Main.T.{pin}") for pin in ("ACC", "EN", "DN")] == [0, False, False]


def test_the_first_call_of_tonr_clears_its_time(tmp_path: Path) -> None:
    """At its first call, TONR sets ACC to 0. Source: Rockwell 1756-RM003, TONR, first run."""
    program = _timer(tmp_path, 100, accumulated=90)
    program.scan(0)
    assert program.read("Main.T.ACC") == 0
    program.scan(20_000)
    assert [program.read(f"Main.T.{pin}") for pin in ("ACC", "DN")] == [20, False]


def test_tonr_with_a_negative_preset_does_not_run(tmp_path: Path) -> None:
    """A negative preset sets PresetInv and stops the timer.

    Source: Rockwell 1756-RM003, TONR: PRE, Status.0 InstructFault, Status.1 PresetInv.
    """
    program = _timer(tmp_path, -1)
    program.scan(0)
    program.scan(20_000)
    assert [program.read(f"Main.T.{pin}") for pin in ("ACC", "EN", "DN")] == [0, False, False]
    assert [program.read(f"Main.T.{pin}") for pin in ("PresetInv", "Status")] == [True, 3]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("-2 ** 2", -4),
        ("2 ** 3 ** 2", 64),
        ("2 ** -1 * 8", 4),
        ("-b ** 2 + 1", -8),
        ("10 - -2 * 3", 16),
    ],
)
def test_the_power_comes_before_the_sign(tmp_path: Path, expression: str, value: int) -> None:
    """`**` comes before the minus sign. Source: Rockwell 1756-PM007, order of execution."""
    tags = '<Tag Name="a" DataType="DINT"/><Tag Name="b" DataType="DINT"/>'
    program = _program(tmp_path, f"b := 3; a := {expression};", tags)
    program.scan(0)
    assert program.read("Main.a") == value


def test_an_instance_begins_with_the_values_of_its_tag(tmp_path: Path) -> None:
    """An input that a call omits has the value of the instance's tag, even if this value is 0.

    Source: Rockwell 1756-PM010, parameters: the value of a parameter that is not required is that
    of the instance's tag.
    """
    tags = [
        _tag("Plain", "Scale", EnableIn=1, Raw=0, Factor=3, Offset=0),
        _tag("Other", "Scale", EnableIn=1, Raw=0, Factor=0, Offset=7),
        _tag("Empty", "Scale"),
    ]
    code = "Scale(Plain, 2); Scale(Other, 2); Scale(Empty, 2);"
    program = _program(tmp_path, code, *tags)
    program.scan(0)
    values = [program.read(f"Main.{one}.Value") for one in ("Plain", "Other", "Empty")]
    assert values == [6, 7, 6]


def test_the_largest_real_is_read_as_tools_write_it(tmp_path: Path) -> None:
    """3.40282347E38, which is slightly above the largest REAL, is rounded down to it.

    Source: IEEE 754, rounding to nearest: the largest single is 16#7F7FFFFF, (2 - 2^-23) * 2^127.
    """
    data = '<Data Format="Decorated"><DataValue DataType="REAL" Value="3.40282347e+038"/></Data>'
    tags = f'<Tag Name="a" DataType="REAL"/><Tag Name="b" DataType="REAL">{data}</Tag>'
    program = _program(tmp_path, "a := -3.40282347E+38;", tags)
    program.scan(0)
    largest = (2 - 2.0**-23) * 2.0**127
    assert [program.read(f"Main.{one}") for one in "ab"] == [-largest, largest]
    program.write("Main.b", -3.40282347e38)
    assert program.read("Main.b") == -largest


def test_tags_that_no_prescan_sets_keep_their_values_without_power(tmp_path: Path) -> None:
    """Tags keep their values without power, except those that the Prescan routine sets.

    The areas are tags of a module, so they are not kept. A timer restarts with its preset.

    Source: Rockwell 1756-PM010, Prescan routine: it initialises values that were kept.
    """
    tags = [_tag("One", "Scale"), _tag("T", "FBD_TIMER", PRE=3), '<Tag Name="a" DataType="DINT"/>']
    tags.append('<Tag Name="OutputArea" DataType="SINT" Dimensions="512"/>')
    kept = set(_built(tmp_path, "Scale(One, a); TONR(T);", *tags).retained)
    scale = {f"P.One.{name}" for name in ("Raw", "Factor", "Offset", "Sum")}
    timer = {f"P.T.{name}" for name in ("EnableIn", "TimerEnable", "Reset", "PRE")}
    assert kept == {"P.a"} | scale | timer


def test_an_alias_of_an_instruction_is_its_local_tag(tmp_path: Path) -> None:
    """An alias parameter is the local tag: inputs are copied before the logic, outputs after it."""
    file = tmp_path / "cell.L5X"
    text = (
        _L5X.replace(
            "</Parameters>",
            '<Parameter Name="In" TagType="Alias" AliasFor="Sum" Usage="Input" Required="true"/>'
            '<Parameter Name="Out" TagType="Alias" AliasFor="Last" Usage="Output"/>'
            "</Parameters>",
        )
        .replace(
            'DataType="DINT"/></LocalTags>',
            'DataType="DINT"/><LocalTag Name="Last" DataType="DINT"/></LocalTags>',
        )
        .replace("Value := Raw * Factor + Offset;", "Last := Sum + 1;")
    )
    tags = _tag("S", "Scale") + '<Tag Name="R" TagType="Base" DataType="DINT"/>'
    file.write_text(text.format(code="Scale(S, 1, 41); R := S.Out;", tags=tags), encoding="utf-8")
    program = build(list(source_files([file], None).all), "builtin").program
    program.scan(0)
    assert program.read("Main.R") == 42
