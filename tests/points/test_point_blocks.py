"""FB_PointBackup and FB_PointRestore have the same rules for Execute, time-outs and errors."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from points_bench import PointsBench, points_bench, record

_on_both = pytest.mark.parametrize("block", ["Backup", "Restore"])


@pytest.fixture(params=ENGINES)
def plc(request: pytest.FixtureRequest) -> PointsBench:
    """Return a controller without points, and an array with the points 10 to 13."""
    plc = points_bench(request.param)
    record(plc)
    plc["Backup.First"], plc["Backup.Count"] = 10, 4
    return plc


@_on_both
def test_a_link_in_the_scan_after_the_edge_is_early_enough(plc: PointsBench, block: str) -> None:
    """Source: head of FB_RcxJob: a job ends at the earliest in its second call."""
    plc["Connected"] = False
    plc.change(f"{block}.Execute", to=True)
    plc["Connected"] = True
    plc.scan_until(lambda: not plc[f"{block}.Busy"])
    assert plc[f"{block}.ErrorID"] == 0


@_on_both
def test_each_answer_is_waited_for_no_longer_than_timeout(plc: PointsBench, block: str) -> None:
    plc.silent = True
    assert plc.run(block, Timeout="T#200ms", most=40) == 0x8011
    assert plc[f"{block}.Number"] == 10
    assert plc[f"{block}.Active"] is False


@_on_both
def test_without_timeout_pin_the_block_waits_five_seconds_for_an_answer(
    plc: PointsBench, block: str
) -> None:
    """Source: FB_PointBackup.md, FB_PointRestore.md, Timeout."""
    plc.silent = True
    plc[f"{block}.Execute"] = True
    plc.scan_until(lambda: bool(plc[f"{block}.Active"]), most=1 if block == "Backup" else 20)
    plc.scan(499)
    assert (plc[f"{block}.Busy"], plc[f"{block}.Active"]) == (True, True)
    plc.scan()
    assert (plc[f"{block}.Error"], plc[f"{block}.ErrorID"]) == (True, 0x8011)


@_on_both
def test_after_a_pulse_of_execute_the_error_is_shown_for_one_scan(
    plc: PointsBench, block: str
) -> None:
    """Source: PLCopen, edge-triggered blocks."""
    plc.refuses[11] = (12, 76)
    plc.change(f"{block}.Execute", to=True)
    plc[f"{block}.Execute"] = False
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]))
    assert (plc[f"{block}.ErrorID"], plc[f"{block}.AlarmGroup"]) == (0x8020, 12)
    plc.scan()
    shown = [plc[f"{block}.{pin}"] for pin in ("Error", "ErrorID", "AlarmGroup")]
    assert shown == [False, 0, 0]


@_on_both
@pytest.mark.parametrize("answered", [True, False])
def test_after_a_pulse_and_an_error_the_next_edge_may_come_at_once(
    plc: PointsBench, block: str, answered: bool
) -> None:
    """Source: PLCopen, edge-triggered blocks."""
    plc.refuses[11] = (12, 76)
    plc.silent = not answered
    plc[f"{block}.Timeout"] = "T#200ms"
    plc.change(f"{block}.Execute", to=True)
    plc[f"{block}.Execute"] = False
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]))
    assert plc[f"{block}.ErrorID"] == (0x8020 if answered else 0x8011)
    plc.refuses.clear()
    plc.silent = False
    assert plc.run(block) == 0


@pytest.mark.parametrize(
    ("call", "to", "error"),
    [("CallBackup", False, 0x8013), ("CallTwice", True, 0x8016)],
    ids=["no call", "two calls"],
)
@pytest.mark.parametrize(
    ("block", "pin", "value"),
    [
        ("Backup", "Active", True),
        ("Backup", "Taken", True),
        ("Restore", "Row", 3),
        ("Restore", "Active", True),
        ("Restore", "Number", 11),
    ],
)
def test_a_missing_or_second_call_in_a_scan_ends_the_block(
    plc: PointsBench, block: str, pin: str, value: int, call: str, to: bool, error: int
) -> None:
    """A missing or second call in a scan ends the block in each of its states.

    The states are: it checks the rows, a command runs, and between two commands.

    Source: docs/explanation/scan-model.md, one scan
    """
    plc[f"{block}.Execute"] = True
    if pin == "Number":
        plc.scan_until(lambda: len(plc.sent) == 1)
    plc.scan_until(lambda: plc[f"{block}.{pin}"] == value)
    sent = len(plc.sent)
    plc.change(call, to=to)
    plc.change(call, to=not to, scans=10)
    assert plc[f"{block}.ErrorID"] == error
    assert len(plc.sent) <= sent + (to or pin == "Active")
    if block == "Restore":
        assert plc["Restore.Row"] == (2 if pin == "Number" else 1)
    plc.change(f"{block}.Execute", to=False, scans=10)
    assert plc.run(block) == 0
