"""Draw: `python -m docs.figures [--out DIR] [--png]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from docs.figures.table import FOLDER, write


def main() -> None:
    """Write every figure of docs/theory.md."""
    parser = argparse.ArgumentParser(prog="python -m docs.figures", description="Draw the figures of docs/theory.md.")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder of the figures")
    parser.add_argument("--png", action="store_true", help="as PNG, to look at")
    words = parser.parse_args()
    paths = write(words.out, "png" if words.png else "svg")
    print(f"{len(paths)} figures in {words.out}")


if __name__ == "__main__":
    main()
