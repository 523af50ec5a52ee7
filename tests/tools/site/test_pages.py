"""The site is built from its sources and its lock file, and its check detects faults."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

from rcx_tools.site.__main__ import main
from rcx_tools.site.bundle import bundle
from rcx_tools.site.checked import problems
from rcx_tools.site.pages import staged
from rcx_tools.site.programs import FIRST, block_jobs

pytestmark = pytest.mark.exhaustive

_HERE = Path("harness/rcx_tools/site")


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """Return a dictionary of paths to the pages in the sources of the site."""
    return {path: text.decode() for path, text in staged() if path.endswith(".md")}


def test_every_page_of_the_docs_is_in_the_site_and_in_its_menu(
    repository: Path, pages: dict[str, str]
) -> None:
    menu = (repository / _HERE / "zensical.toml").read_text(encoding="utf-8")
    for file in (repository / "docs").rglob("*.md"):
        page = file.relative_to(repository).as_posix()
        assert page in pages
        below = page.startswith(("docs/reference/blocks/", "docs/reference/cli/"))
        assert below or page.startswith("docs/how-to/setup/") or f'"{page}"' in menu, (
            "a line of harness/rcx_tools/site/zensical.toml"
        )


def test_links_between_pages_and_to_sources_lead_to_pages(pages: dict[str, str]) -> None:
    block = pages["docs/reference/blocks/FB_MovePtp.md"]
    assert "[FB_MovePtp.st](../../../plc/lib/command/movement/FB_MovePtp.st.md)" in block
    assert "(../../../plc/lib/command/movement/FB_MovePtp.st)" not in block
    source = pages["plc/lib/command/movement/FB_MovePtp.st.md"]
    assert "FUNCTION_BLOCK FB_MovePtp" in source
    assert "exclude: true" in source.partition("# FB_MovePtp.st")[0], (
        "the page is not in the search index"
    )
    assert "(docs/reference/blocks.md)" in pages["index.md"]
    assert "[controller.py](controller.py.md)" in pages["harness/rcx_harness/robot/index.md"]


def test_a_chart_leads_to_itself_in_its_own_size(pages: dict[str, str]) -> None:
    chart = "charts/FB_MovePtp.svg"
    page = pages["docs/reference/blocks/FB_MovePtp.md"]
    assert f"[![Timing chart of the example]({chart})]({chart})" in page


def test_every_block_with_an_example_has_its_playground(pages: dict[str, str]) -> None:
    for name in block_jobs():
        tries = re.findall(
            r'<iframe src="([^"]+)".*loading="lazy"', pages[f"docs/reference/blocks/{name}.md"]
        )
        assert tries == [f"../../../play/index.html#block={name}"]


def test_the_lock_names_one_version_by_its_hash_and_no_registry(repository: Path) -> None:
    text = (repository / _HERE / "package-lock.json").read_text(encoding="utf-8")
    asked = json.loads((repository / _HERE / "package.json").read_text("utf-8"))["dependencies"]
    packages = json.loads(text)["packages"]
    assert packages[""]["dependencies"] == asked
    assert packages["node_modules/pyodide"]["version"] == asked["pyodide"]
    assert all("integrity" in one for name, one in packages.items() if name)
    assert "resolved" not in text
    assert "://" not in text


def test_without_npm_one_line_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main() == 2
    said = "make site: node is not found; install Node.js 20 or newer\n"
    assert capsys.readouterr().err == said


def test_the_page_names_the_program_that_is_compiled_before(repository: Path) -> None:
    script = (repository / _HERE / "playground/play.js").read_text(encoding="utf-8")
    assert f'const FIRST = "{FIRST}";' in script


def test_the_bundle_is_the_harness_unchanged(repository: Path, tmp_path: Path) -> None:
    with ZipFile(io.BytesIO(bundle())) as archive:
        names = set(archive.namelist())
        for name in names:
            if not name.startswith("harness/lark"):
                assert archive.read(name) == (repository / name).read_bytes()
    assert {"spec/signals.toml", "plc/lib/area/FB_ReadArea.st"} <= names
    assert "harness/structured_text/language/grammar.lark" in names
    assert any(re.fullmatch(r"harness/lark-.*/LICENSE", name) for name in names)
    assert not any("rcx_harness/cli" in name or "rcx_harness/enip" in name for name in names)
    assert bundle() == bundle()


@pytest.mark.skipif(sys.version_info < (3, 11), reason="the site needs Python 3.11 or newer")
def test_the_bundle_alone_is_enough_to_import_the_runner(tmp_path: Path) -> None:
    """The bundle alone is enough to import the runner.

    A browser has neither site-packages nor the folders that the bundle omits.
    """
    (tmp_path / "bundle.zip").write_bytes(bundle())
    with ZipFile(tmp_path / "bundle.zip") as archive:
        archive.extractall(tmp_path)
    script = (
        f"import sys; sys.path.insert(0, {str(tmp_path / 'harness')!r});"
        "from rcx_harness.cell.cell import Cell; import rcx_tools.site.drive as drive;"
        "print(drive.__file__)"
    )
    command = [sys.executable, "-I", "-S", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(tmp_path))


@pytest.mark.parametrize(
    ("page", "expected"),
    [
        ('<a href="b.html">', []),
        ('<a href="/b.html#here">', []),
        ('<a href="https://example.org/">', []),
        ('<a href="c.html">', ["a.html: <a> c.html: there is no such file"]),
        ('<a href="b.html#there">', ["a.html: <a> b.html#there: there is no such place in it"]),
        ('<a href="../b.html">', ["a.html: <a> ../b.html: there is no such file"]),
        (
            '<img src="https://example.org/a.png">',
            ["a.html: <img> loads https://example.org/a.png"],
        ),
        ('<script src="//example.org/a.js">', ["a.html: <script> loads //example.org/a.js"]),
        ('<link rel="stylesheet" href="a.css">', ["a.html: <link> a.css: there is no such file"]),
        ('<link rel="canonical" href="https://example.org/">', []),
    ],
)
def test_a_link_to_nothing_and_what_comes_from_elsewhere_are_found(
    tmp_path: Path, page: str, expected: list[str]
) -> None:
    (tmp_path / "a.html").write_text(page, encoding="utf-8")
    (tmp_path / "b.html").write_text('<p id="here">', encoding="utf-8")
    assert problems(tmp_path) == expected


def test_a_style_sheet_that_loads_from_elsewhere_is_found(tmp_path: Path) -> None:
    (tmp_path / "a.css").write_text("p { background: url(https://example.org/a.png) }", "utf-8")
    assert problems(tmp_path) == ["a.css: loads from elsewhere"]
