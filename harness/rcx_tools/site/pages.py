"""The sources of the site: pages of the repository, and all files to which they link."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Iterator
from pathlib import Path

from rcx_tools.site.programs import ROOT, block_jobs

__all__ = ["START", "staged"]

#: The first pages for readers. All files that are linked from them belong to the site.
START = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
_LINK = re.compile(r"(\]\()([^()\s#:]+)((?:#[^()\s]*)?\))")
#: Pattern of a chart that is alone in its line.
_CHART = re.compile(r"^(!\[[^\]]*\]\(([^)\s]+\.svg)\))$", re.MULTILINE)
_FENCE = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
_ASSETS = (".csv", ".html", ".json", ".png", ".svg")
_LANGUAGES = {".css": "css", ".js": "js", ".py": "python", ".toml": "toml"}
#: Heading on the page of a block. The playground is inserted before it.
_BEFORE = "\n### Timing\n"
_TRY = """
<details class="try"><summary>Run it here, and change it</summary>
<iframe src="{up}play/index.html#block={name}" title="Playground: {name}" loading="lazy"></iframe>
</details>
"""


def staged() -> Iterator[tuple[str, bytes]]:
    """Yield every file of the site's sources: its path in the repository, and its content.

    A linked source file also becomes a page: `FB_X.st` becomes `FB_X.st.md`. A linked folder
    becomes a list of its files.
    """
    every = sorted((ROOT / "docs").rglob("*.md"))
    waiting = deque([*START, *(file.relative_to(ROOT).as_posix() for file in every)])
    seen = set(waiting)
    while waiting:
        path = waiting.popleft()
        file = ROOT / path
        if file.suffix in _ASSETS:
            yield path, file.read_bytes()
            continue
        links: list[str] = []
        yield _place(path), _page(path, links).encode()
        fresh = [one for one in links if one not in seen]
        seen.update(fresh)
        waiting.extend(dict.fromkeys(fresh))


def _place(path: str) -> str:
    """Return the path of the page for a file or folder, in the sources of the site."""
    file = ROOT / path
    if path == "README.md":
        return "index.md"
    if file.is_dir():
        return f"{path}/index.md"
    return path if file.suffix in (".md", *_ASSETS) else f"{path}.md"


def _page(path: str, links: list[str]) -> str:
    file = ROOT / path
    if file.is_dir():
        return _listing(path, links)
    text = file.read_text(encoding="utf-8")
    if file.suffix != ".md":
        return _source(path, text)
    parts = _FENCE.split(text)
    parts[::2] = [_LINK.sub(lambda found: _linked(path, found, links), part) for part in parts[::2]]
    # A click on a chart opens the chart in full size.
    parts[::2] = [_CHART.sub(r"[\1](\2)", part) for part in parts[::2]]
    return _with_playground(path, "".join(parts))


def _linked(path: str, found: re.Match[str], links: list[str]) -> str:
    target = Path(os.path.normpath((ROOT / path).parent / found[2]))
    if not target.exists() or ROOT not in (target, *target.parents):
        return found[0]
    if target.is_dir() and (target / "README.md").is_file():
        target /= "README.md"
    there = target.relative_to(ROOT).as_posix()
    links.append(there)
    return f"{found[1]}{os.path.relpath(_place(there), Path(_place(path)).parent)}{found[3]}"


def _source(path: str, text: str) -> str:
    language = _LANGUAGES.get(Path(path).suffix, "text")
    fence = "`" * 6
    return _unsearched(
        f"# {Path(path).name}\n\n`{path}`\n\n{fence}{language}\n{text.rstrip()}\n{fence}\n"
    )


def _listing(path: str, links: list[str]) -> str:
    """Return the page of a folder: its files, each with a link."""
    lines = [f"# {path}\n"]
    for file in sorted((ROOT / path).iterdir()):
        if file.is_file() and not file.name.startswith("."):
            there = file.relative_to(ROOT).as_posix()
            links.append(there)
            lines.append(f"- [{file.name}]({Path(_place(there)).name})")
    return _unsearched("\n".join(lines) + "\n")


def _unsearched(text: str) -> str:
    return f"---\nsearch:\n  exclude: true\n---\n\n{text}"


def _with_playground(path: str, text: str) -> str:
    name = Path(path).stem
    if not path.startswith("docs/reference/blocks/") or name not in block_jobs():
        return text
    return text.replace(_BEFORE, _TRY.format(up="../../../", name=name) + _BEFORE, 1)
