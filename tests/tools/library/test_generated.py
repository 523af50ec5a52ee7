"""The generated command blocks differ only in pins and words, and have the names of the tables."""

from __future__ import annotations

import re

import pytest

from for_each import for_each
from plc_bench import ROOT
from rcx_harness import spec
from rcx_tools.library import files, library
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

BLOCKS = [name for name, block in library().blocks.items() if not block.handwritten]


def _parts(name: str) -> tuple[str, str, str]:
    """Return the parts of a block: the call with its request, the response, the last outputs."""
    text = (ROOT / library().blocks[name].file).read_text(encoding="utf-8")
    begin, end = text.index("  Job(Channel"), text.index("  Done := Job.Done;")
    call, found, response = text[begin:end].partition("  IF Job.Ended THEN")
    return call, found + response, text[end:]


@for_each("name", BLOCKS)
def test_all_generated_blocks_are_built_alike(name: str) -> None:
    """All generated blocks are built alike, so two of them stand for all in the fault tests."""
    call, _, end = _parts(name)
    expected_call, _, expected_end = _parts("FB_MovePtp")
    assert call in (expected_call, expected_call.replace("Trouble := Refused, ", ""))
    assert end == expected_end


@for_each("name", BLOCKS)
def test_a_block_samples_its_inputs_only_before_it_works(name: str) -> None:
    """A block samples its inputs before its command begins.

    Source: PLCopen, inputs are sampled on the rising edge.
    """
    text = (ROOT / library().blocks[name].file).read_text(encoding="utf-8")
    head, _, rest = text.partition("  IF Execute AND NOT (Job.Busy OR Job.WasExecute) THEN\n")
    after = rest.partition("\n  END_IF;\n\n  Job(")[2]
    block = library().blocks[name]
    pins = [pin.pin for pin in block.inputs] + ["RobotNumber"]
    outputs = {pin.pin for pin in block.outputs}
    assert head
    for pin in set(pins) - outputs:
        assert not re.search(rf"\b{pin}\b", after), pin


#: The chapters of the guide on commands, 4.2 to 4.9: its categories 1 to 8.
_FOLDERS = {
    "4.2": "movement",
    "4.3": "definition",
    "4.4": "arithmetic",
    "4.5": "ports",
    "4.6": "programs",
    "4.7": "data",
    "4.8": "utility",
    "4.9": "realtime",
}


@for_each("name", library().blocks)
def test_a_command_block_is_in_the_folder_of_its_category(name: str) -> None:
    """Source: remote command guide, headings of 4.2 to 4.9."""
    (file,) = (ROOT / "plc/lib").rglob(f"{name}.st")
    head = file.read_text(encoding="utf-8").partition("*)")[0]
    chapter = re.search(r"\bguide[\s*]+(4\.\d)\.", head)
    assert chapter, head
    assert file.parent == ROOT / "plc/lib/command" / _FOLDERS[chapter[1]]


def test_every_generated_file_says_from_what() -> None:
    for path in files():
        text = (ROOT / path).read_text(encoding="utf-8")
        assert "Generated from spec/blocks.toml and spec/remote_commands.toml" in text


def test_no_file_is_left_of_a_block_that_is_not_in_the_table() -> None:
    generated = {ROOT / path for path in files()}
    for file in (ROOT / "plc/lib").rglob("*.st"):
        if "Generated from spec/blocks.toml" in file.read_text(encoding="utf-8"):
            assert file in generated


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"commands": ["MovePtpp"]}, "no remote command"),
        ({"inputs": ["Pointt"]}, "there is no pin 'Pointt'"),
        ({"inputs": []}, "no pin for"),
        ({"outputs": []}, "no pin for positions"),
        ({"commands": ["MovePtp", "MoveArch"]}, "differ"),
        ({"commands": ["MovePtp", "MovePtp"]}, "several commands need"),
        ({"only": {"speed_mode": [1, 9]}}, r"are not values of speed_mode, which has \[0, 1, 2"),
        ({"only": {"speed_mode": []}}, "are not values of speed_mode"),
        ({"only": {"speedy": [1]}}, r"are not values of speedy, which has \[\]"),
        ({"echo": ["positions"]}, "no pin requests positions"),
        ({"inputs": [{"pin": "X", "type": "INT", "to": "nothing", "comment": ""}]}, "no field"),
    ],
)
def test_a_mistake_in_the_table_is_told_with_the_block(
    change: dict[str, object], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = load_toml(spec.folder() / "blocks.toml")
    entry = next(one for one in real["block"] if one["name"] == "FB_MovePtp")
    table = {**real, "block": [{**entry, **change}]}
    monkeypatch.setattr("rcx_tools.library.tables.load_toml", lambda path: table)
    library.cache_clear()
    try:
        with pytest.raises(InputError, match=f"FB_MovePtp: .*{message}"):
            library()
    finally:
        library.cache_clear()
