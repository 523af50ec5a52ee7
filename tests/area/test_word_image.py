"""FB_ReadAreaWords and FB_WriteAreaWords use the same area in an image of words.

AreasBench compares the blocks for bytes and for words after every scan. These tests check what that
comparison cannot show.
"""

from __future__ import annotations

from random import Random

import pytest

from areas_bench import AreasBench


def _word(plc: AreasBench, k: int) -> int:
    """Return element k of the output image of words."""
    return int(plc[f"OutputWords[{k}]"])


@pytest.mark.parametrize(("size", "m"), [(48, 0), (48, 2), (48, 464), (256, 0), (256, 256)])
def test_word_k_of_the_image_holds_bytes_2k_and_2k_plus_1(size: int, m: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2, addresses; guide chapter 1, 1.1, little endian."""
    plc = AreasBench(size=size, m=m)
    plc.so[0:2] = bytes([0x00, 0x02])
    plc.so[2:4] = bytes([0x67, 0x45])
    plc.so[30:32] = bytes([0x23, 0x01])
    plc.so[32:34] = bytes([0x02, 0x20])
    plc.scan()
    assert plc[f"InputWords[{m // 2 + 1}]"] == 0x4567
    assert plc["RobotW.Status"] == 0x0200
    assert plc["RobotW.Response[1]"] == 0x4567
    assert plc["RobotW.Response[15]"] == 0x0123
    on = [name for name, state in plc["RobotW.SO"].items() if state]
    assert on == ["SO01_CpuOk", "SO15_Warning"]
    assert plc["RobotW.Connected"] is True
    assert plc["ReadAreaW.ErrorID"] == 0


@pytest.mark.parametrize(("size", "n"), [(48, 0), (48, 6), (48, 464), (256, 256)])
def test_code_data_and_dedicated_inputs_go_to_their_words_and_no_others(size: int, n: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2; chapter 5, 1 and 2, SI(00), SI(06), SI(01)."""
    plc = AreasBench(size=size, n=n)
    plc.fill(0xA5)
    plc.power_up()
    plc["First.Code"], plc["First.Data"] = 0x1234, list(range(0x0101, 0x0110))
    plc.change("First.Execute", "ServoOn.Execute", to=True, scans=13)
    k = n // 2
    assert [_word(plc, k + j) for j in range(16)] == [0x1234, *range(0x0101, 0x0110)]
    assert _word(plc, k + 16) == 0x0043, "SI(00), SI(01) and SI(06)"
    rest = plc.word_image[:n] + plc.word_image[n + 34 :]
    assert rest == bytes([0xA5] * (512 - 34))


def test_images_of_bytes_and_words_agree_in_every_scan() -> None:
    """The images of bytes and of words are equal in every scan, with random answers."""
    draw = Random(20)
    plc = AreasBench(m=10, n=20)
    plc["First.Code"], plc["First.Data[15]"] = 0x0505, 0xFFFF
    for _ in range(400):
        plc["First.Execute"] = draw.random() < 0.7
        plc["ServoOn.Execute"] = draw.random() < 0.9
        plc["Connected"] = draw.random() < 0.97
        plc["StopOk"] = draw.random() < 0.95
        plc.so[:] = draw.randbytes(48)
        plc.answer(draw.choice([0, 0, 0x0100, 0x0200, 0x4000]), [draw.randrange(0x10000)])
        plc.scan(draw.randint(1, 5))
    assert plc["First.ErrorID"] in (0, 0x8001, 0x8002, 0x8012, 0x8014, 0x8015, 0x8020)


@pytest.mark.parametrize("offset", [1, 3, 463])
def test_an_odd_offset_is_refused_in_an_image_of_words(offset: int) -> None:
    plc = AreasBench(m=offset, n=offset, alike=False)
    plc.fill(0xA5)
    plc.outputs(SO01=True, scans=20)
    assert plc["ReadAreaW.Error"] is plc["WriteAreaW.Error"] is True
    assert plc["ReadAreaW.ErrorID"] == plc["WriteAreaW.ErrorID"] == 0x8032
    assert plc["RobotW.Connected"] is False
    assert plc["RobotW.SO.SO01_CpuOk"] is False
    assert plc.word_image == bytes([0xA5] * 512)
    assert plc["ReadArea.ErrorID"] == plc["WriteArea.ErrorID"] == 0, (
        "an area of bytes may begin anywhere"
    )


@pytest.mark.parametrize(
    ("size", "offset", "error"),
    [
        (47, 0, 0x8030),
        (256, 258, 0x8031),
        (48, 466, 0x8031),
        (48, -2, 0x8031),
        (48, -1, 0x8031),
        (48, 467, 0x8031),
    ],
)
def test_an_illegal_area_is_refused_as_in_an_image_of_bytes(
    size: int, offset: int, error: int
) -> None:
    """Source: manual chapter 1, 4.1 and 4.2: 48 or 256 bytes."""
    plc = AreasBench()
    plc.fill(0xA5)
    for block, pin in (("ReadArea", "m"), ("WriteArea", "n")):
        plc[f"{block}.{pin}"], plc[f"{block}.Size"] = offset, size
    plc.scan(2)
    assert plc["ReadAreaW.ErrorID"] == plc["WriteAreaW.ErrorID"] == error
    assert plc.word_image == bytes([0xA5] * 512)


def test_without_connection_no_data_of_the_image_of_words_are_used() -> None:
    """Source: manual chapter 1, 5.2: communication is disabled in the connection error state."""
    plc = AreasBench()
    plc.answer(0x4000, [0x000C, 0x0258])
    plc.outputs(SO00=True, scans=1)
    assert plc["RobotW.Response[2]"] == 0x0258
    plc.change("Connected", to=False)
    assert plc["RobotW.Status"] == 0
    assert plc["RobotW.Response"] == [0] * 15
    assert not any(plc["RobotW.SO"].values())


def test_a_smaller_image_is_told_by_its_size_in_bytes() -> None:
    plc = AreasBench(m=100, n=100)
    plc.change("ReadArea.ImageSize", "WriteArea.ImageSize", to=147)
    assert plc["ReadAreaW.ErrorID"] == plc["WriteAreaW.ErrorID"] == 0x8031
    plc.change("ReadArea.ImageSize", "WriteArea.ImageSize", to=148)
    assert plc["ReadAreaW.ErrorID"] == plc["WriteAreaW.ErrorID"] == 0


@pytest.mark.parametrize("size", [0, 47, -32768])
def test_an_image_that_is_too_small_is_refused(size: int) -> None:
    """An image that is too small is refused.

    This holds even if the difference of the sizes overflows an INT.
    """
    plc = AreasBench(m=0, n=0)
    plc.change("ReadArea.ImageSize", "WriteArea.ImageSize", to=size)
    assert plc["ReadAreaW.ErrorID"] == plc["WriteAreaW.ErrorID"] == 0x8031
    assert plc["ReadArea.ErrorID"] == plc["WriteArea.ErrorID"] == 0x8031
