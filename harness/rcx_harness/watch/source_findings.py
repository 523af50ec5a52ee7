"""All warnings on the source of a program that is free of errors, for `check` and for editors."""

from __future__ import annotations

from rcx_harness.watch.calls_source import call_findings
from rcx_harness.watch.first_mistakes import first_mistakes
from rcx_harness.watch.image_source import image_use
from structured_text.language.portability import LintFinding, lint, unportable
from structured_text.language.project import Project
from structured_text.projects.sources import SourceFiles

__all__ = ["source_findings"]


def source_findings(
    sources: SourceFiles, project: Project, prefix: str
) -> list[tuple[LintFinding, str]]:
    """Return the broken rules and warnings of a program, each with the kind of its rule.

    `project` is the checked program; `prefix` is that of the names of the library's types.
    """
    users, library = sources.users
    checked = lint(sources.own, library, sources.lib, prefix=prefix)
    found = [(finding, "portability") for finding in checked]
    calls, images = call_findings(users, library), image_use(users, library).findings
    for called, rule in ((calls, "call-order"), (images, "process-image")):
        found += [(LintFinding(one.file, one.at, one.text, one.certain), rule) for one in called]
    mistakes = first_mistakes(users, library)
    found += [(LintFinding(*one, strict=False), "first-mistake") for one in mistakes]
    found += [(finding, "one-engine") for finding in unportable(project.uses, library)]
    return found
