"""The page of `rcx view` works in a real browser: a user clicks, presses keys and reads."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from browser import NEEDS_BROWSER, chromium
from plcopen_drawings import element, program_of, project
from rcx_harness import Cell
from rcx_harness.robot import Axis, Controller, RobotConfig
from rcx_harness.robot.shape import shapes
from rcx_harness.trace import Cycle, Scan
from rcx_harness.trace.view.networks import DrawnProgram
from rcx_harness.trace.view.page import View
from structured_text.projects.sources import source_files

#: A browser takes seconds. The quick tier runs only the page of the panel.
pytestmark = [NEEDS_BROWSER, pytest.mark.exhaustive]
pytest.importorskip("selenium.webdriver", reason="selenium is not installed")

from selenium.webdriver.chrome.webdriver import WebDriver  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

_LIMIT_S = 60.0


class Page:
    """A page of `rcx view` as a user sees it."""

    def __init__(self, browser: WebDriver, file: Path) -> None:
        self.browser = browser
        browser.get(file.as_uri())
        self.until(lambda: self.run("document.documentElement.dataset.ready"))

    def until(self, condition: Callable[[], object]) -> None:
        """Wait until the condition holds."""
        wait = WebDriverWait(self.browser, _LIMIT_S, poll_frequency=0.05)
        wait.until(lambda _: condition())

    def run(self, expression: str) -> Any:
        """Return the value of a JavaScript expression."""
        return self.browser.execute_script(f"return {expression}")

    def click(self, selector: str) -> None:
        """Click the first element that matches the selector."""
        self.browser.find_element(By.CSS_SELECTOR, selector).click()

    def press(self, *keys: str) -> None:
        """Press keys."""
        ActionChains(self.browser).send_keys(*keys).perform()

    def text(self, selector: str) -> str:
        """Return the text of the first element that matches the selector."""
        return str(self.run(f"document.querySelector('{selector}')?.textContent ?? ''")).strip()

    def row(self, name: str) -> str:
        """Return the value next to the name of a signal, or an empty text without such a row."""
        rows = self.run(
            "[...document.querySelectorAll('.row:not(.group)')]"
            ".map((row) => [row.querySelector('.name').textContent,"
            " row.querySelector('.value').textContent])"
        )
        return str(dict(rows).get(name, ""))

    def shown(self) -> tuple[float, float]:
        """Return the visible interval of the time axis [s]."""
        words = self.run("document.getElementById('plot').getAttribute('aria-label')").split()
        return float(words[2]), float(words[5])

    def painted(self) -> int:
        """Return the number of colours in the chart, which is large if something is drawn."""
        script = """(() => {
          const plot = document.getElementById("plot");
          const data = plot.getContext("2d").getImageData(0, 0, plot.width, plot.height).data;
          return new Set(new Uint32Array(data.buffer)).size;
        })()"""
        return int(self.run(script))


@pytest.fixture(scope="module")
def browser() -> Iterator[WebDriver]:
    """Return Chromium without a window."""
    with chromium(1280, 900, "performance") as driver:
        yield driver


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace of ten minutes.

    At 300 s SI(00) and SI(06) change in one scan, which is a violation.
    """
    folder = tmp_path_factory.mktemp("view")
    program = Path(__file__).parents[2] / "cell/programs/RawArea.st"
    (folder / "lib").mkdir()
    given: dict[str, Any] = {"scan": "100ms", "engine": "builtin", "watch": "Main.*"}
    with Cell.build(program, lib=folder / "lib", positions="mm", **given) as cell:
        view = View(cell.trace.header)
        cell.trace.listen(view.take)
        cell.at(300_000_000, lambda: cell.__setitem__("Main.Bits0", 0x41))
        cell.at(301_000_000, lambda: cell.__setitem__("Main.Bits0", 0x43))
        cell.run("600s")
    page = folder / "page.html"
    page.write_text(view.page("RawArea.st"), encoding="utf-8")
    return page


@pytest.fixture(scope="module")
def moving(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace of a YK610XEC that turns axis 1 by 90 degrees.

    The second robot of the trace has no model.
    """
    scara = RobotConfig(robot=("YK610XEC",)).axes
    config = RobotConfig(robot=("YK610XEC",), axes=(*scara, Axis(robot=2)))
    controller = Controller(config)
    controller.positions[:] = [0] * 5
    names = [
        f"Robot {robot} axis {k} [pulses]" for robot, k in ((1, 1), (1, 2), (1, 3), (1, 4), (2, 1))
    ]
    header = {"cycle_us": 5000, "positions": [names], "robots": [shapes(controller)]}
    view = View(header)
    area = bytes(48)
    for k in range(101):
        where = (scara[0].pulses_per_mm * 0.9 * k, 0, 0, 0, 1000 * k)
        view.take(Cycle(5_000 * k, k, area, area, positions=where))
    page = tmp_path_factory.mktemp("moving") / "page.html"
    page.write_text(view.page("moving"), encoding="utf-8")
    return page


@pytest.fixture
def page(browser: WebDriver, file: Path) -> Page:
    return Page(browser, file)


def test_a_click_leads_to_the_broken_rule_of_ten_minutes(page: Page) -> None:
    """A click on a broken rule moves the cursor to its time and shows its text and section.

    The trace has ten minutes. The signals have their values at the time of the violation.
    """
    assert page.text("#rules") == "2 rules broken ▸"
    page.click("#rules")
    assert page.text("#a output") == "300.000 s"
    said = page.text("#whole")
    assert "plc, scan 3000: interval: SI(00) ON and SI(06) ON in one scan" in said
    assert said.endswith("(manual: ch. 5, 3)")
    begin, end = page.shown()
    assert begin < 300 < end < begin + 5
    page.until(lambda: page.row("SI(06) Stop input") == "ON")
    page.press("n")
    assert "robot, cycle 60003" in page.text("#whole")


def test_search_goes_to_the_next_edge_and_on_from_there(page: Page) -> None:
    page.press("/")
    page.press("next SI(01) edge")
    assert page.text("#count") == "1 event found"
    page.press(Keys.ENTER)
    assert page.text("#a output") == "301.000 s"
    assert page.text("#selected") == "SI(01) Servo ON input"
    page.press("\ue003" * 30, "si(00) on", Keys.ENTER)
    assert page.text("#a output") == "300.000 s"
    page.press(Keys.ESCAPE, Keys.HOME)
    page.until(lambda: page.shown()[1] < 300)
    page.press("/", "si(00) on", Keys.ENTER)
    page.until(lambda: page.shown()[0] < 300 < page.shown()[1])


def test_two_cursors_have_the_time_between_them(page: Page) -> None:
    """With two cursors, the time between them is shown.

    Only keys are pressed: they set cursor A at a change of SI(00) and cursor B at SI(01).
    """
    page.press("/", "SI(00) on", Keys.ENTER, Keys.ESCAPE)
    page.press("b", "/", "\ue003" * 30, "SI(01) on", Keys.ENTER, Keys.ESCAPE)
    assert page.text("#between output") == "1 s"
    page.press("c")
    page.until(lambda: page.shown() == (299.9, 301.1))


def test_keys_move_the_axis_and_choose_signals(page: Page) -> None:
    whole = page.shown()
    page.press("+")
    page.until(lambda: page.shown() != whole)
    half = page.shown()
    assert half[1] - half[0] == pytest.approx((whole[1] - whole[0]) / 2, rel=0.05)
    page.press(Keys.ARROW_RIGHT)
    page.until(lambda: page.shown()[0] > half[0])
    page.press("0")
    page.until(lambda: page.shown() == whole)
    for _ in range(10):
        page.press(Keys.ARROW_DOWN)
        if page.text("#selected") == "SI(06) Stop input":
            break
    page.press(".")
    assert page.text("#a output") == "300.000 s"
    rows = page.run("document.querySelectorAll('.row').length")
    while not page.text("#selected").startswith("Dedicated inputs"):
        page.press(Keys.ARROW_UP)
    page.press(Keys.ENTER)
    assert page.run("document.querySelectorAll('.row').length") == rows - 3, "SI(00), (01), (06)"
    page.press("?")
    assert page.run("document.getElementById('keys').open")
    page.press(Keys.ESCAPE)


def test_a_click_into_the_chart_puts_the_cursor_and_a_drag_moves_the_chart(page: Page) -> None:
    page.click("#in")
    plot = page.browser.find_element(By.ID, "plot")
    ActionChains(page.browser).move_to_element_with_offset(plot, 100, 40).click().perform()
    assert page.text("#a output").endswith(" s")
    before = page.shown()
    drag = ActionChains(page.browser).move_to_element_with_offset(plot, -100, 40)
    drag.click_and_hold().move_by_offset(-80, 0).release().perform()
    page.until(lambda: page.shown()[0] > before[0])
    begin, end = page.shown()
    assert end - begin == pytest.approx(before[1] - before[0], abs=1)


def test_two_fingers_zoom_and_the_time_under_them_stays_in_place(page: Page) -> None:
    """Two fingers zoom, and the time under them stays in place.

    Their distance grows from 100 px to 200 px, so half of the time is shown.
    """
    begin, end = page.shown()
    box = page.run("document.getElementById('plot').getBoundingClientRect().toJSON()")
    y, left = box["top"] + 40, box["left"]

    def touch(kind: str, *at: float) -> None:
        points = [{"x": left + x, "y": y, "id": k} for k, x in enumerate(at)]
        given = {"type": kind, "touchPoints": points}
        page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", given)

    touch("touchStart", 100)
    touch("touchStart", 100, 200)
    for far in (220, 250, 280, 300):
        touch("touchMove", 100, far)
    touch("touchEnd")
    page.until(lambda: page.shown()[1] - page.shown()[0] < (end - begin) * 0.6)
    now = page.shown()
    assert now[1] - now[0] == pytest.approx((end - begin) / 2, rel=0.02)
    at = 100 / box["width"]
    assert now[0] + at * (now[1] - now[0]) == pytest.approx(begin + at * (end - begin), abs=2)
    assert not re.search(r"\d", page.text("#a output")), "no cursor was set"


def test_resting_signals_are_shown_on_request(page: Page) -> None:
    count = "document.querySelectorAll('.row').length"
    few = page.run(count)
    assert not page.run("document.body.textContent.includes('SI(17)')")
    page.click("#still")
    assert page.run(count) > few
    assert page.run("document.getElementById('names').textContent.includes('SI(17)')")


def test_the_button_plays_the_run_and_pauses_it(browser: WebDriver, moving: Path) -> None:
    """The button plays the recording and pauses it. The cursor and the robot move with the time.

    The recording has 0.5 s.
    """
    page = Page(browser, moving)
    assert page.text("#play") == "▶ Play"
    page.run("document.getElementById('pace').value = '0.1'")
    page.click("#play")
    page.until(lambda: page.text("#when").startswith("at 0.0"))
    assert "Pause" in page.text("#play")
    page.press(" ")
    page.until(lambda: page.text("#play") == "▶ Play")
    page.run("document.getElementById('pace').value = '20'")
    page.click("#play")
    page.until(lambda: page.text("#a output") == "0.500 s" and page.text("#play") == "▶ Play")


@pytest.mark.parametrize("width", [400, 760])
def test_a_narrow_page_begins_with_the_robot(browser: WebDriver, moving: Path, width: int) -> None:
    """On a narrow page, as in the playground, the robot is the first element."""
    size = {"width": width, "height": 700, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page = Page(browser, moving)
        bottom = "document.querySelector('.rv').getBoundingClientRect().bottom"
        assert page.run(bottom) <= 700
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_light_and_dark_are_drawn_in_their_own_colours(page: Page) -> None:
    before = page.run("getComputedStyle(document.body).backgroundColor")
    assert page.painted() > 5
    page.press("t")
    assert page.run("getComputedStyle(document.body).backgroundColor") != before
    assert page.painted() > 5


def test_everything_can_be_focused_and_has_a_name(page: Page) -> None:
    nameless = page.run(
        "[...document.querySelectorAll('button, input, canvas, [tabindex]')]"
        ".filter((one) => !(one.ariaLabel || one.textContent.trim() || one.labels?.length"
        " || one.title)).map((one) => one.id)"
    )
    assert nameless == []
    page.press(Keys.TAB)
    outline = "getComputedStyle(document.activeElement).outlineStyle"
    assert page.run(outline) not in ("none", "")


def test_the_page_asks_no_network_and_logs_nothing(browser: WebDriver, file: Path) -> None:
    log: Any = browser
    log.get_log("performance")
    log.get_log("browser")
    Page(browser, file)
    asked = [entry["message"] for entry in log.get_log("performance")]
    sent = [one for one in asked if '"Network.requestWillBeSent"' in one]
    assert [one for one in sent if '"url":"http' in one] == []
    assert log.get_log("browser") == []


def test_the_page_prints_on_a4_with_its_events(page: Page) -> None:
    page.click("#rules")
    page.run("window.dispatchEvent(new Event('beforeprint'))")
    assert page.run("document.querySelectorAll('#paper canvas').length") >= 1
    assert "SI(00) ON and SI(06) ON in one scan" in page.text("#paper table")
    assert "RawArea.st" in page.text("#paper h1")
    page.run("window.dispatchEvent(new Event('afterprint'))")
    assert page.text("#paper") == ""
    given = {"preferCSSPageSize": True}
    pdf = base64.b64decode(page.browser.execute_cdp_cmd("Page.printToPDF", given)["data"])
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert box is not None
    assert [float(one) for one in box.groups()] == pytest.approx([841.9, 595.3], abs=1)


def test_the_robots_are_drawn_in_their_pose_at_the_cursor(browser: WebDriver, moving: Path) -> None:
    """The robots are drawn in their pose at the cursor.

    The arms have 335 and 275 mm. They point to the front at first, and to the left after 90
    degrees.
    """
    page = Page(browser, moving)

    def told() -> list[str]:
        script = "[...document.querySelectorAll('#robots .rv')].map((one) => one.ariaLabel)"
        found: list[str] = page.run(script)
        return found

    page.until(lambda: told()[0].startswith("Robot 1, YK610XEC: X -610, Y 0, Z 0, R 180"))
    assert told()[1] == "Robot 2: 1 100"
    assert page.text("#when") == "at the end"
    way = "document.querySelector('.rv-trail').getAttribute('d').match(/[ML]/g).length"
    assert page.run(way) == 100
    while page.text("#selected") != "Robot 1 axis 1 [pulses]":
        page.press(Keys.ARROW_DOWN)
    page.press(".", ".")
    # At 10 ms the angle is 1.8 degrees, so X and Y are 610 mm times its sine and cosine.
    page.until(lambda: told()[0].startswith("Robot 1, YK610XEC: X -19.161, Y 609.699, Z 0, R 91.8"))
    assert told()[1] == "Robot 2: 1 2"
    assert page.text("#when") == "at 0.010 s"
    assert page.run(way) == 2


def test_the_robots_are_printed_as_they_stand(browser: WebDriver, moving: Path) -> None:
    page = Page(browser, moving)
    page.until(lambda: page.run("document.querySelectorAll('#robots .rv-tip').length") == 2)
    page.run("window.dispatchEvent(new Event('beforeprint'))")
    assert page.run("document.querySelectorAll('#paper .rv').length") == 2
    assert page.run("document.querySelectorAll('#paper .rv-tip').length") == 2
    clips = "[...document.querySelectorAll('clipPath')].map((one) => one.id)"
    found = page.run(clips)
    assert len(set(found)) == len(found) == 4
    page.run("window.dispatchEvent(new Event('afterprint'))")


@pytest.mark.parametrize("width", [400, 1280])
def test_the_page_fits_narrow_and_wide_windows(browser: WebDriver, file: Path, width: int) -> None:
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page = Page(browser, file)
        assert page.run("document.documentElement.scrollWidth") <= width
        assert page.painted() > 5
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.fixture(scope="module")
def programmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a trace of a program with a new line every 100 ms that stops in line 50.

    The program has 60 lines.
    """
    lines = [f"DELAY {k}  ' the {k}th" for k in range(1, 61)]
    spare = {"name": "SPARE", "lines": ["HALT"]}
    programs = [[{"name": "LONG", "file": "LONG.PGM", "lines": lines}, spare]]
    view, area = View({"cycle_us": 5000, "programs": programs}), bytes(48)
    for k in range(51):
        task = {"task": 1, "program": "LONG", "line": min(k + 1, 50), "state": "running"}
        task |= {"state": "stopped"} if k == 50 else {}
        view.take(Cycle(100_000 * k, 20 * k, area, area, tasks=(task,)))
    page = tmp_path_factory.mktemp("programmed") / "page.html"
    page.write_text(view.page("programmed"), encoding="utf-8")
    return page


_MARKED = (
    "[...document.querySelectorAll('#programs [data-state]')]"
    ".map((row) => `${row.dataset.state} ${row.textContent}`)"
)
_SEEN = """(() => {
  const [box, row] = ["#programs .lines", "#programs [data-state]"]
    .map((one) => document.querySelector(one).getBoundingClientRect());
  return row.top >= box.top && row.bottom <= box.bottom;
})()"""


def test_the_line_of_a_task_at_the_cursor_is_marked(browser: WebDriver, programmed: Path) -> None:
    """The listing marks the line of the task at the cursor.

    Without a cursor, the last line is marked, where the task is stopped. Line 7 is executed from
    600 ms on; a click on it moves the cursor to this time.
    """
    page = Page(browser, programmed)
    page.until(lambda: page.run(_MARKED) == ["stopped 50DELAY 50  ' the 50th"])
    assert page.run(_SEEN)
    assert page.text("#programs .listing summary").endswith("task 1, line 50, stopped")
    assert page.run("document.querySelectorAll('#programs .listing[open]').length") == 1
    page.run("document.querySelectorAll('#programs .lines > div > div')[6].click()")
    page.until(lambda: page.run(_MARKED) == ["running 7DELAY 7  ' the 7th"])
    assert page.run(_SEEN)
    assert page.text("#a output") == "0.600 s"
    assert page.row("Task 1") == "LONG:7 DELAY 7"
    assert page.text("#selected") == "Task 1"
    page.press(".")
    page.until(lambda: page.run(_MARKED) == ["running 8DELAY 8  ' the 8th"])


def test_playing_moves_the_line(browser: WebDriver, programmed: Path) -> None:
    page = Page(browser, programmed)
    page.press(" ")
    page.until(lambda: page.text("#programs .listing summary").endswith("stopped"))
    assert page.run(_SEEN)


@pytest.mark.parametrize("width", [400, 1280])
def test_listings_fit_the_window(browser: WebDriver, programmed: Path, width: int) -> None:
    """Listings fit the window: long lines scroll in their listing and not with the page."""
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page = Page(browser, programmed)
        page.until(lambda: page.run(_MARKED))
        assert page.run("document.documentElement.scrollWidth <= innerWidth")
        assert page.run("document.querySelector('#programs .lines').clientHeight") >= 90
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the page of three scans of a rung: Start is TRUE in the second one."""
    folder = tmp_path_factory.mktemp("drawn")
    rung = element("leftPowerRail", 1) + element("contact", 2, "Start", "1", at="50 0")
    rung += element("contact", 3, "A[N]", "2", at="80 0")
    rung += element("coil", 4, "Motor", "3", at="99 0", storage="set")
    shown = element("inVariable", 5, "N", at="0 99") + element(
        "outVariable", 6, "M", "5", at="50 99"
    )
    text = project("Start Motor : BOOL; A : Bits; N M : INT", f"<LD>{rung}{shown}</LD>")
    bits = '<dataType name="Bits"><baseType><array><dimension lower="0" upper="1"/>'
    bits += "<baseType><BOOL/></baseType></array></baseType></dataType>"
    text = text.replace("<types>", f"<types><dataTypes>{bits}</dataTypes>")
    program = program_of(folder, text)
    networks = DrawnProgram(program, source_files(folder / "plc.xml", None).own)
    view = View(networks.header({"scan_us": 10_000}), networks.groups)
    for number in range(3):
        program.write("Main.Start", number == 1)
        program.write("Main.N", number % 2)
        program.scan(number * 10_000)
        view.take(networks.filled(Scan(number * 10_000, number, bytes(48), bytes(48))))
    page = folder / "page.html"
    page.write_text(view.page("drawn"), encoding="utf-8")
    return page


def test_the_networks_show_what_has_power_at_the_cursor(browser: WebDriver, drawn: Path) -> None:
    """A[N] depends on an index, so it is not known; nor is the power of the coil behind it."""
    page = Page(browser, drawn)
    page.until(lambda: page.text("#networks .when") == "at the end")
    values = "[...document.querySelectorAll('#networks tspan')].map((one) => one.textContent)"
    assert page.run(values) == ["0", "0"]
    assert page.run("document.querySelectorAll('#networks path.on').length") == 2
    page.run("document.querySelector('#networks [data-name]').dispatchEvent(new Event('click'))")
    assert page.text("#selected") == "Main.Start"
    page.press("Home", ".")
    page.until(lambda: page.text("#networks .when") == "at 0.010 s")
    assert page.run(values) == ["1", "1"]
    assert page.run("document.querySelectorAll('#networks path.on').length") == 4
    assert page.run("document.querySelectorAll('#networks path.unknown').length") == 4
