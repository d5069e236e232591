"""Pages opened in Chromium: what is wrong with one is found, and what is right is left alone; without Chromium that is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.site import browser

WRONG = (
    '<!doctype html><html><head></head><body><button onclick="missing()">press</button><input type="range" oninput="console.error(\'slid\')">'
    '<img src="nope.png"><label style="display:block;width:20px;overflow:hidden;white-space:nowrap">a long label</label></body></html>'
)


def test_without_a_browser_that_is_said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(browser, "browser", lambda: None)
    assert browser.main(["."]) == 0 and "no Chromium here" in capsys.readouterr().out


@pytest.mark.skipif(browser.browser() is None, reason="Chromium is not installed")
def test_what_is_wrong_with_a_page_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(WRONG)
    found = browser.faults(page, str(browser.browser()))
    assert [any(word in fault for fault in found) for word in ("missing is not defined", "slid", "no picture", "cut off: a long label")] == [True] * 4
    page.write_text("<!doctype html><html><head></head><body><button onclick='document.title = 1'>press</button></body></html>")
    assert browser.faults(page, str(browser.browser())) == [] and [file.name for file in tmp_path.iterdir()] == ["page.html"]


def test_a_copy_that_a_killed_run_left_behind_is_no_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    opened: list[str] = []
    monkeypatch.setattr(browser, "browser", lambda: "chromium")
    monkeypatch.setattr(browser, "faults", lambda page, _: opened.append(page.name) or [])
    for name in ("page.html", ".page.opened.html"):
        (tmp_path / name).write_text("<html></html>")
    assert browser.main([str(tmp_path)]) == 0 and opened == ["page.html"]
