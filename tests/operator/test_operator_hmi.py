"""If the HMI is lost (HmiOk FALSE), only the key Stop of FB_Operator has an effect."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from operator_bench import OperatorBench

_KEYS = ("ServoOn", "Start", "ProgramReset", "StepLine", "JogPlus", "JogMinus", "Teach")


@pytest.mark.parametrize("key", [*_KEYS, "Reset"])
@pytest.mark.parametrize("engine", ENGINES)
def test_without_the_hmi_only_stop_is_possible(engine: str, key: str) -> None:
    """Source: FB_Operator, HmiOk."""
    plc = OperatorBench(engine, up=False)
    plc.outputs(SO01=True, SO02=key != "ServoOn", SO04=True, SO10=True, SO03=key == "Reset")
    plc.set(Automatic=key == "Start", scans=60)
    assert plc.can(key) == [True]
    plc.change("Operator.HmiOk", to=False)
    assert plc.can(*_KEYS, "Reset") == [False] * (len(_KEYS) + 1)
    assert plc.can("Stop") == [True]
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x8001, False)
    plc.press(key)
    plc.key(key)
    plc.change("Operator.HmiOk", to=True)
    assert plc.message == 0x8074
    plc.scan(60)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.sent == []
    plc.key(key, False, scans=1)
    plc.key(key, scans=1)
    assert plc["Operator.Busy"], "a new press counts"


@pytest.mark.parametrize("engine", ENGINES)
def test_stop_acts_without_the_hmi(engine: str) -> None:
    """Source: FB_Operator: Stop always acts."""
    plc = OperatorBench(engine)
    plc["Operator.HmiOk"] = False
    plc.key("Stop", scans=2)
    assert plc.inputs == ["SI00"]
