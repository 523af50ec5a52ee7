"""ErrorIDs, alarms and the ErrorIDs of illegal pins agree with a second reading."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from for_each import for_each
from pin_reading import every_block, refused_with
from rcx_harness import spec
from rcx_tools.library.tables import library
from second_reading import FOLDER
from structured_text.output.toml_files import load_toml

_TEXTS = load_toml(FOLDER / "pins/texts.toml")
_KEYS = ("name", "name_ja", "cause", "remedy")


def _odd(mine: Mapping[str, str], theirs: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    """Return the names that differ, and the texts without the words that they must contain."""
    for number in mine.keys() ^ theirs.keys():
        yield f"{number} is in one of table and reading only"
    for number in mine.keys() & theirs.keys():
        for key, words in zip(_KEYS, mine[number].split(" | "), strict=True):
            text = theirs[number][key]
            if words != text if key in ("name", "name_ja") else words not in text:
                yield f"{number}: {key} is {text!r}, not {words!r}"


def test_each_error_id_has_its_name_cause_and_remedy() -> None:
    """Source: docs/reference/errors.md; the signals are those of manual chapter 5, 1."""
    rows = load_toml(spec.folder() / "errors.toml")["error"]
    wrong = list(_odd(_TEXTS["error"], {f"{row['id']:04X}": row for row in rows}))
    assert not wrong, "\n".join(wrong)


def test_each_alarm_has_the_name_cause_and_remedy_of_the_manual() -> None:
    """Source: manual chapter 4, 4; remote command guide 1.1 and 4.2.1."""
    rows = load_toml(spec.folder() / "alarms.toml")["alarm"]
    wrong = list(_odd(_TEXTS["alarm"], {row["number"]: row for row in rows}))
    assert not wrong, "\n".join(wrong)


@for_each("name", every_block())
def test_each_kind_of_illegal_pin_value_has_its_error_id(name: str) -> None:
    """Each kind of illegal pin value has its ErrorID. All values of RCX_RETURN_AXES are legal.

    Source: docs/reference/errors.md, 16#8041 to 16#8046.
    """
    inputs = [one for one in library().blocks[name].inputs if one.type != "RCX_RETURN_AXES"]
    theirs = {one.pin: one.error or "16#8045" for one in inputs}
    mine = {pin: f"16#{refused_with(pin):04X}" for pin in theirs}
    assert theirs == mine


def test_each_pin_of_the_reading_is_one_of_a_block() -> None:
    """Source: docs/reference/errors.md."""
    pins: Sequence[str] = [pin for names in _TEXTS["pins"].values() for pin in names]
    there = {row.pin for block in every_block().values() for row in block.inputs}
    assert len(set(pins)) == len(pins)
    assert set(pins) <= there, set(pins) - there


def test_every_field_of_rcx_ref_named_in_a_text_exists() -> None:
    """A field of RCX_REF that a text names exists, for example `RCX_REF.Inner.Command.Holder`.

    The types are declared in plc/lib/types.
    """
    types = Path(__file__).parents[2] / "plc" / "lib" / "types"
    text = (Path(__file__).parents[2] / "spec" / "errors.toml").read_text(encoding="utf-8")
    named = set(re.findall(r"\bRCX_REF((?:\.[A-Za-z]\w*)+)", text, re.ASCII))
    assert named
    for path in named:
        kind = "RCX_REF"
        for field in path[1:].split("."):
            declared = (types / f"{kind}.st").read_text(encoding="utf-8")
            found = re.search(rf"^ +{field} +: (\w+);", declared, re.MULTILINE)
            assert found, f"RCX_REF{path}: {kind} has no {field}"
            kind = found[1]
