"""Pages in a real browser: `python -m docs.site.browser FILE-OR-FOLDER...` opens each in headless Chromium and uses its controls.

A copy of the page gets a script that notes errors, presses every button, moves every slider, and looks for pictures that did not load and
labels that are cut off; what it finds is read back from the page.
"""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome")
_SECONDS = 60
_NOTES = """<script>
const found = [];
addEventListener('error', e => found.push(e.message || 'did not load: ' + (e.target.src || e.target.href)), true);
addEventListener('unhandledrejection', e => found.push(String(e.reason)));
const complain = console.error;
console.error = (...words) => { found.push(words.join(' ')); complain(...words); };
</script>"""
_USES = """<script>
addEventListener('load', () => setTimeout(() => {
  for (const slider of document.querySelectorAll('input[type=range]'))
    for (const value of [slider.max, slider.min, (Number(slider.min) + Number(slider.max)) / 2]) {
      slider.value = value;
      for (const kind of ['input', 'change']) slider.dispatchEvent(new Event(kind, { bubbles: true }));
    }
  for (const choice of document.querySelectorAll('select'))
    for (const option of choice.options) { choice.value = option.value; choice.dispatchEvent(new Event('change', { bubbles: true })); }
  for (const box of document.querySelectorAll('input[type=checkbox], input[type=radio]')) box.click();
  for (const button of document.querySelectorAll('button')) button.click();
  for (const picture of document.images) if (picture.complete && !picture.naturalWidth && picture.src) found.push('no picture: ' + picture.src);
  for (const label of document.querySelectorAll('label, button, h1, h2, h3, figcaption, th'))
    if (getComputedStyle(label).overflowX === 'hidden' && label.clientWidth > 1 && label.scrollWidth > label.clientWidth + 1)
      found.push('cut off: ' + label.textContent.trim().slice(0, 60));
  document.documentElement.dataset.found = JSON.stringify(found);
}, 300));
</script>"""


def browser() -> str | None:
    """The browser of this machine, if it has one."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


def faults(page: Path, command: str) -> list[str]:
    """What is wrong with a page when it is opened and used."""
    text = page.read_text(encoding="utf-8")
    head = re.search(r"<head[^>]*>", text)
    place = head.end() if head else 0
    copy = page.with_name(f".{page.stem}.opened.html")
    rest, body, end = text[place:].rpartition("</body>")
    copy.write_text(text[:place] + _NOTES + (rest + _USES + body + end if body else end + _USES), encoding="utf-8")
    try:
        with tempfile.TemporaryDirectory() as profile:
            words = [
                command, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,1600", f"--user-data-dir={profile}",
                "--virtual-time-budget=5000", "--allow-file-access-from-files", "--dump-dom", copy.resolve().as_uri(),
            ]  # fmt: skip
            done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=_SECONDS)
    except subprocess.TimeoutExpired:
        return [f"did not come up within {_SECONDS} s"]
    finally:
        copy.unlink(missing_ok=True)
    noted = re.search(r'data-found="([^"]*)"', done.stdout)
    return json.loads(html.unescape(noted[1])) if noted else ["its script did not run to its end"]


def main(words: list[str]) -> int:
    """Open pages, and every page in folders; the number of those with faults."""
    command = browser()
    if command is None:
        print("no Chromium here (Debian: apt install chromium): the pages are not opened")
        return 0
    # A run that was killed leaves its copy of a page behind, whose name begins with a point.
    pages = [page for word in words for page in ([Path(word)] if Path(word).is_file() else sorted(Path(word).rglob("[!.]*.html")))]
    wrong = 0
    for page in pages:
        found = faults(page, command)
        wrong += bool(found)
        for fault in found:
            print(f"{page}: {fault}", file=sys.stderr)
    print(f"{len(pages)} page(s) opened in {Path(command).name}, {wrong} with faults")
    return min(wrong, 100)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
