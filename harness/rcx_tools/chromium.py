"""Headless Chromium, to check the appearance and the speed of a page."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from selenium.webdriver.chrome.webdriver import WebDriver

__all__ = ["LIMIT_S", "MISSING", "chromium", "is_there", "opened"]

MISSING = "chromium and chromedriver are not installed"
#: Time limit of each step in the browser [s].
LIMIT_S = 120


def is_there() -> bool:
    """Return whether Chromium can be started."""
    return bool(shutil.which("chromium") and shutil.which("chromedriver"))


@contextmanager
def chromium(width: int = 1280, height: int = 900) -> Iterator[WebDriver]:
    """Start a browser with a window of this size, and end it afterwards."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    given = webdriver.ChromeOptions()
    given.binary_location = shutil.which("chromium") or ""
    for argument in ("--headless=new", "--disable-dev-shm-usage", "--hide-scrollbars"):
        given.add_argument(argument)
    if os.geteuid() == 0:
        given.add_argument("--no-sandbox")
    browser = webdriver.Chrome(options=given, service=Service(shutil.which("chromedriver")))
    try:
        browser.set_script_timeout(LIMIT_S)
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        yield browser
    finally:
        browser.quit()


def opened(browser: WebDriver, file: Path) -> float:
    """Open a page of `rcx view`, and return the time until it is shown [ms]."""
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(file.as_uri())
    ready = "return document.documentElement.dataset.ready"
    waiting = WebDriverWait(browser, LIMIT_S, poll_frequency=0.05)
    return float(waiting.until(lambda one: one.execute_script(ready)))
