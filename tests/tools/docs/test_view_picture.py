"""docs/how-to/view.png shows the page of `rcx view` as the present sources generate it."""

from __future__ import annotations

from rcx_tools.docs.view_picture import PICTURE, digest, digest_in, page


def test_the_picture_shows_the_present_page() -> None:
    """The picture was generated from the present sources.

    If this test fails, run `python -m rcx_tools.docs.view_picture`, which needs chromium.
    """
    html = page()
    assert digest_in(PICTURE.read_bytes()) == digest(html)
    assert digest(html.replace("Theme", "theme", 1)) != digest(html)
    assert digest_in(PICTURE.read_bytes()[:33]) == ""
