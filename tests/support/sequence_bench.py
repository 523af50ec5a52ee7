"""A bench for sequence blocks: Sequences.st, and a controller that is powered up."""

from __future__ import annotations

from plc_bench import ROOT, PlcBench


def sequences() -> PlcBench:
    """Return a bench in AUTO mode with servos off, and SI(00) and SI(06) ON and settled."""
    plc = PlcBench(program=ROOT / "tests/data/library/Sequences.st")
    plc.power_up()
    return plc


def servo_on() -> PlcBench:
    """Return the bench of `sequences` with the servos on and the program reset."""
    plc = sequences()
    plc.outputs(SO02=True, SO14=True)
    plc.scan()
    return plc


def in_emergency_stop() -> PlcBench:
    """Return a bench in the emergency stop of FB_EmergencyStop, with SO(00) and SO(03) ON."""
    plc = servo_on()
    plc["EmergencyStop.Execute"] = True
    plc.scan()
    plc.outputs(SO00=True, SO03=True, SO02=False)
    plc.scan()
    assert plc["EmergencyStop.Done"]
    plc["EmergencyStop.Execute"] = False
    plc.scan(30)
    assert plc.inputs == ["SI06"]
    return plc


def program_stopped() -> PlcBench:
    """Return a bench in which FB_ProgramStop still holds SI(06) OFF after its Execute."""
    plc = servo_on()
    plc.outputs(SO14=False)
    plc["ProgramStop.Execute"] = True
    plc.scan(20)
    plc["ProgramStop.Execute"] = False
    plc.scan(20)
    assert plc.inputs == ["SI00"]
    return plc


def pins(plc: PlcBench, block: str) -> str:
    """Return which of Done, Busy, Active and Error are TRUE, as in `Busy Active`."""
    names = ("Done", "Busy", "Active", "Error")
    return " ".join(name for name in names if plc[f"{block}.{name}"])
