"""From PLCopen TC6 XML 2.01 back to Structured Text: a file per type, POU and configuration."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

from plcopen_structure import check_structure
from structured_text.errors import InputError
from structured_text.export.output import Output
from structured_text.projects.open import read_project
from structured_text.projects.texts import st_texts

__all__ = ["read_plcopen"]


def read_plcopen(file: Path) -> Output:
    """Read a project as `rcx import` does, after a check of its structure.

    Raises:
        InputError: the file cannot be read, is no such project, or has a body in another
            language.
    """
    try:
        check_structure(ET.fromstring(file.read_bytes()))
    except (ET.ParseError, OSError):
        pass  # told by what reads it
    except InputError as error:
        raise InputError(error.message, file=file, hint=error.hint) from None
    return Output(st_texts(read_project([file])))
