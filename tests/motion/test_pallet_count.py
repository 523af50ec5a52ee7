"""FB_PalletCount stores the next work position in retained data, and refuses wrong data."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import compiled

_PROGRAM = """PROGRAM Counting
  VAR
    Count : FB_PalletCount;
  END_VAR
  VAR RETAIN
    Place : INT := 1;
  END_VAR
  Count(Place := Place);
END_PROGRAM
"""


class _Pallet:
    """A bench with FB_PalletCount. With the size (), the size pins keep their defaults."""

    def __init__(self, size: tuple[int, ...], engine: str = "auto") -> None:
        self.program = compiled(_PROGRAM, engine)
        self._now_us = 0
        self.resize(size)

    def resize(self, size: tuple[int, ...]) -> None:
        for pin, value in zip(("Nx", "Ny", "Nz"), size, strict=False):
            self.put(pin, value)
        self.scan()

    def put(self, pin: str, value: int) -> None:
        self.program.write(f"Main.Count.{pin}", value)

    def scan(self) -> None:
        self.program.scan(self._now_us)
        self._now_us += 10_000

    def press(self, pin: str) -> None:
        """Set a pin to TRUE for a few scans."""
        for value in (True, True, True, False):
            self.put(pin, value)
            self.scan()

    @property
    def place(self) -> int:
        return int(self.program.read("Main.Place"))

    @place.setter
    def place(self, value: int) -> None:
        self.program.write("Main.Place", value)
        self.scan()

    @property
    def shown(self) -> tuple[str, int, int, tuple[int, ...], int]:
        """Return "Full", "Error" or "", then ErrorID, WorkPosition, its indices and Remaining."""
        pins = ("ErrorID", "WorkPosition", "IndexX", "IndexY", "IndexZ", "Remaining")
        values = [int(self.program.read(f"Main.Count.{pin}")) for pin in pins]
        on = [pin for pin in ("Full", "Error") if self.program.read(f"Main.Count.{pin}")]
        return " ".join(on), values[0], values[1], tuple(values[2:5]), values[5]


@pytest.mark.parametrize("engine", ENGINES)
def test_x_counts_first_then_y_then_z(engine: str) -> None:
    """Source: guide 4.3.3; docs/explanation/fidelity.md, the order of the work positions."""
    pallet = _Pallet((3, 2, 2), engine)
    seen = []
    for k in range(1, 13):
        shown, error_id, position, where, remaining = pallet.shown
        assert (shown, error_id, position, pallet.place, remaining) == ("", 0, k, k, 13 - k)
        seen.append(where)
        pallet.press("Next")
    assert seen == [(x, y, z) for z in (1, 2) for y in (1, 2) for x in (1, 2, 3)]
    assert pallet.shown == ("Full", 0, 0, (0, 0, 0), 0)
    pallet.press("Next")
    assert (pallet.place, pallet.shown[0]) == (0, "Full"), "the pallet stays full"
    pallet.press("NewPallet")
    assert pallet.shown == ("", 0, 1, (1, 1, 1), 12)


def test_newpallet_selects_position_1_at_any_time() -> None:
    """NewPallet selects work position 1 at any time, even in the scan of an edge of Next.

    Source: a rule of this library.
    """
    pallet = _Pallet((2, 2, 1))
    pallet.press("Next")
    pallet.press("Next")
    assert pallet.place == 3
    pallet.put("NewPallet", True)
    pallet.press("Next")
    assert pallet.place == 1
    pallet.press("Next")
    assert pallet.place == 2, "a button that is held counts once"


@pytest.mark.parametrize("kept", [7, -1, 32767, -32768])
def test_a_position_beyond_the_pallet_is_an_error(kept: int) -> None:
    """A stored position beyond the pallet is an error, which only NewPallet ends.

    A changed program may have a smaller pallet.

    Source: a rule of this library.
    """
    pallet = _Pallet((3, 2, 1))
    pallet.place = kept
    wrong = ("Error", 0x805C, 0, (0, 0, 0), 0)
    assert pallet.shown == wrong
    pallet.press("Next")
    assert (pallet.place, pallet.shown) == (kept, wrong)
    pallet.press("NewPallet")
    assert pallet.shown == ("", 0, 1, (1, 1, 1), 6)


def test_a_position_of_0_counts_as_a_full_pallet() -> None:
    """A stored position of 0, as in cleared memory, counts as a full pallet.

    0 is not a work position, so no part may be placed.
    """
    pallet = _Pallet((3, 2, 1))
    pallet.place = 0
    assert pallet.shown[0] == "Full"


@pytest.mark.parametrize(
    "size",
    [
        *((0, 1, 1), (1, 0, 1), (1, 1, 0), (-3, -2, 1), (182, 181, 1), (16384, 2, 1)),
        *((32767, 32767, 32767), (32767, 1, 2)),
        (26217, 32765, 5),  # 2**32 + 32729, which is 32729 in 32 bits
        *((-5, 29308, 29309), (29308, -5, 29309)),  # 26436 - 2**32
    ],
)
def test_an_illegal_size_of_the_pallet_is_refused(size: tuple[int, int, int]) -> None:
    """Source: guide 4.3.3: the product is 1 to 32767."""
    pallet = _Pallet(size)
    assert pallet.shown == ("Error", 0x8045, 0, (0, 0, 0), 0)
    pallet.press("Next")
    pallet.press("NewPallet")
    assert (pallet.place, pallet.shown[:2]) == (1, ("Error", 0x8045))
    pallet.place = 0
    assert pallet.shown[0] == "Error"


@pytest.mark.parametrize("size", [(), (1, 1, 1)])
def test_a_pallet_may_have_one_position(size: tuple[int, ...]) -> None:
    """Source: guide 4.3.3: each size is at least 1."""
    pallet = _Pallet(size)
    assert pallet.shown == ("", 0, 1, (1, 1, 1), 1)
    pallet.press("Next")
    assert pallet.shown == ("Full", 0, 0, (0, 0, 0), 0)


def test_a_size_that_becomes_illegal_is_refused_at_once() -> None:
    """If a size becomes illegal, the block reports an error at once.

    It does not continue with the earlier sizes. Source: guide 4.3.3.
    """
    pallet = _Pallet((3, 2, 1))
    pallet.resize((0, 2, 1))
    assert pallet.shown == ("Error", 0x8045, 0, (0, 0, 0), 0)
    pallet.resize((3, 2, 1))
    assert pallet.shown == ("", 0, 1, (1, 1, 1), 6)


@pytest.mark.parametrize("size", [(32767, 1, 1), (1, 217, 151), (7, 31, 151)])
def test_the_largest_pallet_is_counted_to_the_end(size: tuple[int, int, int]) -> None:
    """Source: guide 4.3.3: the product is at most 32767 = 7 * 31 * 151."""
    pallet = _Pallet(size)
    pallet.place = 32767
    assert pallet.shown == ("", 0, 32767, size, 1)
    pallet.press("Next")
    assert (pallet.place, pallet.shown[0]) == (0, "Full")


@pytest.mark.parametrize("pin", ["NewPallet", "Next"])
def test_a_pin_that_is_true_at_the_start_of_the_plc_changes_no_position(pin: str) -> None:
    """A pin that is TRUE when the PLC starts does not change the stored work position.

    A stuck button must not select position 1 again or skip a position.

    Source: the block keeps the place through a loss of power.
    """
    program = compiled(_PROGRAM, "builtin")
    program.write("Main.Place", 4)
    for axis in ("Nx", "Ny"):
        program.write(f"Main.Count.{axis}", 3)
    program.write(f"Main.Count.{pin}", True)
    for now_us in range(0, 50_000, 10_000):
        program.scan(now_us)
    assert program.read("Main.Place") == 4
