"""A second cell of the same program is not compiled again, and has no data of earlier cells."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError
from structured_text.engines.builtin.collector import collecting
from structured_text.engines.builtin.program import BuiltinProgram

_TEXT = """PROGRAM Main
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Count, Part : INT := 1;
    Seen : ARRAY [1..3] OF INT := [{first}, 2, 3];
    Delay : TON;
  END_VAR
  Count := Count + 12 / Part;
  Seen[2] := Count;
  Delay(IN := TRUE, PT := T#20ms);
END_PROGRAM
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """Return a program with a counter, an array, a timer and a division."""
    file = tmp_path / "Main.st"
    file.write_text(_TEXT.format(first=1), encoding="utf-8")
    return file


def _cell(program: Path, **options: str) -> Cell:
    return Cell.build(program, engine="builtin", **options)  # type: ignore[arg-type]


def _state(cell: Cell) -> list[object]:
    return [cell[f"Main.{name}"] for name in ("Count", "Part", "Seen", "Delay.ET", "Delay.Q")]


def test_a_further_cell_is_not_compiled_again(
    program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next cell uses the compiled program of a closed cell. Source: cell.compiled."""
    if collecting():
        pytest.skip("while coverage is counted, each cell has a program of its own")
    made = []
    build = BuiltinProgram.__init__

    def counted(self: BuiltinProgram, *arguments: object) -> None:
        made.append(self)
        build(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(BuiltinProgram, "__init__", counted)
    for _ in range(3):
        with _cell(program) as cell:
            cell.scan()
    assert len(made) == 1


def test_a_further_cell_begins_in_the_initial_state(program: Path) -> None:
    with _cell(program) as cell:
        first = _state(cell)
        cell["Main.Part"] = 4
        cell["Main.Seen"] = [7, 8, 9]
        cell.run("100ms")
        assert _state(cell) != first
    with _cell(program) as cell:
        assert _state(cell) == first
        cell.scan()
        assert cell["Main.Seen"] == [1, 13, 3]


def test_after_an_error_a_further_cell_begins_in_the_initial_state(program: Path) -> None:
    with _cell(program) as cell:
        first = _state(cell)
        cell["Main.Part"] = 0
        with pytest.raises(InputError, match="zero"):
            cell.scan()
    with _cell(program) as cell:
        assert _state(cell) == first


def test_two_cells_at_the_same_time_are_independent(program: Path) -> None:
    with _cell(program) as one, _cell(program) as other:
        one.scan(3)
        assert (one["Main.Count"], other["Main.Count"]) == (37, 1)
    with _cell(program) as one, _cell(program) as other:
        other.scan()
        assert (one["Main.Count"], other["Main.Count"]) == (1, 13)


def test_a_closed_cell_cannot_change_the_next_cell(program: Path) -> None:
    with _cell(program) as closed:
        pass
    with _cell(program) as cell:
        with pytest.raises(InputError, match="closed"):
            closed["Main.Count"] = 5
        with pytest.raises(InputError, match="closed"):
            closed.scan()
        closed.close()
        assert cell["Main.Count"] == 1


def test_a_changed_source_is_compiled_again(program: Path) -> None:
    """A source with new content is compiled again, even if its time and its size are the same."""
    with _cell(program) as cell:
        assert cell["Main.Seen"] == [1, 2, 3]
    seen = program.stat()
    program.write_text(_TEXT.format(first=9), encoding="utf-8")
    os.utime(program, ns=(seen.st_atime_ns, seen.st_mtime_ns))
    with _cell(program) as cell:
        assert cell["Main.Seen"] == [9, 2, 3]


def test_added_and_removed_sources_of_a_folder_are_noticed(tmp_path: Path) -> None:
    """The next cell uses source files that were added to a folder, and no removed ones."""
    (tmp_path / "Main.st").write_text(
        _TEXT.format(first=1).replace("12 / Part", "FC_One()"), encoding="utf-8"
    )
    with pytest.raises(InputError, match="FC_One"):
        _cell(tmp_path)
    one = tmp_path / "more" / "FC_One.st"
    one.parent.mkdir()
    one.write_text("FUNCTION FC_One : INT\n  FC_One := 5;\nEND_FUNCTION\n", encoding="utf-8")
    with _cell(tmp_path) as cell:
        cell.scan()
        assert cell["Main.Count"] == 6
    one.unlink()
    with pytest.raises(InputError, match="FC_One"):
        _cell(tmp_path)
