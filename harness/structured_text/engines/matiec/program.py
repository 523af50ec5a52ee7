"""The reference engine: ST translated by matiec's iec2c, compiled to C, scanned in process."""

from __future__ import annotations

from structured_text.engines.matiec.build import Matiec, TranslationError, Wanted, compile_program
from structured_text.engines.matiec.matiec_dialect import MatiecDialect
from structured_text.engines.matiec.source import (
    HIDDEN_INSTANCE,
    explain,
    hidden_instance,
    join_sources,
)
from structured_text.engines.native.program import NativeProgram, layout_of
from structured_text.errors import InputError
from structured_text.language.project import Project

__all__ = ["MatiecProgram"]


class MatiecProgram(NativeProgram):
    """One running instance of a program that matiec compiled; see `engines.base.Program`."""

    engine = "matiec"
    dialect = MatiecDialect()

    @classmethod
    def build(cls, project: Project, matiec: Matiec, compiler: str) -> MatiecProgram:
        """Compile a project.

        Raises:
            InputError: iec2c (with file and line) or the C compiler reports an error, or the
                priorities of the tasks require an order that matiec does not support.
        """
        _check_order(project)
        source = join_sources(project)
        instances: tuple[str, ...] = (HIDDEN_INSTANCE,)
        if project.configured:
            instances = tuple(hidden_instance(name, project) for name in project.instances)
        wanted = Wanted(
            instances=tuple(name.upper() for name in instances),
            globals=tuple(project.globals),
            layout=layout_of(project, cls.dialect),
        )
        try:
            image = compile_program(source.text, wanted, matiec, compiler)
        except TranslationError as error:
            raise explain(error, source, project, matiec) from None
        return cls(project, image)


def _check_order(project: Project) -> None:
    """Raise InputError if priorities change the declared order of programs: matiec ignores them."""
    declared = list(project.instances)
    if [run.instance for run in project.schedule] == declared:
        return
    place = next(unit for unit in project.units if unit.kind == "CONFIGURATION")
    wanted = ", ".join(run.instance for run in project.schedule)
    raise InputError(
        f"matiec runs programs as they are declared ({', '.join(declared)}), not by priority",
        file=place.file,
        line=place.line,
        hint=f"declare them in the order {wanted}",
    )
