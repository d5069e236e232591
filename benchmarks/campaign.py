"""A whole run of tables that can be interrupted: what is done is not done again, and how long each table took is kept."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.table import RESULTS, Table, write

ROOT = Path(__file__).resolve().parents[1]
STATE = ROOT / "generated" / "bench.json"
_SOURCES = ("codegen", "templates", "stencils", "scenes", "benchmarks")
_KINDS = {".py", ".c", ".h", ".cpp", ".hpp", ".j2", ".toml"}


@dataclass(frozen=True)
class Campaign:
    """An unfinished run.

    Attributes:
        source: Digest of everything that is measured.
        seconds: Of the tables that are done.
    """

    source: str
    seconds: dict[str, float]


def begun(fresh: bool, state: Path = STATE) -> Campaign:
    """The unfinished run, if it was of this very code; otherwise a new one."""
    now = digest()
    if not fresh and state.exists():
        stored = json.loads(state.read_text())
        if stored.get("source") == now:
            return Campaign(now, dict(stored["seconds"]))
        print("the code has changed since the unfinished run: starting anew", flush=True)
    return Campaign(now, {})


def kept(campaign: Campaign, name: str, seconds: float, state: Path = STATE) -> Campaign:
    """The run with one more table done, on file."""
    after = Campaign(campaign.source, {**campaign.seconds, name: seconds})
    state.parent.mkdir(parents=True, exist_ok=True)
    unfinished = state.with_suffix(".part")
    unfinished.write_text(json.dumps({"source": after.source, "seconds": after.seconds}, indent=1) + "\n")
    unfinished.replace(state)
    return after


def ended(campaign: Campaign, order: Iterable[str], state: Path = STATE, folder: Path = RESULTS) -> Path:
    """Forget the state and write down how long each table took."""
    rows = [(f"[{name}]({name}.md)", f"{campaign.seconds[name]:.0f}") for name in order if name in campaign.seconds]
    rows.append(("all", f"{sum(campaign.seconds.values()):.0f}"))
    state.unlink(missing_ok=True)
    table = Table("Seconds for each table", ("table", "s"), tuple(rows))
    return write("durations", "How long make bench takes", [table], "make bench", folder)


def digest() -> str:
    """Of every source file that the measured code is made from, and of the benchmarks themselves."""
    found = hashlib.sha256()
    for top in _SOURCES:
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in _KINDS and path.is_file():
                found.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def clock() -> float:
    """Elapsed seconds."""
    return time.perf_counter()
