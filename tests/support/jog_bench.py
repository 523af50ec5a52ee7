"""A bench for FB_Jog, with helpers that begin a jog and end it by the stop input."""

from __future__ import annotations

from plc_bench import ROOT, PlcBench

PROGRAM = ROOT / "tests/data/library/Levels.st"

#: Words of the end status 16#4000 with alarm 12.400 and the position 12345, -123, 2000 of guide
#: 4.2.6.
STOPPED = [0x000C, 0x0190, 0, 0x3039, 0, 0xFF85, 0xFFFF, 0x07D0, 0]


def jog_plc() -> PlcBench:
    """Return a powered-up bench that is ready for a jog."""
    plc = PlcBench(program=PROGRAM)
    plc.power_up()
    plc.scan(3)
    return plc


def jogging(plc: PlcBench, **pins: object) -> None:
    """Set Enable, and scan until the controller executes the jog command."""
    for name, value in pins.items():
        plc[f"Jog.{name}"] = value
    plc["Jog.Enable"] = True
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.answer(0x0100)
    plc.scan()


def end_by_stop(plc: PlcBench) -> None:
    """Reset Enable, and let the controller end the jog with the alarm 12.400."""
    plc["Jog.Enable"] = False
    plc.scan(2)
    plc.answer(0x4000, STOPPED)
    plc.scan()
    plc.answer(0)


def present(plc: PlcBench, what: str, there: bool) -> None:
    """Switch the link (`Connected`) or CPU_OK on or off."""
    if what == "Connected":
        plc["Connected"] = there
    else:
        plc.outputs(SO01_CpuOk=there)
