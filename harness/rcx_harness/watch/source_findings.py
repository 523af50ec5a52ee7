"""All warnings on the source of a program that is free of errors, for `check` and for editors."""

from __future__ import annotations

from rcx_harness.watch.source_warnings import DEFAULT_RPI_US, source_warnings
from structured_text.language.portability import LintFinding, lint, unportable
from structured_text.language.project import Project
from structured_text.projects.sources import SourceFiles

__all__ = ["source_findings"]


def source_findings(
    sources: SourceFiles, project: Project, prefix: str, rpi_us: int = DEFAULT_RPI_US
) -> list[tuple[LintFinding, str]]:
    """Return the broken rules and warnings of a program, each with the kind of its rule.

    `project` is the checked program; `prefix` is that of the names of the library's types. `rpi_us`
    is the packet interval that the pins `Timeout` and `Margin` must suit.
    """
    users, library = sources.users
    checked = lint(sources.own, library, sources.lib, prefix=prefix)
    found = [(finding, "portability") for finding in checked]
    for one in source_warnings(users, library, rpi_us):
        text = f"{one.text} (see {one.page})"
        found.append((LintFinding(one.file, one.at, text, one.certain), one.rule))
    found += [(finding, "one-engine") for finding in unportable(project.uses, library)]
    return found
