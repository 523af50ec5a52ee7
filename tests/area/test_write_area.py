"""FB_WriteArea writes certain bytes of the process image and does not change the others."""

from __future__ import annotations

from datetime import timedelta
from random import Random

import pytest

from alone import Alone
from head_rules import OTHERS, SAFETY, Channel, HeadRules, bits_of
from plc_bench import PlcBench
from shown import differences

#: Dedicated inputs as in chapter 5, 2: (byte from n, bit, field of RCX_SI).
PRINTED = [
    (32, 0, "SI00_EmergencyStop"),
    (32, 1, "SI01_ServoOn"),
    (32, 6, "SI06_Stop"),
    (33, 0, "SI10_SequenceControl"),
    (33, 2, "SI12_AutoStart"),
    (33, 4, "SI14_ReturnToOriginIncr"),
    (33, 5, "SI15_ProgramReset"),
    (33, 6, "SI16_AlarmReset"),
    (33, 7, "SI17_ReturnToOriginAbs"),
]


@pytest.mark.parametrize(("byte", "bit", "name"), PRINTED)
def test_each_dedicated_input_goes_to_its_bit_and_no_other(byte: int, bit: int, name: str) -> None:
    """Source: manual chapter 5, 2, bit input."""
    plc = PlcBench()
    plc.change("EmergencyStopOk", "StopOk", to=False, scans=13)
    if name == "SI00_EmergencyStop":
        plc["EmergencyStopOk"] = True
    elif name == "SI06_Stop":
        plc["StopOk"] = True
    else:
        plc.change("EmergencyStopOk", "StopOk", to=True, scans=60)
        before = bytearray(plc.image)
        assert before[32:34] == bytes([0x41, 0x00]), "SI(00) and SI(06)"
        plc.change("Request", to=bits_of({name: True}))
        before[byte] |= 1 << bit
        assert plc.image == before
        return
    plc.scan()
    assert plc.image[byte] == 1 << bit
    assert plc.image[32:34].count(0) == 1


@pytest.mark.parametrize(("size", "n"), [(48, 0), (48, 3), (48, 464), (256, 0), (256, 256)])
def test_only_bytes_n_to_n_plus_33_are_written(size: int, n: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2; chapter 5, 1, reserved area."""
    plc = PlcBench(size=size, n=n)
    plc.program.write_bytes("Main.OutputArea", bytes([0xA5] * 512))
    plc.outputs(SO01=True)
    plc["First.Code"] = 0x0001
    plc["First.Data"] = [0xFFFF] * 15
    plc.change("First.Execute", to=True, scans=60)
    assert plc.words == [0x0001] + [0xFFFF] * 15
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.image[:n] == bytes([0xA5] * n)
    assert plc.image[n + 34 :] == bytes([0xA5] * (512 - n - 34))


@pytest.mark.parametrize(
    ("size", "n", "error"),
    [(47, 0, 0x8030), (0, 0, 0x8030), (48, 465, 0x8031), (48, -1, 0x8031), (256, 257, 0x8031)],
)
def test_an_illegal_area_is_refused_and_nothing_is_written(size: int, n: int, error: int) -> None:
    plc = PlcBench()
    plc["WriteArea.Size"], plc["WriteArea.n"] = size, n
    plc.program.write_bytes("Main.OutputArea", bytes([0xA5] * 512))
    plc.outputs(SO01=True, scans=50)
    assert plc["WriteArea.Error"] is True
    assert plc["WriteArea.ErrorID"] == error
    assert plc.image == bytes([0xA5] * 512)


def test_words_go_out_with_the_lower_byte_first() -> None:
    """Source: guide chapter 1, 1.1, little endian."""
    plc = PlcBench()
    plc.power_up()
    plc["First.Code"] = 0x1234
    plc["First.Data[1]"] = 0x5678
    plc["First.Data[15]"] = 0x9ABC
    plc.change("First.Execute", to=True, scans=2)
    assert plc.image[0:4] == bytes([0x34, 0x12, 0x78, 0x56])
    assert plc.image[30:32] == bytes([0xBC, 0x9A])


@pytest.mark.parametrize(
    ("hold", "name"), [("HoldEmergency", "SI00"), ("HoldStop", "SI06")], ids=["SI00", "SI06"]
)
def test_an_input_held_by_a_block_is_off_even_if_its_pin_is_true(hold: str, name: str) -> None:
    """Source: manual chapter 5, 2, SI(00) and SI(06): OFF stops."""
    plc = PlcBench()
    plc.power_up()
    plc.change(f"Robot.Inner.{hold}", to=True)
    assert plc.inputs == [one for one in ("SI00", "SI06") if one != name]
    plc.scan(50)
    assert name not in plc.inputs
    plc.change(f"Robot.Inner.{hold}", to=False)
    assert plc.inputs == ["SI00", "SI06"]


# --- FB_RcxMakeHead alone, with random inputs ---


@pytest.fixture(scope="module")
def head() -> Alone:
    return Alone("FB_RcxMakeHead", {"Robot": "RCX_REF"})


def test_very_long_times_do_not_overflow_32_bits(head: Alone) -> None:
    """If both times have their limit of 8 days, their sum stays below 2^31 ms (24.8 days)."""
    head.restart()
    head["Block.Interval"] = head["Block.Margin"] = "T#24d"
    head.scan(0)
    assert head["Block.Spacing"] == timedelta(days=16)
    assert head["Block.Extra"] == timedelta(days=8)


_DAY_MS = 86_400_000


@pytest.mark.parametrize(
    ("interval", "margin", "spacing_ms", "extra_ms"),
    [
        ("T#24d", "T#1s", 8 * _DAY_MS + 1000, 1000),
        ("T#200ms", "T#24d", 8 * _DAY_MS + 200, 8 * _DAY_MS),
        ("T#200ms", "T#-1s", 200, 0),
        ("T#200ms", "T#0s", 200, 0),
    ],
)
def test_each_time_has_its_own_limits_in_every_scan(
    head: Alone, interval: str, margin: str, spacing_ms: int, extra_ms: int
) -> None:
    """Interval and Margin are limited separately, and their earlier values have no effect.

    Source: head of FB_RcxMakeHead: 8 days of each count.
    """
    head.restart()
    head["Block.Interval"], head["Block.Margin"] = "T#150ms", "T#50ms"
    head.scan(0)
    head["Block.Interval"], head["Block.Margin"] = interval, margin
    head.scan(10)
    assert head["Block.Spacing"] == timedelta(milliseconds=spacing_ms)
    assert head["Block.Extra"] == timedelta(milliseconds=extra_ms)


@pytest.mark.parametrize("changed", [None, *range(1, 16)])
def test_the_code_is_sent_only_after_unchanged_data(head: Alone, changed: int | None) -> None:
    """Source: guide, chapter 2: the data of a command are there before its code."""
    head.restart()
    head["Block.Interval"] = "T#100ms"
    head["Robot.Connected"] = head["Robot.SO.SO01_CpuOk"] = True
    head["Robot.Inner.Code"] = 0x0501
    head["Robot.Inner.Command"] = {"NextTicket": 1}
    head.scan(0)
    for now in (100, 110):
        head["Robot.Inner.CodeRequest"], head["Robot.Inner.Command.Lowest"] = True, 0
        if now == 110 and changed is not None:
            head[f"Robot.Inner.Data[{changed}]"] = 0x1234
        head.scan(now)
        sent = now == 110 and changed is None
        assert head["Block.Code"] == (0x0501 if sent else 0x0000)


_CODES = (0x0001, 0x0020, 0x0021, 0x1022, 0x3020, 0x0501, 0x0023, 0x001F)
_STATUSES = (0x0000, 0x0000, 0x0100, 0x0100, 0x0200, 0x4000)


@pytest.mark.parametrize(("interval", "margin"), [(100, 20), (60, 30), (130, 0), (100, 70)])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_written_area_follows_the_rules(
    head: Alone, seed: int, interval: int, margin: int
) -> None:
    """Source: chapter 5, 1 and 3; guide chapters 1, 2 and 4.2.6; design of the library, 2."""
    head.restart()
    head["Block.Interval"], head["Block.Margin"] = f"T#{interval}ms", f"T#{margin}ms"
    chance, rules, channel = Random(seed), HeadRules(), Channel()
    flags = {"connected": True, "cpu_ok": True, "asked": True, "stop_jog": False}
    flags |= {"ok00": True, "ok06": True, "hold00": False, "hold06": False}
    often = {"connected": 0.004, "cpu_ok": 0.004, "asked": 0.05, "stop_jog": 0.02}
    requests = dict.fromkeys(OTHERS, False)
    status, code, data, general = 0, _CODES[0], [0] * 15, [0] * 15
    for scan in range(1200):
        for name, on in flags.items():
            usual = name.startswith(("ok", "c", "a"))
            flags[name] ^= chance.random() < (often.get(name, 0.006) if on == usual else 0.15)
        for name in requests:
            requests[name] ^= chance.random() < 0.01
        if chance.random() < 0.2:
            status = chance.choice(_STATUSES)
        if not channel.taken:
            code, data = chance.choice(_CODES), [chance.randrange(65536) for _ in range(15)]
            if chance.random() < 0.5:
                channel.next_ticket += 1
        if chance.random() < 0.1:
            general = [chance.randrange(65536) for _ in range(15)]
        seen = not channel.taken or chance.random() < 0.97
        channel.lowest = channel.serving if seen else channel.next_ticket
        head["Robot.Connected"], head["Robot.SO.SO01_CpuOk"] = flags["connected"], flags["cpu_ok"]
        head["Robot.Status"], head["Robot.Inner.CodeRequest"] = status, flags["asked"]
        head["Robot.Inner.Code"], head["Robot.Inner.Data"], head["Robot.Inner.General"] = (
            code,
            data,
            general,
        )
        head["Robot.Inner.StopJog"] = flags["stop_jog"]
        head["Robot.Inner.HoldEmergency"], head["Robot.Inner.HoldStop"] = (
            flags["hold00"],
            flags["hold06"],
        )
        head["Block.EmergencyStopOk"], head["Block.StopOk"] = flags["ok00"], flags["ok06"]
        head["Robot.Inner.Request"] = bits_of(requests)
        head["Robot.Inner.Command"] = {
            "NextTicket": channel.next_ticket,
            "Serving": channel.serving,
            "Lowest": channel.lowest,
            "Orphan": channel.orphan,
        }
        head.scan(10 * scan)
        rules.scan(
            10 * scan,
            connected=flags["connected"],
            cpu_ok=flags["cpu_ok"],
            status=status,
            asked=flags["asked"],
            code=code,
            data=data,
            general=general,
            stop_jog=flags["stop_jog"],
            ok=(flags["ok00"], flags["ok06"]),
            holds=(flags["hold00"], flags["hold06"]),
            requests=requests,
            channel=channel,
            interval=interval,
            margin=margin,
        )
        given = ", ".join(flag for flag, is_on in flags.items() if is_on)
        told = f"seed {seed}, scan {scan}, status 16#{status:04X}, code 16#{code:04X}, {given}"
        inputs, words = head["Robot.SI"], head["Block.Words"]
        assert isinstance(inputs, dict)
        assert isinstance(words, list)
        applied = rules.inputs.applied
        wrong = differences(
            (*applied, "Phase", "Applied", "StopJog", *(f"word {k}" for k in range(16))),
            [*(inputs[name] for name in applied)]
            + [head[f"Robot.Inner.{name}"] for name in ("Phase", "Applied", "StopJog")]
            + [head["Block.Code"], *words],
            [*applied.values(), rules.handshake.phase, rules.bits, False, *rules.words],
        )
        assert not wrong, f"FB_WriteArea, {told}: {wrong}"
    assert set(SAFETY) <= set(rules.inputs.applied)
