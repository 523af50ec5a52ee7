"""A key that is pressed on the faceplate in a real browser is pressed in the program."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

import pytest

from browser import NEEDS_BROWSER, chromium
from plc_bench import ROOT, compiled
from rcx_harness.serve.panel.plate import HOLD_S, plates_of
from rcx_harness.serve.panel.server import PanelServer
from rcx_tools.library.version import version

pytestmark = [NEEDS_BROWSER, pytest.mark.exhaustive]
pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

from selenium.webdriver.chrome.webdriver import WebDriver  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

_LIMIT_S = 60.0
_BENCH = ROOT / "tests/data/library/Operator.st"


class _Panel:
    """A program that is scanned while the test waits, and its page."""

    def __init__(self, browser: WebDriver) -> None:
        self.browser, self.now = browser, 100.0
        self.program = compiled(_BENCH, "builtin")
        (self.plate,) = plates_of(self.program, lambda: self.now)
        self._scans, self.heard = 0, 0.0
        press = self.plate.press

        def heard(page: str, beat: int, keys: Collection[str]) -> None:
            press(page, beat, keys)
            self.heard = self.now

        vars(self.plate)["press"] = heard

    def scan(self) -> None:
        """Run one scan, with the exchange before it."""
        self.plate.exchange()
        self.program.scan(self._scans * 10_000)
        self._scans += 1

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Run scans until the condition holds."""

        def now(_: WebDriver) -> object:
            self.scan()
            return condition()

        WebDriverWait(self.browser, _LIMIT_S, poll_frequency=0.02).until(now, what)

    def key(self, name: str) -> bool:
        """Return whether the key is pressed in the program."""
        return bool(self.program.read(f"Main.Panel.Key.{name}"))

    def shows(self, selector: str) -> str:
        """Return the text of the element with this selector."""
        script = "return document.querySelector(arguments[0])?.innerText ?? ''"
        return str(self.browser.execute_script(script, selector))


@pytest.fixture(scope="module")
def browser() -> Iterator[WebDriver]:
    """Return a browser that all tests share."""
    with chromium(1280, 900) as driver:
        yield driver


@pytest.fixture
def panel(browser: WebDriver) -> Iterator[_Panel]:
    """Return a panel with an open page."""
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
    for _ in range(6):
        panel.now += HOLD_S / 2
        heard = panel.plate.shown()["Key"]["JogPlus"]
        assert heard
        panel.until(lambda: panel.heard == panel.now, "the page says it again")
    ActionChains(panel.browser).release(button).perform()
    panel.until(lambda: not panel.key("JogPlus"), "released")


def test_a_page_that_is_left_releases_its_key(panel: _Panel) -> None:
    button = panel.browser.find_element(By.CSS_SELECTOR, "[data-key=JogPlus]")
    ActionChains(panel.browser).click_and_hold(button).perform()
    panel.until(lambda: panel.key("JogPlus"), "pressed")
    panel.browser.get("about:blank")
    panel.now += HOLD_S + 0.01
    panel.until(lambda: not panel.key("JogPlus"), "released")
    ActionChains(panel.browser).release().perform()


@pytest.mark.exhaustive
def test_the_page_shows_the_version_of_the_library(panel: _Panel) -> None:
    """The page shows the version of the library, which is the version of the package.

    Source: FC_LibraryVersion.
    """
    panel.until(lambda: panel.shows("#version") == version(), "that of FB_Operator")


@pytest.mark.exhaustive
def test_selections_are_chosen_and_the_message_is_shown_in_its_language(panel: _Panel) -> None:
    """Source: spec/errors.toml, 16#8002: SO(01) is OFF, because no controller is simulated."""
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


def _type_point(panel: _Panel, text: str) -> None:
    """Type another text into the field of the point to teach, which keeps the focus."""
    field = panel.browser.find_element(By.CSS_SELECTOR, "[data-number=Point]")
    field.click()
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys(text or Keys.DELETE)


def _sent(panel: _Panel) -> list[object]:
    """Return a list that collects the choices and pressed keys that the page sends from now on."""
    sent: list[object] = []
    plate = panel.plate
    choose, press = plate.choose, plate.press

    def chosen(name: str, value: object) -> None:
        sent.append((name, value))
        choose(name, value)

    def pressed(page: str, beat: int, keys: Collection[str]) -> None:
        sent.extend(key for key in keys if key not in held)
        held.clear()
        held.update(keys)
        press(page, beat, keys)

    held: set[str] = set()
    plate.choose, plate.press = chosen, pressed  # type: ignore[method-assign]
    return sent


def test_a_typed_number_is_sent_before_the_next_key(panel: _Panel) -> None:
    """A typed number is in the program before the key that is pressed next.

    The field still has the focus when the mouse button is pressed on the key.

    Source: RCX_PANEL, Point is where Teach stores.
    """
    sent = _sent(panel)
    _type_point(panel, "123")
    panel.browser.find_element(By.CSS_SELECTOR, "[data-key=Teach]").click()
    panel.until(lambda: panel.key("Teach"), "pressed")
    panel.until(lambda: not panel.key("Teach"), "released")
    assert sent == [("Point", 123), "Teach"]


@pytest.mark.exhaustive
def test_a_field_without_a_number_sends_nothing_and_shows_the_old_number(panel: _Panel) -> None:
    """A field without a number sends nothing and shows the old number again.

    A press of Teach is not sent either, because an empty field means that another point was
    intended.

    Source: RCX_PANEL, Point is where Teach stores.
    """
    sent = _sent(panel)
    _type_point(panel, "12" + Keys.TAB)
    panel.until(lambda: panel.program.read("Main.Panel.Point") == 12, "chosen")
    panel.until(lambda: _shown_point(panel, "dataset.shown") == "12", "heard of by the page")
    _type_point(panel, "")
    panel.browser.find_element(By.CSS_SELECTOR, "[data-key=Teach]").click()
    panel.until(lambda: panel.shows("#refused").startswith("There was no number"), "told")
    assert _shown_point(panel) == "12"
    _type_point(panel, "")
    panel.browser.find_element(By.CSS_SELECTOR, "[data-key=Stop]").click()
    panel.until(lambda: panel.key("Stop"), "a stop is pressed in any case")
    assert sent == [("Point", 12), "Stop"]


@pytest.mark.exhaustive
def test_a_key_is_not_pressed_with_a_number_that_was_refused(panel: _Panel) -> None:
    """Source: RCX_PANEL, Point is 0 to 29999."""
    sent = _sent(panel)
    _type_point(panel, "30000")
    panel.browser.find_element(By.CSS_SELECTOR, "[data-key=Teach]").click()
    panel.until(lambda: panel.shows("#refused") == _REFUSED, "told")
    panel.browser.find_element(By.CSS_SELECTOR, "[data-key=Start]").click()
    panel.until(lambda: panel.key("Start"), "pressed")
    assert sent == [("Point", 30000), "Start"]
    panel.browser.get_log("browser")  # type: ignore[no-untyped-call]


_REFUSED = "Point cannot be 30000; use 0 to 29999"


def _shown_point(panel: _Panel, where: str = "value") -> object:
    script = f"return document.querySelector('[data-number=Point]').{where}"
    return panel.browser.execute_script(script)
