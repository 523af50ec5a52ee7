"""Results are saved as soon as they exist, and results of other sources are refused."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from farm_work import Killed, noted, refuse
from structured_text.errors import InputError
from structured_text.farm import Farm, Lost, ResultFile

ABOUT = {"sources": "a1b2"}


def kept(file: Path, about: dict[str, str] = ABOUT, **options: Any) -> ResultFile[Any, Any]:
    """Open a file of results."""
    return ResultFile(file, about, **options)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the path of the result file, which does not exist yet."""
    return tmp_path / "out" / "results.jsonl"


@pytest.mark.parametrize("workers", [0, 2])
def test_a_known_item_is_not_repeated(tmp_path: Path, file: Path, workers: int) -> None:
    done = tmp_path / "done"
    items = [(str(done), number) for number in range(6)]
    first = list(Farm(workers).run(noted, items[1:4], kept=kept(file)))
    assert first == [(item, item[1] * 10) for item in items[1:4]]
    assert sorted(done.read_text().split()) == ["1", "2", "3"]
    again = list(Farm(workers).run(noted, items, kept=kept(file)))
    assert again == [(item, item[1] * 10) for item in items]
    assert sorted(done.read_text().split()) == ["0", "1", "2", "3", "4", "5"]


def test_items_with_the_same_key_run_once(tmp_path: Path, file: Path) -> None:
    """Items with the same key run once, and each of them gets the result.

    Source: two ranges of seeds that overlap.
    """
    done = tmp_path / "done"
    items = [(str(done), number) for number in (1, 2, 3, 2, 3, 4)]
    found = list(Farm(2).run(noted, items, kept=kept(file)))
    assert found == [(item, item[1] * 10) for item in items]
    assert sorted(done.read_text().split()) == ["1", "2", "3", "4"]


def test_an_early_end_keeps_the_finished_results(tmp_path: Path, file: Path) -> None:
    done = tmp_path / "done"
    items = [(str(done), number) for number in range(6)]
    running = Farm(0).run(noted, items, kept=kept(file))
    assert [next(running) for _ in range(2)] == [(items[0], 0), (items[1], 10)]
    running.close()
    assert done.read_text().split() == ["0", "1"]
    assert len(list(Farm(0).run(noted, items, kept=kept(file)))) == 6
    assert done.read_text().split() == ["0", "1", "2", "3", "4", "5"]


def test_an_error_is_not_kept_and_the_results_before_it_are(file: Path) -> None:
    for _ in range(2):
        with pytest.raises(InputError, match="no such pin"):
            list(Farm(0).run(refuse, range(4), kept=kept(file)))
    assert [json.loads(line)["key"] for line in file.read_text().splitlines()] == ["", "0", "1"]


@pytest.mark.exhaustive
def test_a_lost_item_is_tried_again_by_the_next_call(tmp_path: Path, file: Path) -> None:
    folder = tmp_path / "deaths"
    folder.mkdir()
    for number in range(3):
        (folder / str(number)).touch()

    def lost(one: Lost[int]) -> int:
        return -1

    assert list(Farm(1).run(Killed(folder), [3], kept=kept(file), lost=lost)) == [(3, -1)]
    assert list(Farm(1).run(Killed(folder), [3], kept=kept(file), lost=lost)) == [(3, 30)]


def test_new_results_have_the_same_form_as_results_from_the_file(file: Path) -> None:
    def back(value: list[int]) -> tuple[int, ...]:
        return tuple(value)

    for _ in range(2):
        in_file = kept(file, to_json=list, from_json=back)
        found = Farm(0).run(divmod_by_3, [7], kept=in_file)
        assert list(found) == [(7, (2, 1))]


def divmod_by_3(item: int) -> tuple[int, int]:
    """Return quotient and remainder of a division by 3."""
    return divmod(item, 3)


def test_results_of_other_sources_are_refused_with_what_differs(file: Path) -> None:
    kept(file, {"sources": "a1b2", "engine": "matiec"})
    with pytest.raises(InputError) as caught:
        kept(file, {"sources": "c3d4", "engine": "matiec", "scan": "10ms"})
    assert str(caught.value) == (
        f"{file}: contains results of other sources or options: sources a1b2 there, c3d4 now, "
        "scan none there, 10ms now; name another file, or remove this one to begin anew"
    )
    assert kept(file, {"sources": "c3d4"}, fresh=True).knows(1) is False
    assert json.loads(file.read_text())["about"] == {"sources": "c3d4"}


@pytest.mark.parametrize("content", ["PROGRAM Main\n", '{"t_us": 5}\n', "[1]\n", "\xff\xfe"])
@pytest.mark.parametrize("fresh", [False, True])
def test_a_file_of_the_users_is_left_as_it_is(tmp_path: Path, content: str, fresh: bool) -> None:
    file = tmp_path / "mine"
    file.write_text(content, encoding="latin-1")
    with pytest.raises(InputError, match="is not a file of results; nothing was written"):
        kept(file, fresh=fresh)
    assert file.read_text(encoding="latin-1") == content


def test_a_line_that_was_cut_off_is_done_again(tmp_path: Path, file: Path) -> None:
    done = tmp_path / "done"
    items = [(str(done), number) for number in range(2)]
    list(Farm(0).run(noted, items, kept=kept(file)))
    file.write_bytes(file.read_bytes()[:-5])
    assert [one for _, one in Farm(0).run(noted, items, kept=kept(file))] == [0, 10]
    assert done.read_text().split() == ["0", "1", "1"]


@pytest.mark.parametrize(
    "damage", [b"\xff\x00", b'{"key": "1"}', b"[1]", b'{"key": 5, "result": 1}', b"[" * 99_999, b""]
)
def test_a_damaged_line_is_redone_and_the_file_saved(file: Path, damage: bytes) -> None:
    """An item with a damaged line runs again; the damaged file is saved beside the new one.

    A notice gives the name of the damaged file.
    """
    list(Farm(0).run(divmod_by_3, range(3), kept=kept(file)))
    lines = file.read_bytes().split(b"\n")
    lines[2] = damage
    file.write_bytes(b"\n".join(lines))
    found = kept(file)
    aside = file.with_name("results.jsonl.damaged")
    assert found.notice.startswith(f"{file}: 1 line is damaged; the file is now {aside}, ")
    assert aside.read_bytes() == b"\n".join(lines)
    assert [found.knows(number) for number in range(3)] == [True, False, True]
    assert kept(file).notice == "", "the file is complete again"


def test_a_result_file_without_its_first_line_is_moved_aside(file: Path) -> None:
    """A result file with a damaged first line is renamed, and never replaces an earlier one."""
    list(Farm(0).run(divmod_by_3, range(3), kept=kept(file)))
    before = b"x" + file.read_bytes()
    for name in ("results.jsonl.damaged", "results.jsonl.damaged1"):
        file.write_bytes(before)
        found = kept(file)
        assert "its first line is damaged" in found.notice
        assert file.with_name(name).read_bytes() == before, (
            "an earlier damaged file is not replaced"
        )
        assert not found.knows(0)


def test_a_result_that_cannot_be_read_back_is_done_again(file: Path) -> None:
    def back(value: list[int]) -> tuple[int, ...]:
        return tuple(value)

    list(Farm(0).run(divmod_by_3, [1], kept=kept(file, to_json=list, from_json=back)))
    file.write_text(file.read_text().replace("[0, 1]", "5"))
    found = kept(file, to_json=list, from_json=back)
    assert "1 line is damaged" in found.notice
    assert not found.knows(1)


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder, not a file; name a file"):
        kept(tmp_path)


def test_the_progress_counts_what_was_known(tmp_path: Path, file: Path) -> None:
    items = [(str(tmp_path / "done"), number) for number in range(3)]
    list(Farm(0).run(noted, items[:2], kept=kept(file)))
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=100)
    list(Farm(0, console=console).run(noted, items, kept=kept(file), title="seeds"))
    assert "seeds" in shown.getvalue()
    assert "2/3" in shown.getvalue()
    assert "3/3" in shown.getvalue()
