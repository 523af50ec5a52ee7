"""Generator of docs/how-to/view.png: the robot and the chart of a run of example 04.

`python -m rcx_tools.docs.view_picture` draws the picture again in Chromium. The picture contains a
digest of the page. A test can therefore check without a browser that the picture is current.
"""

from __future__ import annotations

import base64
import hashlib
import re
import struct
import sys
import tempfile
import zlib
from pathlib import Path

from rcx_harness import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace.view.page import View
from rcx_tools.chromium import MISSING, chromium, is_there, opened
from structured_text.errors import InputError

__all__ = ["PICTURE", "digest", "digest_in", "main", "page"]

_ROOT = Path(__file__).resolve().parents[3]
_EXAMPLE = _ROOT / "plc/examples/04_pick_and_place"
PICTURE = _ROOT / "docs/how-to/view.png"
_SIZE = (1280, 900)
_KEY = b"Page"
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: Script that selects a section of the run and sets the cursor: the arm is between feeder and tray.
_SHOWN = """
document.dispatchEvent(new KeyboardEvent("keydown", { key: "0" }));
const plot = document.getElementById("plot");
const box = plot.getBoundingClientRect();
const at = { clientX: box.left + box.width * arguments[0], clientY: box.top + 40, pointerId: 1 };
plot.setPointerCapture = () => {};
for (const kind of ["pointerdown", "pointerup"]) {
  plot.dispatchEvent(new PointerEvent(kind, { ...at, altKey: true, bubbles: true }));
}
const done = arguments[1];
requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done)));
"""
_AT = 0.68


def page() -> str:
    """Return the page for the picture as HTML."""
    given = {"engine": "builtin", "watch": "Main.Carry.Stage,Main.Cycle.Count", "positions": "mm"}
    with Cell.build(_EXAMPLE, robot=_ROOT / "docs/how-to/view.toml", scan="10ms", **given) as cell:  # type: ignore[arg-type]
        Stimulus.load(_EXAMPLE / "stimulus.toml").schedule(cell)
        view = View(cell.trace.header)
        cell.trace.listen(view.take)
        cell.run("3500ms")
    return view.page("04_pick_and_place")


def digest(html: str) -> str:
    """Return a digest of a page that does not depend on the compression of its data."""
    head, data, tail = re.split(
        r'(?<=<script id="data" type="text/plain">)(.*?)(?=</script>)', html
    )
    plain = zlib.decompress(base64.b64decode(data))
    return hashlib.sha256(head.encode() + plain + tail.encode()).hexdigest()


def digest_in(picture: bytes) -> str:
    """Return the digest in a picture. If there is none, return an empty text."""
    at = len(_SIGNATURE)
    while at < len(picture):
        (length,) = struct.unpack_from(">I", picture, at)
        kind, data = picture[at + 4 : at + 8], picture[at + 8 : at + 8 + length]
        if kind == b"tEXt" and data.startswith(_KEY + b"\0"):
            return data[len(_KEY) + 1 :].decode()
        at += length + 12
    return ""


def _signed(picture: bytes, text: str) -> bytes:
    """Return a picture with a text chunk after the header."""
    head = len(_SIGNATURE) + 25
    body = b"tEXt" + _KEY + b"\0" + text.encode()
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    return picture[:head] + chunk + picture[head:]


def _drawn(html: str) -> bytes:
    with tempfile.TemporaryDirectory(prefix="rcx-") as folder, chromium(*_SIZE) as browser:
        file = Path(folder) / "view.html"
        file.write_text(html, encoding="utf-8")
        opened(browser, file)
        browser.execute_async_script(_SHOWN, _AT)
        shot = browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
    return base64.b64decode(shot["data"])


def main() -> None:
    """Draw the picture again if its page has changed."""
    html = page()
    if PICTURE.exists() and digest_in(PICTURE.read_bytes()) == digest(html):
        return
    if not is_there():
        raise InputError(f"docs/how-to/view.png is not current, and {MISSING}")
    PICTURE.write_bytes(_signed(_drawn(html), digest(html)))
    print("wrote docs/how-to/view.png")


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"rcx: {error}")
