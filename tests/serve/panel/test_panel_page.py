"""The faceplate in a real browser: what is pressed there is pressed in the program."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from browser import NEEDS_BROWSER, chromium
from plc_bench import LIBRARY, ROOT
from rcx_harness.engine import build
from rcx_harness.engine.needed import needed
from rcx_harness.serve.panel.plate import HOLD_S, Plate, plates_of
from rcx_harness.serve.panel.server import PanelServer

pytestmark = NEEDS_BROWSER
pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

from selenium.webdriver.chrome.webdriver import WebDriver  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

_LIMIT_S = 60.0
_BENCH = ROOT / "tests/data/library/Operator.st"


class _Panel:
    """A program that is scanned as long as the test waits, and its page."""

    def __init__(self, browser: WebDriver) -> None:
        self.browser, self.now = browser, 100.0
        self.program = build([_BENCH, *needed([_BENCH], LIBRARY)], "builtin").program
        (self.plate,) = plates_of(self.program, lambda: self.now)
        self._scans = 0

    def scan(self) -> None:
        """One scan with the exchange before it."""
        self.plate.exchange()
        self.program.scan(self._scans * 10_000)
        self._scans += 1

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Scan until it is so."""

        def now(_: WebDriver) -> object:
            self.scan()
            return condition()

        WebDriverWait(self.browser, _LIMIT_S, poll_frequency=0.02).until(now, what)

    def key(self, name: str) -> bool:
        """Is it pressed in the program?"""
        return bool(self.program.read(f"Main.Panel.Key.{name}"))

    def shows(self, selector: str) -> str:
        """A text of the page."""
        script = "return document.querySelector(arguments[0])?.innerText ?? ''"
        return str(self.browser.execute_script(script, selector))


@pytest.fixture(scope="module")
def browser() -> Iterator[WebDriver]:
    """One browser for all."""
    with chromium(1280, 900) as driver:
        yield driver


@pytest.fixture
def panel(browser: WebDriver) -> Iterator[_Panel]:
    """A panel whose page is open."""
    one = _Panel(browser)
    with PanelServer([one.plate], 0) as server:
        browser.get(server.address)
        one.until(lambda: one.shows("[data-key=Start]") == "Start", "the page shows its keys")
        yield one
        browser.get("about:blank")
    log = browser.get_log("browser")  # type: ignore[no-untyped-call]
    assert [row for row in log if row["level"] == "SEVERE"] == []


def test_a_key_is_held_as_long_as_the_mouse_button(panel: _Panel) -> None:
    button = panel.browser.find_element(By.CSS_SELECTOR, "[data-key=JogPlus]")
    ActionChains(panel.browser).click_and_hold(button).perform()
    panel.until(lambda: panel.key("JogPlus"), "pressed")
    for _ in range(20):
        panel.now += HOLD_S / 2
        heard = panel.plate.shown()["Key"]["JogPlus"]
        assert heard
        panel.until(lambda: _beats(panel.plate), "the page says it again")
    ActionChains(panel.browser).release(button).perform()
    panel.until(lambda: not panel.key("JogPlus"), "released")


def _beats(plate: Plate) -> bool:
    """It has been heard at the time that it is now."""
    return plate.silent_s == 0.0


def test_a_page_that_is_left_releases_its_key(panel: _Panel) -> None:
    button = panel.browser.find_element(By.CSS_SELECTOR, "[data-key=JogPlus]")
    ActionChains(panel.browser).click_and_hold(button).perform()
    panel.until(lambda: panel.key("JogPlus"), "pressed")
    panel.browser.get("about:blank")
    panel.now += HOLD_S + 0.01
    panel.until(lambda: not panel.key("JogPlus"), "released")
    ActionChains(panel.browser).release().perform()


def test_selections_are_chosen_and_the_message_is_shown_in_its_language(panel: _Panel) -> None:
    """Source: spec/errors.toml, 16#8002: SO(01) is OFF, for nobody plays the controller."""
    panel.until(lambda: panel.shows("#message b") == "Controller not ready", "the hint")
    for value, path, expected in (
        ("LANGUAGE_JAPANESE", "Language", "LANGUAGE_JAPANESE"),
        ("JOG_TOOL", "Frame", "JOG_TOOL"),
        ("5", "Axis", 5),
        ("true", "Automatic", True),
    ):
        panel.browser.find_element(By.CSS_SELECTOR, f'[data-value="{value}"]').click()
        read = f"Main.Panel.{path}"
        panel.until(lambda: panel.program.read(read) == expected, path)  # noqa: B023
    panel.until(lambda: panel.shows("#message b") == "コントローラ準備未完了", "in Japanese")
    panel.until(lambda: panel.shows("[data-key=Start]") == "起動", "the keys, too")
