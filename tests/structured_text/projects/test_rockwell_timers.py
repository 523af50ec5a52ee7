"""Timers, counters, one-shots and the prescan of ladder routines in an L5X.

Expected values are read from the drawn rungs and from Rockwell 1756-RM003N, pages 103 to 153.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import main_body, program, read, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_TIMERS = {"tm": "TIMER", "many": "TIMER[3]", "cnt": "COUNTER", "ctl": "CONTROL"}


def _program(folder: Path, *rungs: str, **values: object) -> BuiltinProgram:
    """Return a program; the values are set after the first scan, in which `a` is FALSE."""
    running = program(written(folder, rungs, tags=_TIMERS))
    for name, value in values.items():
        running.write(f"Main.{name.replace('_', '.')}", value)
    return running


def _bits(running: BuiltinProgram, tag: str, *names: str) -> list[object]:
    return [running.read(f"Main.{tag}.{name}") for name in names]


def _steps(
    running: BuiltinProgram, steps: list[tuple[int, bool]], *names: str, tag: str = "tm"
) -> list[list[object]]:
    """Return the members after scans at some milliseconds, with the power of `a`."""
    found = []
    for at, power in steps:
        running.write("Main.a", power)
        running.scan(at * 1000)
        found.append(_bits(running, tag, *names))
    return found


def test_ton_times_while_it_has_power(tmp_path: Path) -> None:
    """It begins at 10 ms, is done at 60 ms with 50 ms, and is cleared without power.

    Source: 1756-RM003N, page 118.
    """
    running = _program(tmp_path, "XIC(a)TON(tm,?,?);", tm_PRE=50)
    steps = [(0, False), (10, True), (30, True), (59, True), (60, True), (80, True), (90, False)]
    assert _steps(running, steps, "EN", "TT", "DN", "ACC") == [
        [False, False, False, 0],
        [True, True, False, 0],
        [True, True, False, 20],
        [True, True, False, 49],
        [True, False, True, 50],
        [True, False, True, 50],
        [False, False, False, 0],
    ]


def test_a_timer_counts_whole_milliseconds(tmp_path: Path) -> None:
    """With 0.4 ms for each scan, ACC is the whole milliseconds since the first scan."""
    running = _program(tmp_path, "TON(tm,?,?);", tm_PRE=5)
    seen = []
    for scan in range(15):
        running.scan(scan * 400)
        seen.append(running.read("Main.tm.ACC"))
    assert seen == [0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5, 5]


def test_a_timer_counts_the_time_since_its_last_execution(tmp_path: Path) -> None:
    """A routine that is not called for 500 ms: the next execution adds them all.

    Source: 1756-RM003N, timers: ACC = ACC + (current_time - last_time).
    """
    routines = {"Sub": ["XIC(b)TON(tm,?,?);"]}
    file = written(tmp_path, ["XIC(a)JSR(Sub,0);"], tags=_TIMERS, routines=routines)
    running = program(file)
    running.write("Main.tm.PRE", 1000)
    running.write("Main.b", True)
    seen = _steps(running, [(0, True), (20, True), (270, False), (520, True)], "ACC", "DN")
    assert seen == [[0, False], [20, False], [20, False], [520, False]]


def test_tof_times_after_the_power(tmp_path: Path) -> None:
    """DN is TRUE with power, and 30 ms longer. TT is TRUE only while it times (assumed).

    Source: 1756-RM003N, page 122.
    """
    running = _program(tmp_path, "XIC(a)TOF(tm,?,?);", tm_PRE=30)
    steps = [(0, False), (10, True), (20, True), (40, False), (69, False), (70, False), (80, True)]
    assert _steps(running, steps, "EN", "TT", "DN", "ACC") == [
        [False, False, False, 30],
        [True, False, True, 0],
        [True, False, True, 0],
        [False, True, True, 0],
        [False, True, True, 29],
        [False, False, False, 30],
        [True, False, True, 0],
    ]


def test_rto_keeps_its_time_until_res(tmp_path: Path) -> None:
    """It times 20 ms, pauses, is done after 10 ms more, and stays done until RES.

    Source: 1756-RM003N, pages 127 and 153.
    """
    running = _program(tmp_path, "XIC(a)RTO(tm,?,?);", "XIC(b)RES(tm);", tm_PRE=30)
    steps = [(0, True), (20, True), (25, False), (90, True), (100, True), (110, False)]
    assert _steps(running, steps, "EN", "TT", "DN", "ACC") == [
        [True, True, False, 0],
        [True, True, False, 20],
        [False, False, False, 20],
        [True, True, False, 20],
        [True, False, True, 30],
        [False, False, True, 30],
    ]
    running.write("Main.b", True)
    running.scan(120_000)
    assert _bits(running, "tm", "EN", "TT", "DN", "ACC", "PRE") == [False, False, False, 0, 30]


def test_each_element_of_an_array_has_its_own_time(tmp_path: Path) -> None:
    """The index alternates between 0 and 1; each timer counts from its own last execution."""
    running = _program(tmp_path, "TON(many[i],?,?);")
    for number in (0, 1):
        running.write(f"Main.many[{number}].PRE", 1000)
    for scan, number in enumerate((0, 1, 0, 1, 1)):
        running.write("Main.i", number)
        running.scan(scan * 10_000)
    assert [running.read(f"Main.many[{number}].ACC") for number in (0, 1)] == [20, 30]


@pytest.mark.parametrize("name", ["TON", "TOF", "RTO"])
def test_a_negative_preset_does_not_run_a_timer(tmp_path: Path, name: str) -> None:
    """On the controller it is a major fault. Here the timer does not run.

    Source: 1756-RM003N, pages 116, 120 and 125, fault 4:34.
    """
    running = _program(tmp_path, f"XIC(a){name}(tm,?,?);", tm_PRE=-5)
    assert _steps(running, [(0, True), (10, False), (20, True)], "TT")[1:] == [[False], [False]]


def test_ctu_counts_rising_edges(tmp_path: Path) -> None:
    """DN is TRUE from 2 on; it counts on. Source: 1756-RM003N, page 143."""
    running = _program(tmp_path, "XIC(a)CTU(cnt,?,?);", cnt_PRE=2)
    powers = [False, True, True, False, True, False, True]
    steps = [(10 * at, power) for at, power in enumerate(powers)]
    assert _steps(running, steps, "CU", "DN", "ACC", tag="cnt") == [
        [False, False, 0],
        [True, False, 1],
        [True, False, 1],
        [False, False, 1],
        [True, True, 2],
        [False, True, 2],
        [True, True, 3],
    ]


def test_power_in_the_first_scan_is_not_counted(tmp_path: Path) -> None:
    """The prescan sets CU and CD. Source: 1756-RM003N, pages 143 and 147, prescan."""
    running = _program(tmp_path, "XIC(a)CTU(cnt,?,?);", "XIC(a)CTD(cnt,?,?);")
    assert _steps(running, [(0, True), (10, True)], "ACC", "CU", "CD", tag="cnt") == [
        [0, True, True],
        [0, True, True],
    ]


def test_a_counter_beyond_its_limits(tmp_path: Path) -> None:
    """Up from the largest DINT sets OV and keeps DN; down again clears OV.

    Source: 1756-RM003N, pages 143 and 147: the examination of OV and UN.
    """
    running = _program(tmp_path, "XIC(a)CTU(cnt,?,?);", "XIC(b)CTD(cnt,?,?);", cnt_PRE=5)
    names = ("ACC", "OV", "UN", "DN")
    running.scan(0)
    running.write("Main.cnt.ACC", 2147483647)
    assert _steps(running, [(10, True)], *names, tag="cnt") == [[-2147483648, True, False, True]]
    running.write("Main.b", True)
    assert _steps(running, [(20, False)], *names, tag="cnt") == [[2147483647, False, False, True]]
    running.write("Main.b", False)
    running.scan(30_000)
    running.write("Main.cnt.ACC", -2147483648)
    running.write("Main.b", True)
    assert _steps(running, [(40, False)], *names, tag="cnt") == [[2147483647, False, True, False]]
    assert _steps(running, [(50, True)], *names, tag="cnt") == [[-2147483648, False, False, False]]


def test_res_clears_a_counter_and_a_control(tmp_path: Path) -> None:
    """PRE and LEN stay. Source: 1756-RM003N, page 153."""
    running = _program(
        tmp_path, "XIC(a)RES(cnt);", "XIC(a)RES(ctl);", cnt_PRE=2, cnt_ACC=7, ctl_LEN=4
    )
    for name in ("cnt.DN", "cnt.OV", "ctl.EN", "ctl.DN"):
        running.write(f"Main.{name}", True)
    running.write("Main.ctl.POS", 3)
    running.write("Main.a", True)
    running.scan(0)
    assert _bits(running, "cnt", "ACC", "PRE", "DN", "OV") == [0, 2, False, False]
    assert _bits(running, "ctl", "POS", "LEN", "EN", "DN") == [0, 4, False, False]


def test_osr_and_osf_set_their_output_for_one_scan(tmp_path: Path) -> None:
    """OSR at the rising edge, OSF at the falling edge; neither in the first scan.

    Source: Rockwell, Studio 5000 help, OSR and OSF.
    """
    running = _program(tmp_path, "XIC(a)OSR(b,c);", "XIC(a)OSF(d,e);")
    seen = []
    for scan, power in enumerate([True, True, False, False, True, True, False]):
        running.write("Main.a", power)
        running.scan(scan * 10_000)
        seen.append((running.read("Main.c"), running.read("Main.e")))
    assert seen == [
        (False, False),
        (False, False),
        (False, True),
        (False, False),
        (True, False),
        (False, False),
        (False, True),
    ]


def test_the_first_scan_is_no_edge_for_ons(tmp_path: Path) -> None:
    """The prescan sets the storage bit. Source: 1756-RM003N, page 103."""
    running = _program(tmp_path, "XIC(a)ONS(b)ADD(i,1,i);")
    seen = []
    for scan, power in enumerate([True, True, False, True]):
        running.write("Main.a", power)
        running.scan(scan * 10_000)
        seen.append(running.read("Main.i"))
    assert seen == [0, 0, 0, 1]


def test_the_prescan_clears_coils_and_timers_but_not_latches(tmp_path: Path) -> None:
    """OTE bits are FALSE, TON is cleared, TOF has ACC = PRE, RTO keeps ACC, OTL keeps its bit.

    The rungs are never executed, because the routine has no power. Source: 1756-RM003N, prescan.
    """
    rungs = ["OTE(b);", "OTL(c);", "TON(tm,?,?);", "TOF(many[0],?,?);", "RTO(many[1],?,?);"]
    file = written(
        tmp_path, ["XIC(a)JSR(Sub,0);"], tags=_TIMERS, routines={"Sub": rungs, "Other": ["OTE(d);"]}
    )
    running = program(file)
    for name in ("b", "c", "d", "tm.DN", "tm.EN", "many[0].DN", "many[1].DN", "many[1].EN"):
        running.write(f"Main.{name}", True)
    for name, value in (("tm.ACC", 9), ("many[0].PRE", 70), ("many[1].ACC", 8)):
        running.write(f"Main.{name}", value)
    running.scan(0)
    assert [running.read(f"Main.{name}") for name in "bcd"] == [False, True, True]
    assert _bits(running, "tm", "EN", "DN", "ACC") == [False, False, 0]
    assert _bits(running, "many[0]", "DN", "ACC") == [False, 70]
    assert _bits(running, "many[1]", "EN", "DN", "ACC") == [False, False, 8]


def test_an_index_outside_its_array_is_left_out_of_the_prescan(tmp_path: Path) -> None:
    """The prescan ignores such an index, and the first scan gives it a value before its use."""
    running = _program(tmp_path, "MOV(2,i);", "XIC(a)OTE(bits[i]);", i=77)
    running.scan(0)
    assert running.read("Main.bits[2]") is False


def test_the_prescan_comes_before_the_first_scan_of_all_programs(tmp_path: Path) -> None:
    """Program P sets `Shared` in its first scan; the prescan of program Q does not clear it."""
    file = written(tmp_path, ["OTL(Shared);"])
    text = file.read_text(encoding="utf-8")
    second = (
        '<Program Name="Q" MainRoutineName="Main"><Tags><Tag Name="own" DataType="BOOL"/></Tags>'
        '<Routines><Routine Name="Main" Type="RLL"><RLLContent><Rung Number="0" Type="N"><Text>'
        '<![CDATA[XIC(Shared)OTE(own);]]></Text></Rung><Rung Number="1" Type="N"><Text>'
        "<![CDATA[JSR(Late,0);]]></Text></Rung></RLLContent></Routine>"
        '<Routine Name="Late" Type="RLL"><RLLContent><Rung Number="0" Type="N"><Text>'
        '<![CDATA[JMP(X)OTE(Shared);]]></Text></Rung><Rung Number="1" Type="N"><Text>'
        "<![CDATA[LBL(X)NOP();]]></Text></Rung></RLLContent></Routine></Routines></Program>"
    )
    text = text.replace("<Programs>", '<Tags><Tag Name="Shared" DataType="BOOL"/></Tags><Programs>')
    text = text.replace("</Programs>", f"{second}</Programs>")
    text = text.replace(
        '<ScheduledProgram Name="P"/>',
        '<ScheduledProgram Name="P"/><ScheduledProgram Name="Q"/>',
    )
    file.write_text(text, encoding="utf-8")
    running = program(file)
    running.scan(0)
    assert running.read("Q.own") is True


def test_a_timer_that_is_not_a_timer_is_named(tmp_path: Path) -> None:
    """The message names the rung and the tag."""
    body = main_body(written(tmp_path, ["NOP();", "TON(cnt,?,?);"], tags=_TIMERS))
    assert isinstance(body, Foreign)
    assert "rung 1: cnt is not a TIMER" in body.why


def test_only_functions_that_are_used_are_declared(tmp_path: Path) -> None:
    """A project with a CTU has no timers."""
    names = {unit.name for unit in read(written(tmp_path, ["CTU(cnt,?,?);"], tags=_TIMERS)).units}
    assert {"L5X_CTU", "COUNTER"} <= names
    assert not {"L5X_TON", "L5X_TIMED"} & names


def test_osf_is_not_triggered_by_the_first_scan(tmp_path: Path) -> None:
    """The storage bit was TRUE; the prescan clears it. Source: Studio 5000 help, OSF, prescan."""
    running = _program(tmp_path, "XIC(a)OSF(d,e);", d=True)
    running.scan(0)
    assert running.read("Main.e") is False


def test_presets_of_an_array_of_timers_are_read(tmp_path: Path) -> None:
    """The values of the array give the timers 0 and 2 their presets."""
    file = written(tmp_path, ["TON(many[2],?,?);"], tags=_TIMERS)
    values = "".join(
        f'<Element Index="[{number}]"><Structure DataType="TIMER">'
        f'<DataValueMember Name="PRE" DataType="DINT" Value="{value}"/></Structure></Element>'
        for number, value in enumerate((700, 0, 30))
    )
    data = (
        f'<Data Format="Decorated"><Array DataType="TIMER" Dimensions="3">{values}</Array></Data>'
    )
    text = file.read_text(encoding="utf-8")
    old = 'DataType="TIMER" Dimensions="3"/>'
    assert old in text
    file.write_text(text.replace(old, f"{old[:-2]}>{data}</Tag>"), encoding="utf-8")
    running = program(file)
    assert [running.read(f"Main.many[{number}].PRE") for number in range(3)] == [700, 0, 30]


def test_values_of_an_array_with_two_dimensions_are_read(tmp_path: Path) -> None:
    """The last index varies first, as in the file."""
    file = written(tmp_path, ["NOP();"], tags={"grid": "DINT[2 3]"})
    values = "".join(
        f'<Element Index="[{row},{column}]" Value="{10 * row + column}"/>'
        for row in range(2)
        for column in range(3)
    )
    data = f'<Data Format="Decorated"><Array DataType="DINT">{values}</Array></Data>'
    text = file.read_text(encoding="utf-8")
    old = 'Dimensions="2 3"/>'
    assert old in text
    file.write_text(text.replace(old, f"{old[:-2]}>{data}</Tag>"), encoding="utf-8")
    running = program(file)
    cells = [running.read(f"Main.grid[{row},{column}]") for row in range(2) for column in range(3)]
    assert cells == [0, 1, 2, 10, 11, 12]


def test_a_preset_that_a_rung_shows_is_the_value_of_a_tag_without_data(tmp_path: Path) -> None:
    """The tag has no data, so the timer is done after the 30 ms of the rung (assumed)."""
    running = _program(tmp_path, "XIC(a)TON(tm,30,?);", "XIC(a)CTU(cnt,4,0);")
    assert running.read("Main.cnt.PRE") == 4
    assert _steps(running, [(0, True), (29, True), (30, True)], "DN") == [[False], [False], [True]]


def test_another_preset_in_the_data_is_noted(tmp_path: Path) -> None:
    """The data of the tag decide; a note names both numbers."""
    file = written(tmp_path, ["TON(tm,30,?);"], tags={"tm": "TIMER"})
    data = (
        '<Data Format="Decorated"><Structure DataType="TIMER"><DataValueMember Name="PRE"'
        ' DataType="DINT" Value="16#0000_0032"/></Structure></Data></Tag>'
    )
    text = file.read_text(encoding="utf-8")
    old = 'Name="tm" TagType="Base" DataType="TIMER"/>'
    assert old in text
    file.write_text(text.replace(old, f"{old[:-2]}>{data}"), encoding="utf-8")
    assert program(file).read("Main.tm.PRE") == 50
    notes = [note.partition(": ")[2] for note in read(file).notes]
    assert notes == ["the preset of tm is 50, as its data say; a rung shows 30"]


def test_a_preset_of_an_element_without_data_is_noted(tmp_path: Path) -> None:
    """An array without data has the preset 0, and a note says so."""
    notes = read(written(tmp_path, ["TON(many[1],30,?);"], tags={"many": "TIMER[3]"})).notes
    assert "many[1] has no data, so its preset is 0, and not 30 as a rung shows" in notes[0]


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        ("DINT", "16#ffff_fffe", -2),
        ("INT", "2#1000_0000_0000_0000", -32768),
        ("SINT", "16#7f", 127),
    ],
)
def test_a_hexadecimal_value_is_a_bit_pattern(
    tmp_path: Path, kind: str, text: str, value: int
) -> None:
    """The highest bit of a signed type is its sign."""
    file = written(tmp_path, ["NOP();"], tags={"n": kind})
    old = f'Name="n" TagType="Base" DataType="{kind}"/>'
    data = f'<Data Format="Decorated"><DataValue DataType="{kind}" Value="{text}"/></Data></Tag>'
    content = file.read_text(encoding="utf-8")
    assert old in content
    file.write_text(content.replace(old, f"{old[:-2]}>{data}"), encoding="utf-8")
    assert program(file).read("Main.n") == value
