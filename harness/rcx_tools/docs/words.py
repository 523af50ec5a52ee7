"""Generator of the page about the Structured Text of each tool, from the lists of the exporters."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.export.refused import tools
from structured_text.export.words import FOLDER, Form, Words, words
from structured_text.language.constructs import CONSTRUCTS
from structured_text.output.toml_files import load_toml

__all__ = ["entry_sources", "words_page"]

_ABOUT = """\
What `rcx export` writes for a function, a block or an operator of IEC 61131-3, and what says that
the tool has it. What is not here for a target is refused when it is written, with file and line.
*Not confirmed* means that no public list could be read. See [export.md](../how-to/export.md).

A parameter that ends in `:=` is written by name, others stand by position; `...` goes on like the
one before it; a sign stands between the operands."""

_LISTS = {
    "logix": "`l5x`: Rockwell Studio 5000",
    "scl": "`scl`: Siemens TIA Portal",
    "twincat": "`twincat`: TwinCAT 3",
    "omron": "`omron`: Omron Sysmac Studio",
    "mitsubishi": "`mitsubishi`: Mitsubishi GX Works3",
    "keyence": "`keyence`: Keyence KV STUDIO",
    "iec": "`st` and `plcopen`: IEC 61131-3",
}


def words_page() -> Iterator[str]:
    """Yield the lines of the page about the Structured Text of each tool."""
    yield _ABOUT
    for name, title in _LISTS.items():
        yield f"\n## {title}\n"
        yield from _list(words(name), entry_sources(name))
    yield from _constructs()


_CONSTRUCTS = """
## Constructs beyond the portable subset

The table shows the result of `rcx check --for`. **yes** means that the tool accepts the construct,
**no** that it refuses it; the number is the source below. An empty cell means that no public
document answers the question; the command then reports "may be refused". The meaning of each
construct is in [language.md](language.md).
"""


def _constructs() -> Iterator[str]:
    """Yield the table of the constructs that each tool accepts, with sources."""
    yield _CONSTRUCTS
    every = tools().values()
    said = [one for tool in every for one in (*tool.takes.values(), *tool.refuses.values())]
    numbers = {source: at for at, source in enumerate(dict.fromkeys(said), 1)}
    details = sorted({name for tool in every for name in tool.takes} - CONSTRUCTS.keys())
    yield f"| | {' | '.join(tool.title for tool in every)} |"
    yield "|---" * (len(every) + 1) + "|"
    for name in (*CONSTRUCTS, *details):
        cells = []
        for tool in every:
            source = tool.takes.get(name) or tool.refuses.get(name)
            word = "yes" if name in tool.takes else "no"
            cells.append(f"{word} {numbers[source]}" if source else "")
        yield f"| {name} | {' | '.join(cells)} |"
    yield ""
    yield from (f"{number}. {source}" for source, number in numbers.items())


def entry_sources(name: str) -> dict[str, str]:
    """Return the source of each entry of a list, by section and key."""
    content = load_toml(FOLDER / f"{name}.toml")
    return {
        f"{section}.{key}": content["sources"][origin]
        for section in ("language", "functions", "blocks", "instructions")
        for key, (_, origin) in content.get(section, {}).items()
    }


def _list(found: Words, sources: dict[str, str]) -> Iterator[str]:
    in_order = dict.fromkeys(sources.values())
    letters = {source: chr(ord("a") + at) for at, source in enumerate(in_order)}
    yield "| IEC 61131-3 | written as | source |"
    yield "|---|---|---|"
    for section, forms in (("functions", found.functions), ("blocks", found.blocks)):
        for key, form in forms.items():
            yield f"| {key} | `{_form(form)}` | {letters[sources[f'{section}.{key}']]} |"
    for key, form in found.instructions.items():
        yield f"| (instruction) | `{_form(form)}` | {letters[sources[f'instructions.{key}']]} |"
    for what, listed in (
        ("`X_TO_Y` among", found.conversions),
        ("operators", found.operators),
        ("statements", found.statements),
    ):
        section = {"`X_TO_Y` among": "conversions"}.get(what, what)
        letter = letters[sources[f"language.{section}"]]
        yield f"| {what} | {' '.join(f'`{one}`' for one in listed)} | {letter} |"
    for key, instead in found.instead.items():
        yield f"| not there: {key} | write {instead} | |"
    yield ""
    yield from (f"- {letter}: {source}" for source, letter in letters.items())


def _form(form: Form) -> str:
    return f"{form.name}({', '.join(form.parameters)})" if form.parameters else form.name
