"""FB_PointBackup sends requests, stores the answers, and can be interrupted and continued."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from points_bench import PointsBench, points_bench

#: Point 50 of the manual, as words n+2, n+6 to n+30: 10.000, -20.000, 5.000, -18.000 mm.
POINT_50 = [1, 0, 0x2710, 0, 0xB1E0, 0xFFFF, 0x1388, 0, 0xB9B0, 0xFFFF, 0, 0, 0, 0]
ROW_50 = (True, 1, [10_000, -20_000, 5_000, -18_000, 0, 0])
EMPTY = (False, 0, [0] * 6)
#: "WAIT ORG", and the words of sixteen characters after it.
WAIT_ORG = [0, 0, 0x4157, 0x5449, 0x4F20, 0x4752]
_SPACES = 0x20202020


@pytest.fixture(params=ENGINES)
def plc(request: pytest.FixtureRequest) -> PointsBench:
    return points_bench(request.param)


def _wide(words: list[int]) -> list[int]:
    return [*words, *[0] * (14 - len(words))]


def test_a_range_of_points_comes_row_by_row_those_that_are_missing_as_empty_rows(
    plc: PointsBench,
) -> None:
    """Source: guide 4.3.1, the example of the reference: point 50."""
    plc.stored[0x100, 50] = POINT_50
    assert plc.run("Backup", First=49, Count=3) == 0
    assert [plc.row(k) for k in (1, 2, 3)] == [EMPTY, ROW_50, EMPTY]
    assert plc.sent == [[0x101, 0, number, *[0] * 13] for number in (49, 50, 51)]
    head = plc["Head"]
    assert isinstance(head, dict)
    assert (head["Kind"], head["First"], head["Count"]) == ("DATA_POINTS", 49, 3)
    assert plc["Backup.Number"] == 52
    assert (plc["Backup.AlarmGroup"], plc["Backup.AlarmCategory"]) == (0, 0)


@pytest.mark.parametrize(
    ("kind", "robot", "code", "number", "words", "values"),
    [
        ("POINTS", 0, 0x100, 50, POINT_50, ROW_50[2]),
        ("COMMENTS", 0, 0x104, 50, WAIT_ORG, [0x54494157, 0x47524F20, _SPACES, _SPACES, 0, 0]),
        ("SHIFTS", 0, 0x10C, 5, [0, 0, *POINT_50[2:10]], ROW_50[2]),
        ("HANDS", 0, 0x110, 1, [0, 0, 0x2710, 0, 0xF830, 0xFFFF, 0x1388], [10000, -2000, 5000]),
        ("HANDS", 2, 0x2110, 31, [0, 0, 0x0064, 0, 1, 0, 2, 0, 1], [100, 1, 2, 1]),
        ("PALLETS", 0, 0x108, 10, [0, 10, 15, 1, 100], [10, 15, 1, 100]),
    ],
)
def test_each_kind_of_data_has_its_command_and_its_values(
    plc: PointsBench,
    kind: str,
    robot: int,
    code: int,
    number: int,
    words: list[int],
    values: list[int],
) -> None:
    """Each kind of data has its command, and its values in a row.

    Source: guide 4.3.1 to 4.3.5, examples; the definition of comments fills them with spaces.
    """
    plc.stored[code, number] = _wide(words)
    assert plc.run("Backup", Kind=f"DATA_{kind}", RobotNumber=robot, First=number, Count=1) == 0
    flag = words[0] if kind == "POINTS" else 0
    assert plc.row(1) == (True, flag, [*values, *[0] * (6 - len(values))])
    assert plc.sent == [[code | 1, 0, number, *[0] * 13]]


@pytest.mark.parametrize(
    ("words", "values"),
    [
        ([0x0041, 0x4242], [0x20202041, _SPACES]),  # the comment ends in a lower byte
        ([0x4241, 0x4400], [0x20204241, _SPACES]),  # the comment ends before a lower byte
        ([0x2020, 0x4241], [0x42412020, _SPACES]),
        ([0x0000, 0x4241], [_SPACES, _SPACES]),
        ([0x4100, 0x4242], [_SPACES, _SPACES]),
        ([0x4241, 0x0043, 0x4444], [0x20434241, _SPACES]),  # the comment ends in a later word
        ([0x00B1, 0x4242], [0x202020B1, _SPACES]),  # a character above 16#7F
    ],
)
def test_a_comment_ends_before_its_first_zero(
    plc: PointsBench, words: list[int], values: list[int]
) -> None:
    """The block replaces the characters after the first zero by spaces.

    Source: guide 4.3.2, which does not define them; FB_WritePointComment sends spaces.
    """
    plc.stored[0x104, 7] = _wide([0, 0, *words])
    assert plc.run("Backup", Kind="DATA_COMMENTS", First=7, Count=1) == 0
    assert plc.row(1) == (True, 0, [*values, _SPACES, _SPACES, 0, 0])


@pytest.mark.parametrize(
    ("kind", "code"), [("SHIFTS", 0x10C), ("HANDS", 0x110), ("PALLETS", 0x108)]
)
def test_words_after_the_data_are_not_values(plc: PointsBench, kind: str, code: int) -> None:
    """Source: guide 4.3.3 to 4.3.5: pallets, shifts and hands have four values each."""
    plc.stored[code, 5] = [0, *range(1, 14)]
    assert plc.run("Backup", Kind=f"DATA_{kind}", First=5, Count=1) == 0
    assert plc.row(1)[2][4:] == [0, 0]
    assert all(plc.row(1)[2][:3])


def test_the_alarm_for_a_missing_point_ends_a_backup_of_shifts(
    plc: PointsBench,
) -> None:
    """The alarm for a missing point (6.204) has no meaning for shifts: it ends the block."""
    assert plc.run("Backup", First=5, Count=1) == 0
    assert plc.row(1) == EMPTY
    plc.refuses[5] = (6, 204)
    assert plc.run("Backup", Kind="DATA_SHIFTS", First=5, Count=1) == 0x8020


def test_after_a_refused_range_the_next_range_is_accepted(plc: PointsBench) -> None:
    assert plc.run("Backup", most=1, First=-1) == 0x8044
    assert plc.run("Backup", most=1, RobotNumber=5, First=0) == 0x8040
    assert plc.run("Backup", RobotNumber=0, First=0, Count=2) == 0
    assert [words[2] for words in plc.sent] == [0, 1]


@pytest.mark.parametrize("sizes", [(0, 1, 1), (1, 0, 1), (1, 1, 0)])
def test_a_pallet_without_positions_is_not_defined(
    plc: PointsBench, sizes: tuple[int, ...]
) -> None:
    """Source: guide 4.3.3: Nx * Ny * Nz is 1 to 32767."""
    plc.stored[0x108, 3] = _wide([0, *sizes, 20])
    assert plc.run("Backup", Kind="DATA_PALLETS", First=3, Count=1) == 0
    assert plc.row(1) == EMPTY


def test_a_pallet_whose_first_point_is_0_is_defined(plc: PointsBench) -> None:
    """Source: guide 4.3.3: first point 0 to 29995."""
    plc.stored[0x108, 39] = _wide([0, 1, 1, 32767, 0])
    assert plc.run("Backup", Kind="DATA_PALLETS", First=39, Count=1) == 0
    assert plc.row(1) == (True, 0, [1, 1, 32767, 0, 0, 0])


@pytest.mark.parametrize(("kind", "number"), [("COMMENTS", 12), ("PALLETS", 12)])
def test_a_missing_comment_or_pallet_is_an_empty_row(
    plc: PointsBench, kind: str, number: int
) -> None:
    """A missing comment or pallet gives an empty row.

    The alarms 6.204 and 6.236 are assumed, because the manual names none.

    Source: docs/explanation/fidelity.md, other-alarms and undefined-pallet
    """
    assert plc.run("Backup", Kind=f"DATA_{kind}", First=number, Count=1) == 0
    assert plc.row(1) == EMPTY


@pytest.mark.parametrize(
    ("kind", "alarm"),
    [
        ("POINTS", (6, 236)),
        ("POINTS", (5, 204)),
        ("POINTS", (4, 2)),
        ("PALLETS", (6, 204)),
        ("SHIFTS", (6, 204)),
        ("HANDS", (6, 0)),
    ],
)
def test_any_other_alarm_ends_the_backup_at_its_number(
    plc: PointsBench, kind: str, alarm: tuple[int, int]
) -> None:
    """Source: guide chapter 1, 1.2, code 0x4000."""
    plc.refuses[6] = alarm
    for number in (5, 7):
        for code in (0x100, 0x108, 0x10C, 0x110):
            plc.stored[code, number] = _wide([0, 1, 1, 1])
    error = plc.run("Backup", Kind=f"DATA_{kind}", First=5, Count=3)
    assert (error == 0) is (alarm == (6, 0))  # An alarm never has the category 0.
    if error:
        assert error == 0x8020
        assert plc["Backup.Number"] == 6
        assert plc["Backup.Head"]["Count"] == 1


def test_the_alarm_is_shown_as_long_as_the_error(plc: PointsBench) -> None:
    """Source: guide chapter 1, 1.2, code 0x4000; 0x0006 and 0x00FF are 6.255."""
    plc["Backup.Kind"], plc["Backup.Count"] = "DATA_SHIFTS", 1
    plc.scan_until(lambda: bool(plc["Backup.Error"]), execute="Backup")
    for _ in range(3):
        assert (plc["Backup.AlarmGroup"], plc["Backup.AlarmCategory"]) == (6, 255)
        plc.scan()
    plc.change("Backup.Execute", to=False)
    assert (plc["Backup.Error"], plc["Backup.AlarmGroup"], plc["Backup.AlarmCategory"]) == (
        *(False, 0, 0),
    )


@pytest.mark.parametrize(
    ("inputs", "error"),
    [
        ({"First": -1}, 0x8044),
        ({"First": 30_000, "Count": 1}, 0x8044),
        ({"First": 29_999, "Count": 2}, 0x8044),
        ({"Count": 0}, 0x8044),
        ({"Count": 101}, 0x8044),
        ({"Kind": "DATA_COMMENTS", "First": 29_901}, 0x8044),
        ({"Kind": "DATA_SHIFTS", "Count": 41}, 0x8044),
        ({"Kind": "DATA_PALLETS", "First": 1, "Count": 40}, 0x8044),
        ({"Kind": "DATA_HANDS", "Count": 33}, 0x8044),
        ({"Kind": "DATA_HANDS", "Count": 1, "RobotNumber": 5}, 0x8040),
        ({"Kind": "DATA_HANDS", "Count": 1, "RobotNumber": -1}, 0x8040),
    ],
)
def test_a_range_that_does_not_exist_is_refused_in_the_next_scan(
    plc: PointsBench, inputs: dict[str, Any], error: int
) -> None:
    """Source: guide 4.3: points 0 to 29999, shifts and pallets 0 to 39, hands 0 to 31, robots 4."""
    assert plc.run("Backup", most=1, **inputs) == error
    assert plc.sent == []


@pytest.mark.parametrize(
    ("inputs", "last"),
    [
        ({"First": 29_998, "Count": 2}, [0x101, 0, 29_999]),
        ({"Kind": "DATA_COMMENTS", "First": 29_999, "Count": 1}, [0x105, 0, 29_999]),
        ({"Kind": "DATA_PALLETS", "Count": 40}, [0x109, 0, 39]),
    ],
)
def test_the_highest_numbers_can_be_read(
    plc: PointsBench, inputs: dict[str, Any], last: list[int]
) -> None:
    """Source: guide 4.3.1 to 4.3.3."""
    assert plc.run("Backup", **inputs) == 0
    assert plc.sent[-1][:3] == last


def test_all_shifts_and_all_hands_fit_into_a_record(plc: PointsBench) -> None:
    """Source: guide 4.3.4 and 4.3.5."""
    for kind, code, count in (("SHIFTS", 0x10C, 40), ("HANDS", 0x4110, 32)):
        for number in range(count):
            plc.stored[code, number] = _wide([0, 0, number])
        assert plc.run("Backup", Kind=f"DATA_{kind}", First=0, Count=count, RobotNumber=4) == 0
        assert [plc.row(k + 1)[2][0] for k in range(count)] == list(range(count))


def test_resume_continues_after_the_last_row_that_was_read(plc: PointsBench) -> None:
    """After an interruption, Resume continues with the next row; the record is complete."""
    for number in range(10, 16):
        plc.stored[0x100, number] = _wide([0, 0, number])
    assert plc.run("Backup", First=10, Count=6) == 0
    whole = plc["Head"], [plc.row(k) for k in range(1, 7)]

    plc.refuses[13] = (12, 76)
    assert plc.run("Backup") == 0x8020
    assert (plc["Backup.Number"], plc["Head"]["Count"]) == (13, 3)
    plc.refuses.clear()
    plc.sent.clear()
    # the pins are not sampled after the edge
    assert plc.run("Backup", Resume=True, First=77, Count=2, Kind="DATA_SHIFTS", RobotNumber=9) == 0
    assert [words[:3] for words in plc.sent] == [[0x101, 0, n] for n in (13, 14, 15)]
    assert (plc["Head"], [plc.row(k) for k in range(1, 7)]) == whole


def test_a_complete_record_is_not_resumed(
    plc: PointsBench,
) -> None:
    """If Resume is TRUE for a complete record, the block reports 16#8069 and sends nothing.

    Rows, head and Number keep their values of the last reading.

    Source: docs/reference/errors.md, 16#8069; comment of Resume
    """
    plc.stored[0x100, 5] = POINT_50
    assert plc.run("Backup", First=5, Count=1) == 0
    kept = plc["Head"]
    plc.stored[0x100, 5] = _wide([1, 0, 7777])
    plc.sent.clear()
    for _ in range(2):
        assert plc.run("Backup", most=1, Resume=True) == 0x8069
    assert plc.sent == []
    assert (plc.row(1), plc["Head"], plc["Backup.Number"]) == (ROW_50, kept, 6)
    assert plc.run("Backup", Resume=False) == 0
    assert plc.row(1)[2][0] == 7777


def test_there_is_nothing_to_resume_before_the_first_record(plc: PointsBench) -> None:
    assert plc.run("Backup", most=1, Resume=True) == 0x8069
    assert plc.sent == []


def test_a_refused_start_leaves_the_record_that_was_begun(plc: PointsBench) -> None:
    plc.refuses[1] = (12, 76)
    assert plc.run("Backup", Count=2) == 0x8020
    assert plc.run("Backup", First=-1) == 0x8044
    plc.refuses.clear()
    assert plc.run("Backup", Resume=True, Kind="DATA_HANDS") == 0
    assert [words[:3] for words in plc.sent] == [[0x101, 0, n] for n in (0, 1, 1)]


def test_the_inputs_are_sampled_at_the_rising_edge(plc: PointsBench) -> None:
    """Source: PLCopen, edge-triggered blocks."""
    plc["Backup.First"], plc["Backup.Count"] = 20, 2
    plc.change("Backup.Execute", to=True)
    plc["Backup.First"], plc["Backup.Count"], plc["Backup.RobotNumber"] = 0, 9, 3
    plc["Backup.Kind"], plc["Backup.Resume"] = "DATA_PALLETS", True
    plc.change("Backup.Execute", to=False)
    plc["Backup.Execute"] = True  # a second edge of Execute while the block is Busy
    plc.scan_until(lambda: not plc["Backup.Busy"])
    assert plc["Backup.Done"] is True
    assert [words[:3] for words in plc.sent] == [[0x101, 0, 20], [0x101, 0, 21]]


def test_a_pulse_of_execute_is_enough_and_the_first_command_is_sent_at_once(
    plc: PointsBench,
) -> None:
    """The data are sent in the scan of the edge, the code in the next scan.

    Source: PLCopen, edge-triggered blocks; guide chapter 2
    """
    plc["Backup.Count"] = 3
    plc.change("Backup.Execute", to=True)
    plc.change("Backup.Execute", to=False)
    assert plc.sent == [[0x101, *[0] * 15]]
    assert plc["Backup.Active"] is True
    taken = 0
    while plc["Backup.Busy"]:
        plc.scan()
        taken += bool(plc["Backup.Taken"])
    assert (taken, plc["Backup.Done"]) == (3, True)
    plc.scan(3)
    assert (plc["Backup.Done"], plc["Backup.Busy"]) == (False, False)
    assert (plc["Backup.Head"]["Count"], plc["Backup.Number"]) == (3, 3)
    assert len(plc.sent) == 3


def test_a_row_is_taken_in_one_scan_only(plc: PointsBench) -> None:
    plc["Backup.Count"] = 2
    plc["Backup.Execute"] = True
    taken = []
    for _ in range(60):
        plc.scan()
        if plc["Backup.Taken"]:
            taken.append(plc["Backup.Row"])
    assert taken == [1, 2]
    assert plc["Backup.Done"] is True


def test_a_lost_link_ends_the_block_and_nothing_restarts_by_itself(plc: PointsBench) -> None:
    """Source: manual chapter 1, 5.2."""
    plc.scan_until(lambda: plc["Backup.Row"] == 3, execute="Backup")
    plc.change("Connected", to=False, scans=3)
    assert plc["Backup.ErrorID"] == 0x8001
    plc["Connected"] = True
    asked = len(plc.sent)
    plc.scan(60)
    assert plc["Backup.ErrorID"] == 0x8001
    assert len(plc.sent) == asked
    plc.change("Backup.Execute", to=False, scans=2)
    assert plc.run("Backup", Resume=True) == 0
    assert [words[2] for words in plc.sent[asked:]] == list(range(3, 100))


@pytest.mark.parametrize("error", [0x8001, 0x8002])
@pytest.mark.parametrize("between", [False, True])
def test_a_lost_or_unready_controller_ends_the_backup_in_the_same_scan(
    plc: PointsBench, between: bool, error: int
) -> None:
    """Source: docs/reference/errors.md, 16#8001 and 16#8002."""
    plc["Backup.Execute"] = True
    plc.scan_until(lambda: plc["Backup.Taken" if between else "Backup.Active"] is True)
    if error == 0x8001:
        plc["Connected"] = False
    else:
        plc.outputs(SO01=False)
    plc.scan()
    assert (plc["Backup.Error"], plc["Backup.ErrorID"]) == (True, error)


def test_a_link_lost_for_one_scan_between_two_rows_ends_the_block(plc: PointsBench) -> None:
    """If the link is lost for one scan between two rows, the next row is not requested."""
    plc.scan_until(lambda: bool(plc["Backup.Taken"]), execute="Backup")
    plc.change("Connected", to=False)
    plc.change("Connected", to=True, scans=20)
    assert plc["Backup.ErrorID"] == 0x8001
    assert [words[2] for words in plc.sent] == [0]


def test_an_illegal_range_is_reported_even_without_a_link(plc: PointsBench) -> None:
    """An illegal range is reported as 16#8044 even without a link.

    Source: docs/reference/errors.md, 16#8044.
    """
    plc["Connected"] = False
    assert plc.run("Backup", most=1, First=-1) == 0x8044


def test_while_the_backup_waits_for_its_turn_it_is_busy_but_not_active(plc: PointsBench) -> None:
    """While a restore has the command words, the backup is Busy but not Active.

    Source: PLCopen, Active.
    """
    plc.stored[0x100, 10] = POINT_50
    assert plc.run("Backup", First=10, Count=1) == 0
    plc.silent = True
    plc.scan_until(lambda: bool(plc["Restore.Active"]), execute="Restore")
    plc["Backup.Execute"] = True
    for _ in range(5):
        plc.scan()
        assert (plc["Backup.Busy"], plc["Backup.Active"]) == (True, False)
    plc.silent = False
    plc.scan_until(lambda: bool(plc["Backup.Active"]))
    assert plc["Restore.Active"] is False


def test_with_done_number_is_the_first_of_the_next_record(plc: PointsBench) -> None:
    plc["Backup.First"], plc["Backup.Count"] = 7, 1
    plc.scan_until(lambda: bool(plc["Backup.Done"]), execute="Backup")
    assert plc["Backup.Number"] == 8


def test_a_short_comment_does_not_truncate_the_next_one(plc: PointsBench) -> None:
    """Source: guide 4.3.2."""
    plc.stored[0x104, 7] = _wide([0, 0, 0x0041])
    plc.stored[0x104, 8] = _wide([0, 0, *[0x4241] * 8])
    assert plc.run("Backup", Kind="DATA_COMMENTS", First=7, Count=2) == 0
    assert plc.row(2) == (True, 0, [*[0x42414241] * 4, 0, 0])
