"""FB_Operator stops or reports only its own commands, not the commands of other blocks."""

from __future__ import annotations

import pytest

from operator_bench import OperatorBench

_LINE, _SPEED, _STEP, _MOVE, _READ = 0x0403, 0x0038, 0x0024, 0x0001, 0x0102
_KEYS = {"StepLine": _LINE, "JogPlus": _STEP}


def _stopped_without_the_hmi(plc: OperatorBench) -> bool:
    plc.change("Operator.HmiOk", to=False, scans=2)
    return "SI06" not in plc.inputs


@pytest.mark.parametrize("key", _KEYS)
def test_without_the_hmi_the_same_command_of_another_block_continues(key: str) -> None:
    """If the HMI is lost, the command of another block continues.

    This holds even if the panel has sent the same command before.

    Source: head of FB_Operator, HmiOk.
    """
    plc = OperatorBench(Stepwise=True)
    plc.press(key, scans=20)
    assert _KEYS[key] in plc.codes
    plc.hold = _KEYS[key]
    plc["Other.Code"], plc["Other.Execute"] = _KEYS[key], True
    plc.scan_until(lambda: plc.words[0] == _KEYS[key])
    plc.scan(3)
    assert not _stopped_without_the_hmi(plc)


@pytest.mark.parametrize("then", [0, _MOVE])
@pytest.mark.parametrize("key", _KEYS)
def test_a_step_that_ended_during_missed_calls_is_not_stopped_later(key: str, then: int) -> None:
    """If a step has ended during missed calls, the panel does not stop it afterwards.

    The panel does not stop the next movement of another block either.

    Source: docs/explanation/scan-model.md, a block that is skipped; head of FB_Operator, HmiOk
    """
    plc = OperatorBench(Stepwise=True)
    plc.hold = _KEYS[key]
    plc.press(key, scans=20)
    plc["Other.Code"], plc["Other.Execute"] = then, then > 0
    plc.change("Call", to=False, scans=3)
    plc.hold = then
    plc.scan(20)
    assert plc.words[0] == then
    plc.change("Call", to=True, scans=2)
    assert not _stopped_without_the_hmi(plc)


def test_a_step_that_comes_too_late_is_reported_only_as_late() -> None:
    """If a step comes too late, the panel reports only this, and not a speed set by another block.

    Source: docs/reference/errors.md, 16#8076 and 16#805D
    """
    told = set()
    for scans in range(95, 99):
        plc = OperatorBench(Stepwise=True)
        plc.key("JogPlus", scans=3)
        plc.hold = plc["Other.Code"] = _READ
        plc["Third.Code"], plc["Other.Execute"] = _SPEED, True
        plc.scan(20)
        plc["Third.Execute"] = True
        plc.scan(scans - 23)
        plc.hold = 0
        late = False
        for _ in range(20):
            plc.scan()
            late = late or plc.message == 0x8076
            assert plc.message == 0x8076 or not late
        told.add(plc.message)
    assert told == {0x8076, 0x805D}
