"""The playground of out/site in a real browser.

The first test runs where the site is built; `make site-test` runs the others.
"""

from __future__ import annotations

import gzip
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from browser import NEEDS_BROWSER, chromium
from example_runs import EXAMPLES, ROOT, changes, recorded_trace

if TYPE_CHECKING:
    from selenium.webdriver.chrome.webdriver import WebDriver

_SITE = ROOT / "out/site"
_BUILT = (_SITE / "play/harness.zip").is_file()
_LONGEST_S = 600
_MOST_BYTES = 10_000_000

pytestmark = [
    NEEDS_BROWSER,
    pytest.mark.skipif(not _BUILT, reason="out/site is not built: make site, which needs npm"),
]
_full = pytest.mark.external(reason="needs npm: make site-test")


class _Server(ThreadingHTTPServer):
    """Serves the site, and keeps what was asked for."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        super().__init__(("127.0.0.1", 0), partial(_Handler, directory=str(_SITE)))

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"


class _Handler(SimpleHTTPRequestHandler):
    def log_message(self, text: str, *values: Any) -> None:
        """Keep the path instead of printing it."""
        assert isinstance(self.server, _Server)
        if hasattr(self, "path"):
            self.server.asked.append(self.path.partition("?")[0])


@pytest.fixture(scope="module")
def server() -> Iterator[_Server]:
    with _Server() as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture(scope="module")
def browser() -> Iterator[WebDriver]:
    with chromium(1280, 900, "performance") as driver:
        driver.set_script_timeout(_LONGEST_S)
        yield driver


class _Playground:
    """The page, as a user sees it."""

    def __init__(self, browser: WebDriver, address: str) -> None:
        self.browser = browser
        browser.get("about:blank")
        browser.get(address)
        self.finished()

    def run(self, script: str) -> Any:
        return self.browser.execute_script(f"return {script}")

    def until(self, script: str) -> None:
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(self.browser, _LONGEST_S).until(lambda _: self.run(script), script)

    def finished(self) -> str:
        """What is said of the run once it has ended."""
        self.until(
            "document.getElementById('told')?.textContent && "
            "!document.getElementById('progress').classList.contains('on')"
        )
        return self.text("#told")

    def text(self, selector: str) -> str:
        return str(self.run(f"document.querySelector({selector!r}).textContent"))

    def click(self, selector: str) -> None:
        self.run(f"document.querySelector({selector!r}).click()")

    def change(self, action: Callable[[], None]) -> str:
        """What is said of the run that an action starts."""
        self.run("document.getElementById('told').textContent = ''")
        action()
        return self.finished()

    def choose(self, program: str) -> str:
        return self.change(lambda: self.run(f"void (location.hash = {program!r})"))

    def write(self, text: str) -> None:
        """Another text for the file that is shown."""
        self.browser.execute_script(
            "const edit = document.getElementById('edit'); edit.value = arguments[0];"
            "edit.dispatchEvent(new Event('input'))",
            text,
        )

    def slide(self, selector: str, value: int) -> None:
        self.browser.execute_script(
            "const input = document.querySelector(arguments[0]); input.value = arguments[1];"
            "input.dispatchEvent(new Event('input')); input.dispatchEvent(new Event('change'))",
            selector,
            value,
        )

    def trace(self) -> list[str]:
        """The lines that the button saves."""
        text = self.browser.execute_async_script(
            "const done = arguments[0], make = URL.createObjectURL;"
            "HTMLAnchorElement.prototype.click = () => {};"
            "URL.createObjectURL = (blob) => {"
            "  URL.createObjectURL = make; blob.text().then(done); return make(blob); };"
            "document.getElementById('trace').click()"
        )
        return str(text).splitlines()


@pytest.fixture
def page(browser: WebDriver, server: _Server) -> _Playground:
    return _Playground(browser, f"{server.url}/play/index.html")


def test_the_first_chart_comes_with_the_robot_from_this_site_alone_in_less_than_10_mb(
    browser: WebDriver, server: _Server
) -> None:
    log: Any = browser
    log.get_log("performance")
    server.asked.clear()
    page = _Playground(browser, f"{server.url}/play/index.html")
    assert page.text("#told").endswith("9 remote commands, no broken rules")
    browser.switch_to.frame("chart")
    try:
        page.until("document.querySelectorAll('.row').length > 10")
        page.until("document.querySelector('svg.rv, .rv svg') !== null")
    finally:
        browser.switch_to.default_content()
    sent = [one["message"] for one in log.get_log("performance")]
    urls = [one for one in sent if '"Network.requestWillBeSent"' in one and '"url":"http' in one]
    assert urls
    assert [one for one in urls if f'"url":"{server.url}' not in one] == []
    asked = {path.lstrip("/") for path in server.asked}
    assert {"play/harness.zip", "play/python/pyodide.asm.wasm"} <= asked
    sizes = {path: len(gzip.compress((_SITE / path).read_bytes(), 9)) for path in asked}
    assert sum(sizes.values()) <= _MOST_BYTES, sizes


@_full
def test_every_example_runs_to_its_recorded_trace(page: _Playground) -> None:
    for example in EXAMPLES:
        assert page.choose(f"example={example.name}").endswith("no broken rules"), example.name
        recorded = recorded_trace(example).read_text(encoding="utf-8").splitlines()
        assert list(changes(page.trace())) == recorded[1:], example.name


@_full
def test_an_error_stands_behind_its_line(page: _Playground) -> None:
    page.choose("example=01_power_up")
    text = str(page.run("document.getElementById('edit').value"))
    line = next(k for k, one in enumerate(text.splitlines()) if one.startswith("  ReadArea("))
    page.write("\n".join([*text.splitlines()[:line], "  Start := 5;", *text.splitlines()[line:]]))
    assert page.change(lambda: page.click("#run")) == "not run"
    assert page.text("#wrong").startswith(f"PowerUp.st, line {line + 1}: ")
    assert page.text("#mirror .note").startswith("◂ ")
    assert page.text("#numbers .bad").strip() == str(line + 1)
    box = "document.querySelector('{}').getBoundingClientRect().{}"
    top, low = (page.run(box.format("#text", side)) for side in ("top", "bottom"))
    assert top < page.run(box.format("#mirror .note", "top")) < low, "it is in sight"
    page.write(text)
    assert page.change(lambda: page.click("#run")).endswith("no broken rules")
    assert page.run("document.getElementById('wrong').hidden")


@_full
def test_sliders_and_faults_run_it_again(page: _Playground) -> None:
    page.choose("example=04_pick_and_place")
    before = page.trace()
    slower = page.change(lambda: page.slide("#sliders input", 20_000))
    assert "250 scans of 20 ms" in slower
    page.choose("example=01_power_up")
    page.choose("example=04_pick_and_place")
    page.slide("#faults input", 2_000_000)
    stopped = page.change(lambda: page.click("#faults button"))
    moments = page.run(
        "[...document.querySelectorAll('#moments li > input')].map((one) => one.value)"
    )
    assert 'robot = "emergency_stop", for = "500ms"' in moments
    assert stopped.endswith("no broken rules")
    assert page.trace() != before


@_full
def test_a_moment_that_is_wrong_is_marked_in_its_row(page: _Playground) -> None:
    page.choose("example=01_power_up")
    script = (
        "const what = document.querySelectorAll('#moments li > input')[1];"
        "what.value = 'robot = \"explosion\"'; what.dispatchEvent(new Event('change'))"
    )
    assert page.change(lambda: page.browser.execute_script(script)) == "not run"
    assert "explosion" in page.text("#moments li.bad p")


@_full
def test_a_run_can_be_stopped_and_the_page_goes_on(page: _Playground) -> None:
    page.slide("#sliders label:nth-child(3) input", 30_000_000)
    page.until("!document.getElementById('stop').disabled")
    page.click("#stop")
    assert page.text("#state") == "stopped"
    assert not page.run("document.getElementById('run').disabled")
    page.slide("#sliders label:nth-child(3) input", 500_000)
    page.until("document.getElementById('told').textContent.startsWith('500 ms')")


@_full
def test_a_link_has_the_program_and_its_settings_in_it(page: _Playground, server: _Server) -> None:
    page.choose("example=02_extended_area")
    text = "(* ours ü *)\n" + str(page.run("document.getElementById('edit').value"))
    page.write(text)
    page.change(lambda: page.slide("#sliders input", 20_000))
    page.click("#share")
    page.until("!document.getElementById('link').hidden")
    link = str(page.run("document.querySelector('#link input').value"))
    assert link.startswith(f"{server.url}/play/index.html#program=")
    told = page.text("#told")
    other = _Playground(page.browser, link)
    assert other.text("#told") == told
    assert other.run("document.getElementById('edit').value") == text
    assert other.run("document.getElementById('note').hidden")
    broken = _Playground(page.browser, link[:-9])
    assert not broken.run("document.getElementById('note').hidden")
    assert broken.run("document.getElementById('program').value") == "example=04_scara"


@_full
def test_a_blocks_page_runs_its_example_once_it_is_opened(
    browser: WebDriver, server: _Server
) -> None:
    server.asked.clear()
    browser.get("about:blank")
    browser.get(f"{server.url}/docs/blocks/FB_ServoOn.html")
    browser.execute_script("document.querySelector('.try').scrollIntoView()")
    assert not [path for path in server.asked if path.startswith("/play")]
    browser.execute_script("document.querySelector('.try summary').click()")
    browser.switch_to.frame(browser.execute_script("return document.querySelector('.try iframe')"))
    try:
        page = _Playground.__new__(_Playground)
        page.browser = browser
        assert page.finished().endswith("no broken rules")
        assert page.run("document.getElementById('program').value") == "block=FB_ServoOn"
    finally:
        browser.switch_to.default_content()


@_full
@pytest.mark.parametrize(
    "path", ["index.html", "docs/reference/blocks/FB_MovePtp.html", "play/index.html"]
)
@pytest.mark.parametrize("width", [400, 1280])
def test_it_fits_narrow_and_wide_windows(
    browser: WebDriver, server: _Server, path: str, width: int
) -> None:
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        browser.get(f"{server.url}/{path}")
        wide = browser.execute_script("return document.documentElement.scrollWidth")
        assert wide <= width
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@_full
def test_the_search_finds_a_block(browser: WebDriver, server: _Server) -> None:
    """The index is part of the site."""
    text = (_SITE / "search.json").read_text(encoding="utf-8")
    assert "docs/reference/blocks/FB_MovePtp.html" in text
    assert "FB_MovePtp.st.html" not in text, "sources are not searched"
    assert Path(_SITE / "index.html").is_file()
