"""Queues, sequencers, FAL, FSC and SWPB in ladder routines of an L5X.

Expected values are computed by hand from Rockwell 1756-RM003N and the help of Studio 5000.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import main_body, program, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_TAGS = {"ctl": "CONTROL", "small": "INT[3]", "pairs": "TIMER[3]", "tm": "TIMER", "tn": "TIMER"}


class _Run:
    """A program whose rungs have the power of `a`, scan by scan."""

    def __init__(self, folder: Path, *rungs: str, length: int = 0, **values: int) -> None:
        self.program: BuiltinProgram = program(written(folder, rungs, tags=_TAGS))
        self._scans = 0
        if length:
            self.set(**{"ctl.LEN": length})
        self.set(**values)

    def set(self, **values: int) -> None:
        for name, value in values.items():
            self.program.write(f"Main.{name}", value)

    def scan(self, power: bool = False) -> None:
        self.program.write("Main.a", power)
        self.program.scan(self._scans * 10_000)
        self._scans += 1

    def pulse(self) -> None:
        self.scan(True)
        self.scan(False)

    def read(self, *names: str) -> list[object]:
        return [self.program.read(f"Main.{name}") for name in names]

    def bits(self, *names: str) -> list[object]:
        return self.read(*(f"ctl.{name}" for name in names))

    def list(self, count: int) -> list[object]:
        return self.read(*(f"list[{number}]" for number in range(count)))


def test_a_queue_gives_its_oldest_value(tmp_path: Path) -> None:
    """Load 5, 6, 7 into a queue of three, unload two: 5, then 6; then 7 is at the front."""
    run = _Run(tmp_path, "XIC(a)FFL(i,list,ctl,?,?);", "XIC(b)FFU(list,j,ctl,?,?);", length=3)
    run.scan()
    assert run.bits("EM", "DN", "POS") == [True, False, 0]
    for value in (5, 6, 7):
        run.set(i=value)
        run.pulse()
    assert run.list(4) == [5, 6, 7, 0]
    assert run.bits("EM", "DN", "POS") == [False, True, 3]
    run.set(i=8)
    run.pulse()  # it is full
    assert run.list(4) == [5, 6, 7, 0]
    run.set(b=True)
    run.scan()
    assert run.read("j") == [5]
    run.scan()  # the power is no edge
    assert [run.list(3), run.bits("EU", "POS")] == [[6, 7, 0], [True, 2]]


def test_an_empty_queue_gives_0(tmp_path: Path) -> None:
    """Source: Studio 5000 help, FFU."""
    run = _Run(tmp_path, "XIC(a)FFU(list,j,ctl,?,?);", length=3, j=4)
    run.scan()
    run.scan(True)
    assert [run.read("j"), run.bits("EM", "POS")] == [[0], [True, 0]]


def test_a_stack_gives_its_newest_value(tmp_path: Path) -> None:
    """Load 5 and 6, unload 6; its place becomes 0. Source: RM003N, page 429."""
    run = _Run(tmp_path, "XIC(a)LFL(i,list,ctl,?,?);", "XIC(b)LFU(list,j,ctl,?,?);", length=3)
    run.scan()
    for value in (5, 6):
        run.set(i=value)
        run.pulse()
    run.set(b=True)
    run.scan()
    assert [run.read("j"), run.list(3), run.bits("POS", "EM")] == [[6], [5, 0, 0], [1, False]]


def test_power_in_the_first_scan_does_not_load(tmp_path: Path) -> None:
    """The prescan sets EN to prevent a false load. A length in the rung is that of the tag."""
    run = _Run(tmp_path, "XIC(a)FFL(7,small,ctl,3,0);")
    run.scan(True)
    assert run.bits("POS", "LEN") == [0, 3]
    run.scan(False)
    run.scan(True)
    assert [run.read("small[0]"), run.bits("POS")] == [[7], [1]]


@pytest.mark.exhaustive
def test_a_queue_of_structures(tmp_path: Path) -> None:
    """A timer goes in and comes out with its members."""
    run = _Run(tmp_path, "XIC(a)FFL(tm,pairs,ctl,?,?);", "XIC(b)FFU(pairs,tn,ctl,?,?);", length=3)
    run.scan()
    run.set(**{"tm.PRE": 250})
    run.pulse()
    run.set(b=True)
    run.scan()
    assert run.read("tn.PRE", "pairs[0].PRE") == [250, 0]


@pytest.mark.exhaustive
def test_a_queue_without_a_length_is_full_and_empty(tmp_path: Path) -> None:
    """Source: Studio 5000 help, FFL: EM and DN are set if LEN is 0 or less."""
    run = _Run(tmp_path, "XIC(a)FFL(i,list,ctl,?,?);", i=5)
    run.scan()
    run.scan(True)
    assert [run.bits("EM", "DN", "POS"), run.list(1)] == [[True, True, 0], [0]]


def test_a_sequencer_steps_from_its_length_to_1(tmp_path: Path) -> None:
    """Position 1, 2, then 1 again. The mask passes the low byte; the upper bits of i stay.

    Source: RM003N, page 442.
    """
    run = _Run(tmp_path, "XIC(a)SQO(list,16#FF,i,ctl,?,?);", length=2, i=0x1200)
    run.set(**{"list[1]": 0x3F1, "list[2]": 0x3F2})
    run.scan(True)  # the prescan has set EN, so that position 0 is written
    assert [run.read("i"), run.bits("POS", "DN")] == [[0x1200], [0, False]]
    found = []
    for _ in range(3):
        run.scan(False)
        run.scan(True)
        found += [run.read("i")[0], *run.bits("POS", "DN")]
    assert found == [0x12F1, 1, False, 0x12F2, 2, True, 0x12F1, 1, False]


@pytest.mark.exhaustive
def test_a_sequencer_without_a_length_sets_er(tmp_path: Path) -> None:
    run = _Run(tmp_path, "XIC(a)SQO(list,-1,i,ctl,?,?);", "XIC(a)SQI(list,-1,j,ctl,?,?)OTE(c);")
    run.scan(True)
    assert [run.bits("ER"), run.read("c")] == [[True], [False]]


def test_a_sequencer_compares_its_position(tmp_path: Path) -> None:
    """Element 1 is 16#0F; the mask 16#0F ignores the upper bits of the source 16#AF."""
    run = _Run(tmp_path, "XIC(a)SQI(list,16#0F,i,ctl,?,?)OTE(c);", length=2, i=0xAF)
    run.set(**{"list[1]": 0x0F, "ctl.POS": 1})
    run.scan(True)
    assert run.read("c") == [True]
    run.set(i=0xAE)
    run.scan(True)
    assert run.read("c") == [False]
    run.set(i=0xAF)
    run.scan(False)
    assert run.read("c") == [False]


def test_a_sequencer_loads_its_array(tmp_path: Path) -> None:
    """-1 of a SINT is -1 in the array. Source: RM003N, page 446."""
    run = _Run(tmp_path, "XIC(a)SQL(list,s,ctl,?,?);", length=3, s=-1)
    run.scan(False)
    run.scan(True)
    assert [run.list(3), run.bits("POS", "DN")] == [[0, -1, 0], [1, False]]


def test_fal_in_all_mode_calculates_all_elements_at_once(tmp_path: Path) -> None:
    """list[k] = k * 10, once at the rising edge; POS and DN are cleared without power."""
    run = _Run(tmp_path, "XIC(a)FAL(ctl,?,?,ALL,list[ctl.POS],ctl.POS*10);", length=4)
    run.scan()
    run.scan(True)
    assert [run.list(5), run.bits("POS", "DN", "EN")] == [[0, 10, 20, 30, 0], [4, True, True]]
    run.set(**{"list[1]": 7})
    run.scan(True)
    assert run.list(3) == [0, 7, 20]
    run.scan(False)
    assert run.bits("POS", "DN", "EN") == [0, False, False]


def test_fal_with_a_number_goes_on_without_power(tmp_path: Path) -> None:
    """Two elements in each scan: 2, 4, 5. EN falls with the end, DN and POS one scan later."""
    run = _Run(tmp_path, "XIC(a)FAL(ctl,?,?,2,list[ctl.POS],9);", length=5)
    run.scan()
    states = []
    for power in (True, False, False, False):
        run.scan(power)
        states.append(run.bits("POS", "EN", "DN"))
    assert states == [[2, True, False], [4, True, False], [5, False, True], [0, False, False]]
    assert run.list(6) == [9, 9, 9, 9, 9, 0]


def test_fal_in_inc_mode_calculates_an_element_at_each_edge(tmp_path: Path) -> None:
    run = _Run(tmp_path, "XIC(a)FAL(ctl,?,?,INC,list[ctl.POS],9);", length=2)
    run.scan()
    run.scan(True)
    run.scan(True)
    assert [run.list(3), run.bits("POS", "DN")] == [[9, 0, 0], [1, False]]
    run.scan(False)
    run.scan(True)
    assert [run.list(3), run.bits("POS", "DN")] == [[9, 9, 0], [2, True]]
    run.scan(False)
    assert run.bits("POS", "DN", "EN") == [0, False, False]


def test_fsc_stops_at_each_element_that_fits(tmp_path: Path) -> None:
    """Elements 1 and 3 are 7. IN must be cleared to go on; the end is DN without FD."""
    run = _Run(tmp_path, "XIC(a)FSC(ctl,?,?,ALL,list[ctl.POS]=7);", length=5)
    run.set(**{"list[1]": 7, "list[3]": 7})
    run.scan()
    states = []
    for clear in (False, False, True, True):
        if clear:
            run.set(**{"ctl.IN": False})
        run.scan(True)
        states.append(run.bits("POS", "FD", "IN", "DN"))
    assert states == [
        [1, True, True, False],
        [1, True, True, False],
        [3, True, True, False],
        [5, False, False, True],
    ]


@pytest.mark.parametrize(("mode", "positions"), [("2", [2, 3, 3]), ("INC", [1, 1, 2])])
def test_fsc_in_parts(tmp_path: Path, mode: str, positions: list[int]) -> None:
    """Element 3 fits. Two elements in a scan find it in the second; INC needs an edge for each."""
    run = _Run(tmp_path, f"XIC(a)FSC(ctl,?,?,{mode},list[ctl.POS]=7);", length=5)
    run.set(**{"list[3]": 7})
    run.scan()
    found = []
    for power in (True, False, True):
        run.scan(power)
        found += run.bits("POS")
    assert found == positions


@pytest.mark.exhaustive
def test_fsc_after_res_begins_again(tmp_path: Path) -> None:
    """RES in front of FSC lets it search in each scan."""
    rung = "[RES(ctl)SIZE(list,0,ctl.LEN),FSC(ctl,?,?,ALL,list[ctl.POS]=i),XIC(ctl.FD)OTE(c)];"
    run = _Run(tmp_path, rung, i=4)
    run.set(**{"list[6]": 4})
    run.scan()
    assert [run.bits("POS"), run.read("c")] == [[6], [True]]
    run.set(i=5)
    run.scan()
    assert [run.bits("POS", "DN"), run.read("c")] == [[8, True], [False]]


@pytest.mark.exhaustive(but=["REVERSE-67305985"])
@pytest.mark.parametrize(
    ("order", "value"),
    [("REVERSE", 0x04030201), ("WORD", 0x03040102), ("HIGH/LOW", 0x02010403), ("2", 0x02010403)],
)
def test_swpb_rearranges_bytes(tmp_path: Path, order: str, value: int) -> None:
    """ABCD becomes DCBA, CDAB or BADC. Source: Studio 5000 help, SWPB."""
    run = _Run(tmp_path, f"SWPB(i,{order},j);", i=0x01020304)
    run.scan()
    assert run.read("j") == [value]


def test_swpb_of_an_int_extends_its_sign(tmp_path: Path) -> None:
    """16#0180 becomes 16#8001, which is -32767 as INT and as DINT; in an array it is a word."""
    run = _Run(tmp_path, "SWPB(v,WORD,w);", "SWPB(v,REVERSE,j);", "SWPB(v,WORD,small[1]);", v=384)
    run.scan()
    assert run.read("w", "j", "small[1]") == [-32767, -32767, 0x8001]


@pytest.mark.parametrize(
    ("rung", "why"),
    [
        ("FAL(ctl,?,?,SOME,list[0],1);", "SOME is not a mode"),
        ("FSC(ctl,?,?,ALL,1);", "the expression of FSC is a DINT, not a comparison"),
        ("FFL(i,j,ctl,?,?);", "j is not an array with one dimension"),
        ("SQO(small,1,i,ctl,?,?);", "small is not an array of DINT"),
        ("SWPB(i,LEFT,j);", "LEFT is not an order of bytes"),
        ("SWPB(x,WORD,y);", "a whole number is needed here, not REAL"),
    ],
)
def test_a_wrong_operand_is_named(tmp_path: Path, rung: str, why: str) -> None:
    body = main_body(written(tmp_path, [rung], tags=_TAGS))
    assert isinstance(body, Foreign)
    assert f"rung 0: {why}" in body.why


def test_the_prescan_of_fal_does_what_it_does_without_power(tmp_path: Path) -> None:
    """A FAL that was done with power begins again in the first scan; the given length stays."""
    run = _Run(tmp_path, "XIC(a)FAL(ctl,6,0,ALL,list[ctl.POS],9);", length=2)
    run.set(**{"ctl.EN": True, "ctl.DN": True, "ctl.POS": 2})
    run.scan(True)
    assert [run.list(3), run.bits("POS", "DN", "LEN")] == [[9, 9, 0], [2, True, 2]]
