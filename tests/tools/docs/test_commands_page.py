"""docs/reference/commands.md describes a field in the same words as `rcx decode`."""

from __future__ import annotations

from rcx_tools.docs.commands import commands_page


def _rows(command: str, field: str) -> list[str]:
    page = "\n".join(commands_page())
    part = page.partition(f"### {command}\n")[2].partition("\n### ")[0]
    return [row for row in part.splitlines() if row.startswith(f"| `{field}` |")]


def test_a_unit_is_shown_with_the_selection_that_decides_it() -> None:
    """Source: remote command guide 4.2.1: bb 01 is the direct designation in 0.01 %, 10 is %."""
    (row,) = _rows("MovePtp", "speed")
    assert row.endswith(
        "| 1 to 10000 [0.01 %] if `speed_mode` is 1; 1 to 100 [%] if `speed_mode` is 2 |"
    )
    (row,) = _rows("MoveLinear", "speed")
    assert "; 1 to 1000 [mm/s] if `speed_mode` is 3; in mm/s up to 750" in row


def test_a_unit_of_a_position_is_shown_with_its_selection() -> None:
    """Source: remote command guide 4.2.1, arch designation: bit d 0 is pulse, 1 mm."""
    (row,) = _rows("MoveArch", "arch_position")
    assert "[pulse] if `arch_unit` is 0, [0.001 mm] if `arch_unit` is 1; first target" in row


def test_no_unit_is_a_choice_where_a_field_decides() -> None:
    page = "\n".join(commands_page())
    assert "[0.01 % or %]" not in page
    assert "[0.01 %, % or mm/s]" not in page
