"""The playground of out/site works in a real browser.

The first test runs if the site is built; `make site-test` runs the others.
"""

from __future__ import annotations

import gzip
import re
import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
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
    """A server of the site that records the requests."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        super().__init__(("127.0.0.1", 0), partial(_Handler, directory=str(_SITE)))

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"


class _Handler(SimpleHTTPRequestHandler):
    def log_message(self, text: str, *values: Any) -> None:
        """Record the path instead of printing it."""
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
    """The page of the playground as a user sees it."""

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

    def seen(self) -> list[str]:
        """Return the states (texts) that the page has shown since it was opened."""
        return [str(one) for one in self.run("window.seenStates") or []]

    def finished(self) -> str:
        """Return the result text after the run has ended."""
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
        """Start a run by an action, and return its result text."""
        self.run("document.getElementById('told').textContent = ''")
        action()
        return self.finished()

    def choose(self, program: str) -> str:
        return self.change(lambda: self.run(f"void (location.hash = {program!r})"))

    def write(self, text: str) -> None:
        """Enter another text into the file that is shown."""
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
        """Return the lines of the trace that the button saves."""
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
    assert page.text("#told").endswith("10 remote commands, no broken rules")
    browser.switch_to.frame("chart")
    try:
        page.until("document.querySelectorAll('.row').length > 10")
        page.until("document.querySelector('svg.rv') !== null")
        robot = "document.querySelector('svg.rv').getBoundingClientRect().bottom"
        assert page.run(robot) <= page.run("innerHeight"), "the robot is visible without scrolling"
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
def test_the_progress_is_shown_while_python_loads(browser: WebDriver, server: _Server) -> None:
    """While Python loads, the page shows the progress from the first bytes on.

    It is shown in the header and in place of the chart.
    """
    watch = """
      window.seenStates = [];
      addEventListener("DOMContentLoaded", () => {
        const note = () => seenStates.push(document.getElementById("state").textContent);
        const what = { childList: true, characterData: true, subtree: true };
        new MutationObserver(note).observe(document.getElementById("state"), what);
      });
    """
    given = {"source": watch}
    name = "Page.addScriptToEvaluateOnNewDocument"
    number = browser.execute_cdp_cmd(name, given)["identifier"]
    try:
        page = _Playground(browser, f"{server.url}/play/index.html")
    finally:
        given = {"identifier": number}
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", given)
    states = page.seen()
    shares = [int(one.split()[-2]) for one in states if one.startswith("loading Python and")]
    assert len(shares) >= 3
    assert shares == sorted(shares)
    assert states.index("starting Python …") < states.index("running …")
    assert page.run("document.getElementById('wait').hidden"), "the chart is drawn"


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
    assert top < page.run(box.format("#mirror .note", "top")) < low, "the line is visible"
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
    browser.get(f"{server.url}/docs/reference/blocks/FB_ServoOn.html")
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
@pytest.mark.parametrize(
    ("query", "expected"),
    [("gripper", "FB_PickPlace"), ("MovePtp", "FB_MovePtp"), ("16#8010", "FB_AutoStart")],
)
def test_the_search_finds_the_users_block_first_and_internal_blocks_last(
    browser: WebDriver, server: _Server, query: str, expected: str
) -> None:
    """The search finds the block of the user first and internal blocks last.

    The test queries the search worker as the page does.
    """
    browser.get(f"{server.url}/index.html")
    (worker,) = (_SITE / "assets/javascripts/workers").glob("search.*.js")
    script = """
      const [path, input, done] = arguments;
      const worker = new Worker(path);
      fetch("/search.json").then((one) => one.json()).then((data) => {
        worker.onmessage = ({ data: message }) => {
          if (message.type === 1) worker.postMessage({ type: 2, data: { input } });
          if (message.type === 3) done(message.data.items.map(({ id }) => data.items[id].location));
        };
        worker.postMessage({ type: 0, data });
      });
    """
    path = f"/{worker.relative_to(_SITE).as_posix()}"
    found: list[str] = browser.execute_async_script(script, path, query)
    assert found[0].startswith(f"docs/reference/blocks/{expected}.html")
    inner = ["FB_Rcx" in one or "internal-blocks" in one for one in found]
    assert inner == sorted(inner)
    text = (_SITE / "search.json").read_text(encoding="utf-8")
    assert "FB_MovePtp.st.html" not in text, "sources are not searched"


def _wears(browser: WebDriver, theme: str) -> None:
    media = {"features": [{"name": "prefers-color-scheme", "value": theme}]}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)


def _scheme(browser: WebDriver, expected: str) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    script = "return document.body.dataset.mdColorScheme"
    WebDriverWait(browser, 60).until(
        lambda _: browser.execute_script(script) == expected, f"it is not {expected}"
    )


@_full
def test_the_colours_follow_the_system_until_the_user_chooses(
    browser: WebDriver, server: _Server
) -> None:
    page = f"{server.url}/index.html"
    try:
        browser.get(page)
        browser.execute_script("localStorage.clear()")
        for theme, scheme in (("light", "default"), ("dark", "slate"), ("light", "default")):
            _wears(browser, theme)
            browser.get(page)
            _scheme(browser, scheme)
        _wears(browser, "dark")
        _scheme(browser, "slate")
        switch = "document.querySelector('[data-md-component=palette] label:not([hidden])').click()"
        browser.execute_script(switch)
        _scheme(browser, "default")
        browser.get(page)
        _scheme(browser, "default")
    finally:
        browser.execute_script("localStorage.clear()")
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@_full
def test_the_playground_follows_the_switch_of_the_site(
    browser: WebDriver, server: _Server, page: _Playground
) -> None:
    """The playground follows the light/dark switch of the site, also while it is open.

    The switch stores its choice.
    """
    ink = "getComputedStyle(document.documentElement).colorScheme"
    chart = "document.getElementById('chart').srcdoc.match(/data-theme=\"(\\w+)\"/)[1]"
    switch = "document.querySelector('[data-md-component=palette] label:not([hidden])').click()"
    # A page of another test may have stored its scheme after the end of that test.
    browser.execute_script("localStorage.clear()")
    try:
        _wears(browser, "dark")
        page.until(f"{ink} === 'dark'")
        browser.get(f"{server.url}/index.html")
        browser.execute_script(switch)  # light
        reopened = _Playground(browser, f"{server.url}/play/index.html")
        assert (reopened.run(ink), reopened.run(chart)) == ("light", "light")
        site = "window.site = open('../index.html'), new Promise((done) => (site.onload = done))"
        browser.execute_async_script(f"const done = arguments[0]; ({site}).then(() => done())")
        reopened.run(f"void site.{switch}")  # dark
        reopened.until(f"{ink} === 'dark'")
    finally:
        browser.execute_script("window.site?.close(); localStorage.clear()")
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@_full
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_safety_note_is_the_most_visible_text(
    browser: WebDriver, server: _Server, theme: str
) -> None:
    """The note is larger than the text around it and has full contrast (7:1, WCAG 2 AAA)."""
    _wears(browser, theme)
    try:
        browser.get(f"{server.url}/docs/how-to/serve.html")
        colour, back, size, around = browser.execute_script("""
          const note = getComputedStyle(document.querySelector("blockquote p"));
          const box = getComputedStyle(document.querySelector("blockquote"));
          const text = getComputedStyle(document.querySelector("article > p"));
          return [note.color, box.backgroundColor, note.fontSize, text.fontSize];
        """)
        assert float(size.removesuffix("px")) > float(around.removesuffix("px"))
        high, low = sorted((_luminance(colour), _luminance(back)), reverse=True)
        assert (high + 0.05) / (low + 0.05) >= 7
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def _luminance(colour: str) -> float:
    """Return the relative luminance of a colour. Source: WCAG 2."""
    parts = [int(one) / 255 for one in re.findall(r"\d+", colour)[:3]]
    red, green, blue = (one / 12.92 if one <= 0.03928 else ((one + 0.055) / 1.055) ** 2.4
                        for one in parts)  # fmt: skip
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@_full
@pytest.mark.parametrize("width", [400, 1280])
def test_a_wide_table_scrolls_in_its_box_and_names_of_pins_are_whole(
    browser: WebDriver, server: _Server, width: int
) -> None:
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        browser.get(f"{server.url}/docs/reference/blocks/FB_PickPlace.html")
        whole, scrolls, broken = browser.execute_script("""
          const table = document.querySelector("#inputs ~ .md-typeset__scrollwrap");
          const names = [...table.querySelectorAll("td:first-child code")];
          return [document.documentElement.scrollWidth, getComputedStyle(table).overflowX,
                  names.filter((one) => one.getClientRects().length > 1).length];
        """)
        assert (whole <= width, scrolls, broken) == (True, "auto", 0)
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
