"""Build the site, strictly: `python -m docs.site [--out DIR] [--no-blocks]`."""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from docs.site import blocks, links, stage

ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    """Stage, run the blocks, build; the number of things that are wrong."""
    parser = argparse.ArgumentParser(prog="python -m docs.site", description="Build the documentation, every warning an error.")
    parser.add_argument("--out", type=Path, default=ROOT / "generated" / "site", help="folder of the pages")
    parser.add_argument("--no-blocks", action="store_true", help="leave the code blocks of the pages unrun")
    words = parser.parse_args()
    faults = [*links.faults(ROOT), *([] if words.no_blocks else blocks.faults(ROOT))]
    for fault in faults:
        print(fault, file=sys.stderr)
    source = ROOT / "build" / "site"
    shutil.rmtree(source, ignore_errors=True)
    stage.stage(ROOT, source)
    faults += _built(source, words.out)
    print(f"site: {words.out / 'index.html'}" if not faults else f"site: {len(faults)} fault(s)")
    return min(len(faults), 100)


def _built(source: Path, out: Path) -> list[str]:
    """Build with Sphinx; its complaint, if it has one."""
    from sphinx.cmd.build import build_main

    code = build_main(["-b", "html", "-W", "--keep-going", "-q", "-d", str(source / ".doctrees"), "-c", str(ROOT / "docs" / "site"), str(source), str(out)])
    return [] if code == 0 else [f"sphinx: ended with {code}"]


if __name__ == "__main__":
    sys.exit(main())
