"""Build the site, strictly: `python -m docs.site [--out DIR] [--no-blocks]`."""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from docs.site import blocks, gallery, links, stage, theory

ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    """Stage, run the blocks, build; the number of things that are wrong."""
    parser = argparse.ArgumentParser(prog="python -m docs.site", description="Build the documentation, every warning an error.")
    parser.add_argument("--out", type=Path, default=ROOT / "generated" / "site", help="folder of the pages")
    parser.add_argument("--no-blocks", action="store_true", help="leave code blocks, notebooks and the gallery's scripts unrun")
    words = parser.parse_args()
    faults = [*links.faults(ROOT), *stage.dead(ROOT), *theory.faults(ROOT), *([] if words.no_blocks else blocks.faults(ROOT))]
    for fault in faults:
        print(fault, file=sys.stderr)
    source = ROOT / "build" / "site"
    shutil.rmtree(source, ignore_errors=True)
    stage.stage(ROOT, source)
    faults += _built(source, words.out, not words.no_blocks)
    print(f"site: {words.out / 'index.html'}" if not faults else f"site: {len(faults)} fault(s)")
    if not faults:
        for name, count in _told(words.out, not words.no_blocks).items():
            print(f"  {name + ':':24} {count}")
    return min(len(faults), 100)


def _built(source: Path, out: Path, run: bool) -> list[str]:
    """Build with Sphinx; its complaint, if it has one."""
    from sphinx.cmd.build import build_main

    given = [] if run else ["-D", "nb_execution_mode=off", "-D", "plot_gallery=False"]
    code = build_main(["-b", "html", "-W", "--keep-going", "-q", *given, "-d", str(source / ".doctrees"), "-c", str(ROOT / "docs" / "site"), str(source), str(out)])
    return [] if code == 0 else [f"sphinx: ended with {code}"]


def _told(out: Path, run: bool) -> dict[str, str]:
    """What a site without faults is made of."""
    found = list(blocks.blocks(ROOT))
    python = sum(block.language == "python" for block in found)
    scripts = {path.stem for path in (ROOT / "examples").glob("*.py")}
    within = sum(len(list(stage.linked(page.read_text(), page.parent))) for page in stage.pages(ROOT))
    notebooks = len(list((ROOT / "docs" / "notebooks").glob("*.md")))
    return {
        "pages": str(len(list(out.rglob("*.html")))),
        "code blocks": f"{len(found)}, {python} of them Python" + (", all run or checked" if run else ", none run"),
        "notebooks": f"{notebooks}" + (", every cell run" if run else ", none run"),
        "scripts of the gallery": f"{len(scripts)}, {len(scripts - set(gallery.LONG)) if run else 0} of them run",
        "links": f"{within} within, {len(links.KNOWN)} outside, none dead",
    }


if __name__ == "__main__":
    sys.exit(main())
