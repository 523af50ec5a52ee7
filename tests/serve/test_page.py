"""The web page is tested in a real browser with a real scanner: its buttons work."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count, pairwise
from pathlib import Path

import pytest

from browser import NEEDS_BROWSER, chromium
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.serve.web import FILES
from rcx_harness.trace import Cycle, read_trace
from serve_process import ServeProcess, own_addresses

#: A browser takes seconds. The quick tier runs only the page of the panel.
pytestmark = [NEEDS_BROWSER, pytest.mark.exhaustive]
pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

from selenium.webdriver.chrome.webdriver import WebDriver  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.remote.webelement import WebElement  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

_LIMIT_S = 300.0
_MULTIPLIER = 5  # a time-out of 128 packet intervals, so that a busy machine does not lose the link
_STOPS_RELEASED = bytes(32) + b"\x41" + bytes(15)
#: The robot file of the first controller.
_PROGRAM = """
[[programs]]
name = "ECHO"
text = '''
*AGAIN:
WAIT SI(20)=1
SO(20)=1
WAIT SI(20)=0
SO(20)=0
GOTO *AGAIN
'''
"""


class Page:
    """The page of `rcx serve` as a user sees it."""

    def __init__(self, browser: WebDriver) -> None:
        self.browser = browser

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Wait until the condition is true."""
        wait = WebDriverWait(self.browser, _LIMIT_S, poll_frequency=0.05)
        wait.until(lambda _: condition(), what)

    def find(self, selector: str) -> WebElement:
        """Return the first element that matches the selector."""
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def press(self, selector: str) -> None:
        """Click the element when it has stopped moving on the page.

        If a line appears above the element, it moves. A click at its earlier position would be
        lost.
        """
        element = self.find(selector)
        places = [element.rect]

        def rests() -> bool:
            places.append(element.rect)
            return places[-1] == places[-2]

        self.until(rests, f"{selector} moves all the time")
        element.click()

    def text(self, selector: str) -> str:
        """Return the text of the element, read in one call because the page may rebuild it."""
        script = "return document.querySelector(arguments[0])?.innerText ?? ''"
        return str(self.browser.execute_script(script, selector))

    def lamp(self, signal: str) -> str:
        """Return the lamp of a signal in the signal monitor, found by its tooltip."""
        return self.text(f'#monitor td[title^="{signal}"]')

    def wave(self, signal: str) -> str:
        """Return the path of a signal's wave in the timing chart."""
        script = """
          const root = document.getElementById("chart").shadowRoot;
          const names = [...root.querySelectorAll("text")];
          const name = names.find((one) => one.textContent.startsWith(arguments[0]));
          let next = name?.nextElementSibling;
          while (next && next.tagName !== "path") next = next.nextElementSibling;
          return next?.getAttribute("d") ?? "";
        """
        return str(self.browser.execute_script(script, signal))

    def pressed(self, selector: str) -> bool:
        """Return whether the button is shown as pressed."""
        return self.find(selector).get_attribute("aria-pressed") == "true"


@pytest.fixture(scope="module")
def browser() -> Iterator[WebDriver]:
    """Return Chromium without a window."""
    with chromium(1500, 1400) as driver:
        yield driver


@pytest.fixture(scope="module")
def addresses() -> list[str]:
    """Return the addresses of two controllers."""
    return own_addresses(2)


@pytest.fixture(scope="module")
def page(
    browser: WebDriver, addresses: list[str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Page]:
    """Return the page of two served controllers; the second robot is of a known type."""
    folder = tmp_path_factory.mktemp("served")
    texts = (_PROGRAM, 'robot = "SXYX"\n[[axes]]\nstart = 122880\n')
    options = ["--web", "0"]
    for number, (address, text) in enumerate(zip(addresses, texts, strict=True)):
        (folder / f"{number}.toml").write_text(text, encoding="utf-8")
        options += ["--address", address, "--robot", str(folder / f"{number}.toml")]
    with ServeProcess(*options) as served:
        browser.get(served.wait_for("web page: ").partition(": ")[2])
        page = Page(browser)
        page.until(lambda: page.text("#connection"), "the page shows no connection")
        yield page
        served.interrupt()
        assert served.end()[0] == 0


@pytest.fixture
def scanner(page: Page, addresses: list[str]) -> Iterator[Scanner]:
    """Return the first controller's master, which has released both stops."""
    with Scanner(addresses[0], rpi_us=10_000, multiplier=_MULTIPLIER, io_port=0) as scanner:
        scanner.write(_STOPS_RELEASED)
        scanner.open()
        page.press("nav button:first-child")
        page.until(lambda: page.lamp("SO(00)") == "○", "the emergency stop is not released")
        yield scanner


def test_the_emergency_stop_button_stops_and_is_seen_everywhere(
    page: Page, scanner: Scanner
) -> None:
    assert "connected: 127." in page.text("#connection")
    page.press('[data-seconds="60"]')  # a slow machine draws the chart late
    page.until(lambda: page.wave("SO(00)"), "there is no chart")
    page.press("#stop")
    page.until(lambda: page.lamp("SO(00)") == "●", "SO(00) is not shown")
    page.until(lambda: page.pressed("#stop"), "the button does not show that it is pressed")
    page.until(lambda: "12.600" in page.text("#alarms"), "the alarm is not shown")
    # A rise is a vertical line from OFF to ON within the wave.
    page.until(lambda: _rises(page.wave("SO(00)")), "the chart does not show the rise of SO(00)")
    page.until(lambda: scanner.read().image[32] & 1, "the master does not see SO(00)")

    page.press("#stop")
    page.until(lambda: page.lamp("SO(00)") == "○", "the emergency stop is not released")
    page.until(lambda: not page.pressed("#stop"), "the button stays pressed")
    assert "12.600" in page.text("#alarms")


def test_a_cut_cable_is_a_time_out_and_a_restored_one_is_no_connection_yet(
    page: Page, scanner: Scanner
) -> None:
    page.press('[data-event="link_down"]')
    page.until(lambda: "timed out" in page.text("#connection"), "there is no time-out")
    assert "the network cable is unplugged" in page.text("#connection")
    page.until(lambda: "red, flashing" in page.text("#leds"), "the LED is not red")
    page.until(lambda: "12.552" in page.text("#alarms"), "the alarm is not shown")
    page.press('[data-event="link_up"]')
    page.until(lambda: page.pressed('[data-event="link_up"]'), "the cable is not plugged in")
    scanner.open()
    page.until(lambda: "connected: 127." in page.text("#connection"), "it does not recover")


def test_after_power_off_and_on_a_master_can_connect_again(page: Page, scanner: Scanner) -> None:
    page.press('[data-event="power_off"]')
    page.until(lambda: "the controller is off" in page.text("#connection"), "it is not off")
    page.until(lambda: not scanner.read().connected, "the master has not lost it")
    page.press('[data-event="power_on"]')
    page.until(lambda: "online, but not connected" in page.text("#leds"), "it does not start")
    scanner.open()
    page.until(lambda: "connected: 127." in page.text("#connection"), "there is no connection")


def test_mode_authority_alarm_and_power_have_their_buttons(page: Page, scanner: Scanner) -> None:
    page.press('[data-event="manual_mode"]')
    page.until(lambda: page.lamp("SO(10)") == "○", "SO(10) stays ON in MANUAL mode")
    page.press('[data-event="auto_mode"]')
    page.until(lambda: page.lamp("SO(10)") == "●", "SO(10) does not come back")
    page.press('[data-event="pendant_on"]')
    page.until(lambda: page.pressed('[data-event="pendant_on"]'), "no authority of the pendant")
    page.press('[data-event="pendant_off"]')
    page.until(lambda: page.pressed('[data-event="pendant_off"]'), "no authority of the master")
    page.press("#alarm button")
    page.until(lambda: "99.999" in page.text("#alarms"), "the alarm is not raised")
    page.press('[data-event="power_cycle"]')
    page.until(lambda: "99.999" not in page.text("#alarms"), "the power was not cycled")
    page.until(lambda: "online, but not connected" in page.text("#leds"), "it does not start")
    page.until(lambda: not scanner.read().connected, "the master has not lost it")


def test_warning_main_power_safety_and_the_stop_of_the_parallel_io_have_their_buttons(
    page: Page, scanner: Scanner
) -> None:
    """Warning, main power, safety input and the stop of the parallel I/O have buttons that work.

    SO(15) is the warning. SO(04) MP RDY depends on the main power (manual chapter 5, 2).
    """
    page.press('[data-event="warning"]')
    page.until(lambda: page.lamp("SO(15)") == "●", "SO(15) does not come ON")
    page.press('[data-event="warning_clear"]')
    page.until(lambda: page.lamp("SO(15)") == "○", "SO(15) stays ON")
    page.press('[data-event="main_power_off"]')
    page.until(lambda: page.lamp("SO(04)") == "○", "SO(04) stays ON without main power")
    page.press('[data-event="main_power_on"]')
    page.until(lambda: page.lamp("SO(04)") == "●", "SO(04) does not come back")
    for event, back in (("safety_on", "safety_off"), ("parallel_stop", "parallel_stop_release")):
        page.press(f'[data-event="{event}"]')
        page.until(lambda: page.pressed(f'[data-event="{event}"]'), f"no {event}")  # noqa: B023
        page.press(f'[data-event="{back}"]')
        page.until(lambda: page.pressed(f'[data-event="{back}"]'), f"no {back}")  # noqa: B023


def test_outputs_inputs_and_workpieces_have_their_forms(page: Page, scanner: Scanner) -> None:
    name = page.find("#output-name")
    name.clear()
    name.send_keys("SO(20)")
    page.press('#output [value="1"]')
    page.until(lambda: scanner.read().image[34] & 1, "the master does not see SO(20)")
    page.until(lambda: "SO(20)" in page.text("#held"), "what is held is not shown")
    page.press("#held button")
    page.until(lambda: not scanner.read().image[34] & 1, "SO(20) is not released")
    page.press('#parallel [value="1"]')
    page.press('#workpiece [value="place"]')
    page.until(lambda: "axis 3: 90000 pulses" in page.text("#workpieces"), "no workpiece")
    page.press("#workpieces button")
    page.until(lambda: not page.text("#workpieces"), "the workpiece stays")
    name.clear()
    name.send_keys("SI(01)", Keys.ENTER)
    page.until(lambda: "SI(01) is an input" in page.text("#refused-too"), "nothing is refused")


def test_actions_are_recorded_and_become_a_stimulus(
    page: Page, scanner: Scanner, tmp_path: Path
) -> None:
    def got(selector: str) -> str:
        """Return the content of the address of this link."""
        script = """
          const [selector, done] = arguments;
          fetch(document.querySelector(selector).href).then((one) => one.text()).then(done);
        """
        return str(page.browser.execute_async_script(script, selector))

    assert page.find("#recording").get_attribute("href") is None
    page.press("#begin")
    page.press("#record")
    page.until(lambda: page.text("#record") == "Stop", "it is not recorded")
    page.press('[data-event="warning"]')
    page.until(lambda: page.lamp("SO(15)") == "●", "no warning")
    page.press('[data-event="warning_clear"]')
    page.until(lambda: page.lamp("SO(15)") == "○", "the warning stays")
    page.press("#record")
    page.until(lambda: page.find("#recording").get_attribute("href"), "there is no recording")
    (tmp_path / "r.jsonl").write_text(got("#recording"), encoding="utf-8")
    (tmp_path / "s.toml").write_text(got("#stimulus"), encoding="utf-8")
    header, records = read_trace(tmp_path / "r.jsonl")
    assert header["positions"]
    warned = [one.rcx_so[33] >> 5 & 1 for one in records if isinstance(one, Cycle)]
    assert (warned[0], max(warned), warned[-1]) == (0, 1, 0)
    entries = Stimulus.load(tmp_path / "s.toml").entries
    assert [one.events for one in entries] == [(("warning", {}),), (("warning_clear", {}),)]


def test_the_robot_is_drawn_and_its_axes_are_shown_in_pulses_and_mm(page: Page) -> None:
    """The robot is drawn, and its axes are shown in pulses and mm.

    The tool is at 150 mm in X. An SXYX has 819.2 pulses per mm.
    """
    page.press("nav button:nth-child(2)")
    drawn = "return document.querySelector('#robots .rv')?.ariaLabel"
    expected = "Robot 1, SXYX: X 150, Y 0, Z 0"
    page.until(lambda: page.browser.execute_script(drawn) == expected, "it is not drawn")
    row = page.text("#positions tbody tr").split("\t")
    assert row[:4] == ["Axis 1", "122880", "X [mm]", "150.000"]
    assert page.find("#positions .trend path").get_attribute("d")
    page.press("nav button:first-child")
    expected = "Robot 1: 1 0, 2 0, 3 0, 4 0"
    page.until(lambda: page.browser.execute_script(drawn) == expected, "the other one is drawn")


def test_the_listing_shows_the_line_that_is_executed_now(page: Page, scanner: Scanner) -> None:
    """The listing marks the line that is executed: line 2 waits for SI(20) ON, line 4 for OFF.

    SI(12) starts the program. An earlier test has closed the link and left alarm 12.600, with which
    no program starts. Therefore the main power is cycled first.
    """
    marked = "return document.querySelector('#programs [data-state]')?.textContent ?? ''"

    def until(text: str) -> None:
        page.until(lambda: page.browser.execute_script(marked) == text, f"{text} is not marked")

    page.press('[data-event="power_cycle"]')
    page.until(lambda: not scanner.read().connected, "the master has not lost it")
    page.until(lambda: "online, but not connected" in page.text("#leds"), "it does not start")
    scanner.write(_STOPS_RELEASED)
    scanner.open()
    page.until(lambda: page.lamp("SO(00)") == "○", "the emergency stop is not released")
    until("")
    assert page.text("#programs .listing summary") == "ECHO\ntask 1, ready"
    polls = count()

    def started() -> bool:
        """Return whether the robot program runs, and toggle SI(12) if it does not.

        SI(12) changes every 0.5 s, because at least 100 ms are needed.
        """
        on = b"\x04" if next(polls) // 10 % 2 == 0 else b"\x00"
        scanner.write(bytes(32) + b"\x41" + on + bytes(14))
        return bool(page.browser.execute_script(marked) == "2WAIT SI(20)=1")

    page.until(started, "the program is not started")
    scanner.write(bytes(32) + b"\x41\x00\x01" + bytes(13))
    until("4WAIT SI(20)=0")
    scanner.write(_STOPS_RELEASED)
    until("2WAIT SI(20)=1")
    page.press("nav button:nth-child(2)")
    page.until(lambda: not page.find("#programs").is_displayed(), "another program is shown")
    page.press("nav button:first-child")
    until("2WAIT SI(20)=1")


def test_everything_can_be_reached_by_keyboard_and_has_a_name(page: Page) -> None:
    nameless = page.browser.execute_script(
        "return [...document.querySelectorAll('button, input, a, [tabindex], [role=group]')]"
        ".filter((one) => !(one.ariaLabel || one.textContent.trim() || one.labels?.length"
        " || one.title)).map((one) => one.outerHTML)"
    )
    assert nameless == []
    page.find("#stop").send_keys("")
    page.browser.execute_script("document.getElementById('stop').focus()")
    ActionChains(page.browser).send_keys(Keys.TAB, Keys.TAB).perform()
    focused = "return document.activeElement.dataset.event"
    assert page.browser.execute_script(focused) == "manual_mode"
    outline = "return getComputedStyle(document.activeElement).outlineStyle"
    assert page.browser.execute_script(outline) == "solid"
    ActionChains(page.browser).send_keys(Keys.SPACE).perform()
    page.until(lambda: page.pressed('[data-event="manual_mode"]'), "the key does nothing")
    page.press('[data-event="auto_mode"]')
    page.until(lambda: page.pressed('[data-event="auto_mode"]'), "AUTO does not come back")
    page.browser.execute_script("document.getElementById('chart').focus()")
    ActionChains(page.browser).send_keys(Keys.ARROW_LEFT, Keys.ENTER, Keys.ARROW_LEFT).perform()
    assert "ms from the click" in page.text("#measure")


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [400, 1280])
def test_it_fits_narrow_and_wide_windows(page: Page, width: int, theme: str) -> None:
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser = page.browser
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    media = {"features": [{"name": "prefers-color-scheme", "value": theme}]}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    try:
        script = "return document.documentElement.scrollWidth"
        page.until(lambda: browser.execute_script(script) <= width, "it is too wide")
        colour = "return getComputedStyle(document.body).backgroundColor"
        light = browser.execute_script(colour) == "rgb(238, 242, 246)"
        assert light == (theme == "light")
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_each_controller_has_its_tab(page: Page, addresses: list[str]) -> None:
    page.press("nav button:nth-child(2)")
    page.until(lambda: "no master has connected yet" in page.text("#connection"), "no second tab")
    assert [page.text(f"nav button:nth-child({k})") for k in (1, 2)] == addresses
    page.press("nav button:first-child")


def test_the_chart_can_be_paused_and_shows_the_seconds_that_are_chosen(page: Page) -> None:
    script = "return document.getElementById('chart').shadowRoot.querySelector('svg').dataset"

    def axis() -> dict[str, str]:
        shown: dict[str, str] = page.browser.execute_script(script)
        return shown

    page.press('[data-seconds="2"]')
    page.until(lambda: axis()["span"] == "2000000", "the window is not 2 s")
    before = axis()["start"]
    page.until(lambda: axis()["start"] != before, "the chart stands still")
    page.press("#pause")
    # A picture that was requested earlier may still arrive. After it, no picture may arrive.
    page.press('[data-seconds="5"]')
    page.until(lambda: axis()["span"] == "5000000", "another window is not drawn while paused")
    stood = axis()["start"]
    cycles = page.text("#figures")
    page.until(lambda: page.text("#figures") != cycles, "the figures stand still")
    assert axis()["start"] == stood
    page.press("#pause")
    page.until(lambda: axis()["start"] != stood, "the chart does not go on")


def test_a_wrong_alarm_number_is_refused_in_words(page: Page) -> None:
    field = page.find('[name="group"]')
    field.clear()
    field.send_keys("99999")
    page.press("#alarm button")
    page.until(lambda: page.text("#refused"), "nothing is said of the refusal")
    assert page.text("#refused") == "group = 99999 of event 'alarm' is not a number from 0 to 65535"
    field.clear()
    field.send_keys("99")  # other tests use the same page


def test_the_page_asks_no_other_server_and_has_no_error(page: Page) -> None:
    script = "return performance.getEntriesByType('resource').map((one) => one.name)"
    asked: list[str] = page.browser.execute_script(script)
    own = page.browser.current_url
    served = {path.lstrip("/") for path in FILES} | {"api"}
    assert {name.removeprefix(own).partition("/")[0] for name in asked} <= served
    entries = page.browser.get_log("browser")  # type: ignore[no-untyped-call]
    refused = ("/events", "/outputs")
    unexpected = [
        one["message"] for one in entries if not any(path in one["message"] for path in refused)
    ]
    assert unexpected == []


def _rises(path: str) -> bool:
    """Return whether the path contains a vertical line upwards."""
    levels = [float(part.partition("H")[0]) for part in path.split("V")[1:]]
    return any(later < earlier for earlier, later in pairwise(levels))
