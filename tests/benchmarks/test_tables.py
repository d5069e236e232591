"""Every table of make bench runs with tiny counts and without a single peer, and says by name what it skipped."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

from benchmarks.__main__ import MODULES
from benchmarks.orbits import auto
from benchmarks.plan import TINY
from benchmarks.table import Table

SLOW = {"papers": ("torque_table", "energy_table"), "fractional": ("power_table",)}
"""Tables of a file that have no peer to miss, or miss it as another one does."""
WITHOUT_PEERS = {"single_precision", "leaving_out", "horizon", "fit"}
"""Tables that compare ours with ours."""
FEWER = {
    "forward_dynamics": ("KINDS", ("P, torques", "S, masses at 0.6 l")),
    "batch": ("CHAINS", ("P",)),
    "generation": ("SIZES", ("spatial",)),
}
"""Tables of which a part will do here: what is cut, and what is left of it."""


@pytest.mark.long
@pytest.mark.parametrize("name", MODULES)
def test_a_table_runs_without_its_peers(name: str, no_peers: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    module = import_module(MODULES[name])
    if name in FEWER:
        what, left = FEWER[name]
        monkeypatch.setattr(module, what, {key: getattr(module, what)[key] for key in left})
    for slow in SLOW.get(name, ()):
        monkeypatch.setattr(module, slow, lambda *_: Table("left out here", ("a", "b"), (("-", "-"),)))
    if name == "families":
        monkeypatch.setattr(auto, "HOME", tmp_path)
    if name == "leaving_out":
        monkeypatch.setattr(module, "SCENES", {"planar4_forward_only": ("planar4_forward_only",)})
    tables = module.tables(TINY)
    text = "\n".join(table.markdown() for table in tables)
    assert all(isinstance(table, Table) and table.rows for table in tables)
    assert "phichain" in text or name in WITHOUT_PEERS
    assert module.HEADING
    if name not in WITHOUT_PEERS:
        assert "skipped: " in text and re.search("is not installed: (pip|apt) install", text)


@pytest.mark.parametrize("name", MODULES)
def test_every_row_is_as_wide_as_its_heads(name: str) -> None:
    """Headings and cells of the committed tables agree, so that they can be read by machine."""
    from benchmarks.table import RESULTS

    path = RESULTS / f"{name}.md"
    assert path.exists(), f"run make bench-{name.replace('_', '-')}"
    widths = [line.count(" | ") for line in path.read_text().splitlines() if line.startswith("| ")]
    assert widths and min(widths) > 0

