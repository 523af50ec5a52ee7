"""General-purpose words: SIW, SOW, SID and SOD, and the words shared with remote commands."""

from __future__ import annotations

import pytest

from areas_bench import AreasBench

#: Data of a remote command in which no data word is 0.
DATA = list(range(0x0101, 0x0110))


def _up(size: int = 48, m: int = 0, n: int = 0) -> AreasBench:
    """Return a bench with a ready handshake and no command."""
    plc = AreasBench(size=size, m=m, n=n)
    plc.power_up()
    plc["First.Code"], plc["First.Data"] = 0x0001, DATA
    assert plc["Robot.Inner.Phase"] == "PHASE_READY"
    return plc


def _show(plc: AreasBench, number: int, *words: int) -> None:
    """Set SOW(number) and the words after it, as the robot program would."""
    for k, word in enumerate(words, start=number):
        plc.so[2 * k : 2 * k + 2] = word.to_bytes(2, "little")


def _written(plc: AreasBench, number: int) -> int:
    """Return SIW(number) from the area that FB_WriteArea has written."""
    at = plc.n + 2 * number
    return int.from_bytes(plc.image[at : at + 2], "little")


def test_the_manuals_values_of_words_and_double_words_to_the_robot() -> None:
    """The manual gives SIW(2) = 01FFh for 511, and 0010h and 0001h for SID(2) = 65552.

    Source: manual chapter 3, 2.1, examples of WORD information.
    """
    plc = _up()
    assert plc.write("WriteWord", Number=2, Value=511) == 0
    assert plc.image[4:6] == bytes([0xFF, 0x01])
    assert plc.write("WriteDoubleWord", Number=2, Value=65552) == 0
    assert plc.image[4:8] == bytes([0x10, 0x00, 0x01, 0x00])


def test_the_manuals_values_of_words_and_double_words_from_the_robot() -> None:
    """The manual gives SOW(2) = 512 for 0200h, and SOD(2) = 69905 for 1111h and 0001h.

    Source: manual chapter 3, 2.2, examples of WORD information.
    """
    plc = _up()
    plc.so[4:8] = bytes([0x00, 0x02, 0x00, 0x00])
    assert plc.read("ReadWord", Number=2) == (512, True, 0)
    plc.so[4:8] = bytes([0x11, 0x11, 0x01, 0x00])
    assert plc.read("ReadDoubleWord", Number=2) == (69905, True, 0)


@pytest.mark.parametrize(
    ("low", "high", "value"),
    [
        (0xFFFF, 0xFFFF, -1),
        (0x0000, 0x8000, -2147483648),
        (0xFFFF, 0x7FFF, 2147483647),
        (0xB1E0, 0xFFFF, -20000),
        (0x0000, 0x0001, 65536),
    ],
)
@pytest.mark.parametrize("number", [4, 14, 24, 126])
def test_double_words_are_signed_with_the_lower_word_at_the_lower_address(
    number: int, low: int, high: int, value: int
) -> None:
    """Source: manual chapter 1, 4.1 and 4.2, notes."""
    plc = _up(size=256, m=40, n=80)
    _show(plc, number, low, high)
    assert plc.read("ReadDoubleWord", Number=number) == (value, True, 0)
    assert plc.write("WriteDoubleWord", Number=number, Value=value) == 0
    assert [_written(plc, number), _written(plc, number + 1)] == [low, high]


@pytest.mark.parametrize("size", [48, 256])
def test_each_word_that_the_manual_lists_is_at_its_address(size: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2: SOW(k) at m + 2k, SIW(k) at n + 2k."""
    plc = _up(size=size, m=2, n=4)
    numbers = [*range(2, 16), *(range(24, 128) if size == 256 else [])]
    for number in numbers:
        plc.fill(0)
        plc.so[:32] = bytes(32)
        plc.so[48:] = bytes(size - 48)
        _show(plc, number, 0x8000 + number)
        assert plc.read("ReadWord", Number=number) == (0x8000 + number, True, 0)
        assert plc.write("WriteWord", Number=number, Value=0x4000 + number) == 0
        assert _written(plc, number) == 0x4000 + number
        assert plc.write("WriteWord", Number=number, Value=0) == 0


@pytest.mark.exhaustive(but=["24", "25", "63", "64", "100", "126", "127"])
@pytest.mark.parametrize("number", range(24, 128))
def test_an_extended_word_changes_nothing_beside_it(number: int) -> None:
    """Source: manual chapter 1, 4.2."""
    plc = AreasBench(size=256, n=256)
    plc.fill(0xA5)
    plc.scan()
    before = bytearray(plc.image)
    assert plc.write("WriteWord", Number=number, Value=0x1234) == 0
    before[256 + 2 * number : 258 + 2 * number] = bytes([0x34, 0x12])
    assert plc.image == bytes(before)


@pytest.mark.parametrize("kind", ["Word", "DoubleWord"])
@pytest.mark.parametrize("number", [-32768, -2, 0, 1, 16, 17, 20, 22, 23, 128, 130, 32767])
def test_words_of_commands_bits_and_the_reserved_area_are_refused(number: int, kind: str) -> None:
    """Words of commands, of bits and of the reserved area are refused, such as SIW(23).

    SIW(23) would be the reserved bytes n + 46 and n + 47.

    Source: manual chapter 1, 4.1, notes 1 to 3; chapter 5, 1, reserved area.
    """
    plc = _up(size=256)
    plc.so[:] = bytes([0xFF] * 256)
    plc.fill(0xA5)
    plc.scan()
    before = plc.image
    assert plc.read(f"Read{kind}", Number=number) == (0, False, 0x8034)
    assert plc.write(f"Write{kind}", Number=number, Value=0x1111) == 0x8034
    assert plc.image == before
    assert plc["Robot.Inner.General"] == [0] * 15


@pytest.mark.parametrize("number", [3, 13, 15, 25, 125, 127])
def test_a_double_word_begins_at_an_even_number(number: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2, lists of SOD and SID."""
    plc = _up(size=256)
    plc.fill(0xA5)
    plc.scan()
    before = plc.image
    assert plc.read("ReadDoubleWord", Number=number) == (0, False, 0x8035)
    assert plc.write("WriteDoubleWord", Number=number, Value=-1) == 0x8035
    assert plc.image == before
    assert plc["Robot.Inner.General"] == [0] * 15


@pytest.mark.parametrize("kind", ["Word", "DoubleWord"])
@pytest.mark.parametrize("number", [24, 126])
def test_extended_words_need_256_bytes(number: int, kind: str) -> None:
    """Source: manual chapter 1, 4.2, SIOW extension."""
    plc = _up()
    plc.fill(0xA5)
    plc.scan()
    before = plc.image
    assert plc.read(f"Read{kind}", Number=number) == (0, False, 0x8036)
    assert plc.write(f"Write{kind}", Number=number, Value=1) == 0x8036
    assert plc.image == before


@pytest.mark.parametrize("kind", ["Bit", "Port", "Word", "DoubleWord"])
@pytest.mark.parametrize(
    ("offset", "size", "error"), [(0, 47, 0x8030), (466, 48, 0x8031), (-2, 48, 0x8031)]
)
def test_bits_and_words_of_an_illegal_area_are_refused(
    kind: str, offset: int, size: int, error: int
) -> None:
    plc = AreasBench()
    plc.fill(0xA5)
    plc[f"Read{kind}.m"], plc[f"Read{kind}.Size"] = offset, size
    plc[f"Write{kind}.n"], plc[f"Write{kind}.Size"] = offset, size
    plc[f"Write{kind}.Value"] = True if kind == "Bit" else 1
    plc.change("Writing", to=True)
    assert plc[f"Read{kind}.ErrorID"] == plc[f"Write{kind}.ErrorID"] == error
    assert plc[f"Read{kind}.Valid"] is False
    assert plc["Robot.Inner.General"] == [0] * 15
    assert plc.image[47:] == bytes([0xA5] * 465)


@pytest.mark.parametrize("kind", ["Word", "DoubleWord"])
def test_words_at_an_odd_offset_are_refused_in_an_image_of_words_only(kind: str) -> None:
    plc = AreasBench(size=256, m=5, n=7, alike=False)
    _show(plc, 24, 0x1111, 0x0001)
    plc[f"Read{kind}.Number"] = plc[f"Write{kind}.Number"] = 24
    plc[f"Write{kind}.Value"] = 0x1234
    plc.change("Writing", to=True)
    for name in (f"Read{kind}", f"Write{kind}"):
        assert plc[f"{name}W.ErrorID"] == 0x8032
        assert plc[f"{name}.ErrorID"] == 0
    assert plc[f"Read{kind}.Value"] == {"Word": 0x1111, "DoubleWord": 69905}[kind]
    assert plc.image[7 + 48 : 7 + 50] == bytes([0x34, 0x12])
    assert plc.word_image[34:] == bytes(478)


@pytest.mark.parametrize("kind", ["Word", "DoubleWord"])
@pytest.mark.parametrize("number", [2, 24])
def test_without_connection_no_word_is_valid(kind: str, number: int) -> None:
    """Source: manual chapter 1, 5.2: communication is disabled in the connection error state."""
    plc = _up(size=256)
    _show(plc, number, 0x0007)
    assert plc.read(f"Read{kind}", Number=number) == (7, True, 0)
    plc["Connected"] = False
    assert plc.read(f"Read{kind}") == (0, False, 0x8001)


def test_a_shared_word_is_valid_only_while_no_response_is_shown() -> None:
    """While the status is not 0x0000, words m + 2 to m + 30 carry the response of a command.

    They are not valid as general-purpose words until the status reset is answered.

    Source: manual chapter 1, 4.1; guide chapter 1, 1.2 and chapter 2.
    """
    plc = _up(size=256)
    plc["ReadDoubleWord.Number"] = 14
    _show(plc, 24, 0x0018)
    plc["ReadWord.Number"] = 4
    valid = []

    def look(count: int = 1) -> None:
        for _ in range(count):
            plc.scan()
            assert plc["ReadWord.Valid"] == plc["ReadDoubleWord.Valid"]
            assert plc["ReadWord.Error"] is False
            assert plc["ReadWord.Value"] == (0x0777 if plc["ReadWord.Valid"] else 0)
            valid.append(bool(plc["ReadWord.Valid"]))

    _show(plc, 4, 0x0777)
    look()
    plc["First.Execute"] = True
    look()  # the command's data go out at the end of this scan
    assert valid == [True, True]
    look(2)
    plc.answer(0x0100, [0, 0, 0, 0x9999])
    look()
    plc.answer(0x0200, [0, 0, 0, 0x9999])
    look(3)
    plc.answer(0x0000)
    _show(plc, 4, 0x0777)
    look()  # the reset is answered, and the end of this scan sees the ready status
    assert valid[2:] == [False] * 7
    look()
    assert valid[-1] is True


def test_a_status_without_a_command_makes_the_shared_words_invalid_at_once() -> None:
    """A status without a command makes the shared words invalid at once.

    When a PLC starts, the controller may still show the status of its last command.

    Source: guide chapter 1, 1.2: a status other than 0x0000 has a response beside it.
    """
    plc = _up()
    _show(plc, 4, 0x0777)
    assert plc.read("ReadWord", Number=4) == (0x0777, True, 0)
    plc.answer(0x4000, [0x000C, 0x0258, 0, 0x0777])
    assert plc.read("ReadWord", Number=4) == (0, False, 0)


def test_extended_words_and_bits_are_valid_while_a_command_runs() -> None:
    """Source: manual chapter 1, 4.2: these words are not used by commands."""
    plc = _up(size=256)
    _show(plc, 126, 0x5678, 0x1234)
    plc.so[45] = 0x80
    plc.change("First.Execute", to=True, scans=3)
    plc.answer(0x0100)
    assert plc.read("ReadWord", Number=127) == (0x1234, True, 0)
    assert plc.read("ReadDoubleWord", Number=126) == (0x12345678, True, 0)
    assert plc.read("ReadBit", Port=157) == (True, True, 0)


def test_a_running_command_is_never_disturbed_by_a_general_purpose_write() -> None:
    """Source: guide chapter 1, 1.1, note: code and data are held until the end."""
    plc = _up()
    plc["Writing"] = plc["First.Execute"] = True
    plc["WriteDoubleWord.Number"] = 14
    seen = []

    def look(count: int) -> None:
        for _ in range(count):
            number = 2 + plc.now_us // 10_000 % 12
            plc["WriteWord.Number"], plc["WriteWord.Value"] = number, plc.now_us // 1000
            plc.change("WriteDoubleWord.Value", to=-plc.now_us)
            seen.append(plc.words)

    look(1)
    assert seen == [[0x0000, *DATA]]
    look(2)
    plc.answer(0x0100)
    look(30)
    assert seen[1:] == [[0x0001, *DATA]] * 32
    plc.answer(0x0200)
    look(1)
    general = [0, *plc["Robot.Inner.General"][1:]]
    assert plc.words == [0x0000, *general], "the status reset releases the words"
    assert general[13] == (-plc.now_us + 10_000) & 0xFFFF


def test_values_written_during_a_command_are_sent_after_it() -> None:
    """Source: guide chapter 1, 1.2, code 0x0000."""
    plc = _up()
    plc.change("First.Execute", to=True, scans=3)
    assert plc.write("WriteWord", Number=7, Value=0xBEEF) == 0
    assert plc.words == [0x0001, *DATA]
    plc.answer(0x0200, scans=1)
    assert plc.words == [0, *[0] * 6, 0xBEEF, *[0] * 8]
    plc.answer(0, scans=5)
    assert _written(plc, 7) == 0xBEEF, "the word stays until it is written again"


def test_word_1_is_reserved_for_commands() -> None:
    """Source: manual chapter 1, 4.1, note 1."""
    plc = _up()
    plc["Robot.Inner.General[1]"] = plc["Robot.Inner.General[2]"] = 0x1234
    plc.scan()
    assert plc.words == [0, 0, 0x1234, *[0] * 13]


def test_values_written_without_connection_are_sent_after_it_returns() -> None:
    """Values that are written without a connection are in the area after the connection returns.

    Source: manual chapter 1, 5.2: the area is not read without a connection.
    """
    plc = _up(size=256)
    plc.change("Connected", to=False)
    assert plc.write("WriteWord", Number=3, Value=0x0303) == 0
    assert plc.write("WriteWord", Number=30, Value=0x3030) == 0
    assert plc.write("WriteBit", Port=33, Value=True) == 0
    plc.change("Connected", to=True)
    assert [_written(plc, 3), _written(plc, 30), plc.image[35]] == [0x0303, 0x3030, 0x08]


def test_the_reserved_bytes_are_never_written() -> None:
    """Source: manual chapter 5, 1, reserved area; chapter 1, 4.1, note 3."""
    for size in (48, 256):
        plc = _up(size=size, n=64)
        plc.fill(0x5A)
        for number in range(-5, 200):
            plc.write("WriteBit", Port=number, Value=True)
            plc.write("WritePort", Port=number, Value=0xFF)
            plc.write("WriteWord", Number=number, Value=0xFFFF)
            plc.write("WriteDoubleWord", Number=number, Value=-1)
        area = plc.image[64 : 64 + size]
        assert area[46:48] == bytes([0x5A, 0x5A])
        assert area[34:46] == bytes([0xFF] * 12)
        assert set(area[48:]) <= {0xFF}
        assert plc.image[:64] + plc.image[64 + size :] == bytes([0x5A] * (512 - size))
