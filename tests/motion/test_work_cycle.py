"""FB_WorkCycle: Start, Stop, Reset and the first fault; the test plays the controller."""

from __future__ import annotations

from plc_bench import ROOT, PlcBench


def _bench() -> PlcBench:
    """Controller in its normal state, AUTO, servos on, SI(00) and SI(06) ON and settled."""
    plc = PlcBench(program=ROOT / "tests/data/library/WorkCycle.st")
    plc.power_up()
    plc.outputs(SO02=True)
    plc.scan()
    return plc


def _press(plc: PlcBench, pin: str) -> None:
    plc[pin] = True
    plc.scan()
    plc[pin] = False
    plc.scan()


def _running(block: str = "Bare") -> PlcBench:
    """The cycle has powered up, and wants its work."""
    plc = _bench()
    _press(plc, f"{block}.Start")
    plc.scan_until(lambda: bool(plc[f"{block}.Run"]))
    return plc


def _finish(plc: PlcBench) -> None:
    """The movement that is out ends normally, and the status is reset."""
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.answer(0x0200)
    plc.scan_until(lambda: plc.words[0] == 0)
    plc.answer(0)


def test_start_powers_up_and_the_work_follows_again_and_again() -> None:
    """Source: this library's own; servo on: chapter 5, 3.1."""
    plc = _bench()
    plc.outputs(SO02=False)
    plc.scan(20)
    assert plc["Cycle.State"] == "WORK_IDLE"
    _press(plc, "Cycle.Start")
    assert (plc["Cycle.State"], plc["Cycle.Busy"], plc["Cycle.Run"]) == ("WORK_POWER_UP", 1, 0)
    plc.scan_until(lambda: "SI01" in plc.inputs)
    plc.outputs(SO02=True)
    plc.scan_until(lambda: bool(plc["Cycle.Run"]))
    assert plc["Cycle.State"] == "WORK_RUN"
    for count in (1, 2, 3):
        _finish(plc)
        plc.scan()
        assert plc["Cycle.Count"] == count
    assert plc["Cycle.Busy"]
