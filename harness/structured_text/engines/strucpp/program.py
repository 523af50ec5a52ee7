"""A second compiled engine: ST translated by STruC++, compiled to C++17, scanned in process."""

from __future__ import annotations

import ctypes

from structured_text.engines.native.program import NativeProgram, layout_of
from structured_text.engines.strucpp.build import Strucpp, compile_project
from structured_text.engines.strucpp.start import check_start
from structured_text.engines.strucpp.strucpp_dialect import StrucppDialect
from structured_text.errors import InputError
from structured_text.language.project import Project

__all__ = ["StrucppProgram"]


class StrucppProgram(NativeProgram):
    """One running instance of a program that STruC++ compiled; see `engines.base.Program`."""

    engine = "strucpp"

    def __init__(self, project: Project, image: bytes) -> None:
        self.dialect = _dialect(project)
        super().__init__(project, image)

    @classmethod
    def build(cls, project: Project, strucpp: Strucpp, compiler: str) -> StrucppProgram:
        """Compile a project.

        Raises:
            InputError: STruC++ or the C++ compiler reports an error (with file and line), or the
                program does not start with the values of its sources.
        """
        layout = layout_of(project, _dialect(project))
        program = cls(project, compile_project(project, layout, strucpp, compiler))
        check_start(project, program.read)
        return program

    def check(self, library: ctypes.PyDLL) -> None:
        """Raise InputError if this version of STruC++ represents values in an unknown way."""
        if not library.shim_is_as_expected():
            raise InputError(
                "this version of STruC++ stores its variables in an unknown way",
                hint="use --engine builtin or matiec, or another version of STruC++",
            )


def _dialect(project: Project) -> StrucppDialect:
    return StrucppDialect(frozenset(block.name.upper() for block in project.instances.values()))
