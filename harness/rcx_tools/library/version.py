"""Generator of FC_LibraryVersion, which returns the version of pyproject.toml as a number."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["version", "version_files", "version_number"]

_PROJECT = Path(__file__).resolve().parents[3] / "pyproject.toml"
_PARTS = 3
_BELOW = 100

_TEXT = """\
(*
 * FC_LibraryVersion: return the version of these blocks (not in the manual).
 *
 * Write the result to a DINT that your panel shows. A changed pin raises the minor number before
 * version 1.0, and the major number after it.
 *
 * Generated from pyproject.toml by `make docs`.
 *
 * Tests: tests/diagnosis/test_library_version.py
 *)
FUNCTION FC_LibraryVersion : DINT
  VAR_INPUT
    Part : INT;  (* 0 = all: {number} is {text}, 10203 is 1.2.3; 1 = major, 2 = minor, 3 = patch *)
  END_VAR

  CASE Part OF
    0: FC_LibraryVersion := {number};  (* {text} *)
    1: FC_LibraryVersion := {parts[0]};
    2: FC_LibraryVersion := {parts[1]};
    3: FC_LibraryVersion := {parts[2]};
  ELSE
    FC_LibraryVersion := -1;
  END_CASE;
END_FUNCTION
"""


def version_files() -> dict[str, Callable[[], str]]:
    """Return the generator of FC_LibraryVersion, by the path of the file in the repository."""
    return {"plc/lib/diagnosis/FC_LibraryVersion.st": _function}


def version() -> str:
    """Return the version of the next release."""
    return str(load_toml(_PROJECT)["project"]["version"])


def version_number(text: str) -> tuple[int, ...]:
    """Return major, minor and patch of a version.

    Raises:
        InputError: the version does not consist of three numbers below 100.
    """
    parts = [int(one) for one in re.findall(r"\d+", text)]
    if text != ".".join(map(str, parts)) or len(parts) != _PARTS or max(parts) >= _BELOW:
        raise InputError(
            f"version {text!r} is not of the form 1.2.3 with numbers below {_BELOW}",
            hint="FC_LibraryVersion gives it as one number: 10203",
        )
    return tuple(parts)


def _function() -> str:
    text = version()
    parts = version_number(text)
    number = (parts[0] * _BELOW + parts[1]) * _BELOW + parts[2]
    return _TEXT.format(number=number, text=text, parts=parts)
