"""Markdown tables with what it takes to read and to repeat them: date, versions, machine, command."""

from __future__ import annotations

import datetime
import platform
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path

from benchmarks import threads_told

RESULTS = Path(__file__).with_name("results")
_PACKAGES = (
    "phichain", "sympy", "casadi", "heyoka", "pin", "mujoco", "numpy", "scipy", "pycaputo", "differint", "jax", "diffrax",
    "pyharm-os",
)  # fmt: skip


@dataclass(frozen=True)
class Table:
    """One table.

    Attributes:
        title: its heading.
        columns: headings of the columns.
        rows: cells, already formatted.
        notes: paragraphs below the table.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = field(default=())

    def markdown(self) -> str:
        lines = [
            f"## {self.title}",
            "",
            _row(self.columns),
            _row(["---"] + ["---:"] * (len(self.columns) - 1)),
        ]
        lines += [_row(row) for row in self.rows]
        for note in self.notes:
            lines += ["", note]
        return "\n".join(lines) + "\n"


def write(
    name: str, heading: str, tables: Sequence[Table], command: str, folder: Path | None = None, seconds: float | None = None
) -> Path:
    """Writes ``folder/name.md``: the heading, the circumstances (and how long it took), the tables."""
    folder = folder or RESULTS
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.md"
    took = "" if seconds is None else f" in {seconds:.0f} s"
    head = [
        f"# {heading}",
        "",
        f"Measured {datetime.date.today().isoformat()} by `{command}`{took}.",
        "",
        circumstances(),
        "",
    ]
    path.write_text("\n".join(head) + "\n" + "\n".join(t.markdown() for t in tables))
    return path


def circumstances() -> str:
    """Versions and machine, one paragraph."""
    compiler = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=False).stdout
    versions = [f"{name} {version(name)}" for name in _PACKAGES]
    python = f"Python {platform.python_version()}"
    return f"{_processor()}; {compiler.splitlines()[0] if compiler else 'no cc'}; {python}; {', '.join(versions)}; {threads_told()}."


def version(name: str) -> str:
    """Of a package, or that it is absent."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "(from its checkout)" if name == "phichain" else "(absent)"


def _processor() -> str:
    """Model of the processor, or its architecture where it has no name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{len(names)} x {names[0]}" if names else platform.machine()


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
