"""Checks of a site: broken links, and resources that are loaded from other hosts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

__all__ = ["problems"]

#: HTML elements that load their target. A link (`a`) does not load its target.
_LOADING = {"audio", "embed", "iframe", "img", "link", "object", "script", "source", "video"}
#: Values of `rel` for links in the head of a page that load nothing.
_IDLE = {"canonical", "next", "prev", "alternate"}
_FOREIGN = re.compile(r"(?:https?:)?//", re.IGNORECASE)
_OF_STYLE = re.compile(r"@import|url\(\s*['\"]?(?:https?:)?//", re.IGNORECASE)


class _Page(HTMLParser):
    """The anchors and links of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.links: list[tuple[str, str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        for key in ("id", "name"):
            if given.get(key):
                self.names.add(str(given[key]))
        if tag == "link" and given.get("rel") in _IDLE:
            return
        for key in ("href", "src", "data"):
            if given.get(key) and (tag == "a" or tag in _LOADING):
                self.links.append((tag, str(given[key])))


def problems(site: Path) -> list[str]:
    """Return a line for each broken link, and for each resource from another host.

    Links (`a`) may lead to other hosts, but a page may load nothing from other hosts.
    """
    return [f"{page.relative_to(site)}: {one}" for page in _pages(site) for one in _of(site, page)]


def _pages(site: Path) -> list[Path]:
    return sorted((*site.rglob("*.html"), *site.rglob("*.css")))


def _of(site: Path, page: Path) -> Iterator[str]:
    if page.suffix == ".css":
        if _OF_STYLE.search(page.read_text(encoding="utf-8")):
            yield "loads from elsewhere"
        return
    for tag, link in _read(page).links:
        if _FOREIGN.match(link):
            if tag != "a":
                yield f"<{tag}> loads {link}"
            continue
        target, anchor = urldefrag(link)
        if re.match(r"[a-z]+:", link):
            continue
        begin = site if target.startswith("/") else page.parent
        there = (begin / unquote(target).lstrip("/")).resolve() if target else page
        there = there / "index.html" if there.is_dir() else there
        if not there.is_file() or site not in there.parents:
            yield f"<{tag}> {link}: there is no such file"
        elif _is_place(anchor, there) and unquote(anchor) not in _read(there).names:
            yield f"<{tag}> {link}: there is no such place in it"


def _is_place(anchor: str, page: Path) -> bool:
    """Return whether an anchor is a position in a page, and not an argument of the playground."""
    return bool(anchor) and page.suffix == ".html" and "=" not in anchor


@cache
def _read(page: Path) -> _Page:
    read = _Page()
    read.feed(page.read_text(encoding="utf-8"))
    return read
