"""Limits of a target: what does not fit is refused by name; a target's Jacobian works in one row of states."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from phichain.emit.cost import cost_of
from phichain.errors import UnsupportedError
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.pipeline import generate
from phichain.proof import prove
from phichain.scene import Scene


def chain(**more: Any) -> Scene:
    keys = {"mass": 0.25, "length": 0.25, "com": 0.125, "actuated": "all", "real": "float", "trig": "bundled", "code": "loops"}
    return Scene("small", 4, **{"want": ["forward_dynamics", "state_jacobian"], **keys, **more})


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ({"stack_max": 512}, r"^target\.stack_max: is less than state_jacobian may take on a Cortex-M4F, \d+ bytes \(got 512\); raise it, or"),
        ({"flash_max": 2048}, r"^target\.flash_max: is less than the functions may take on a Cortex-M4F, \d+ bytes, of which state_jacobian \d+"),
    ],
)
def test_what_exceeds_a_limit_is_refused_by_name(limit: dict[str, int], message: str, tmp_path: Path) -> None:
    with pytest.raises(UnsupportedError, match=message) as caught:
        generate(chain(**limit), tmp_path, prove=False)
    assert caught.value.function == "state_jacobian" and not list(tmp_path.iterdir())


def test_what_fits_is_written_and_stated(tmp_path: Path) -> None:
    folder = generate(chain(want=["forward_dynamics"], stack_max=1024, flash_max=4096), tmp_path, prove=False)
    stated = json.loads((folder / "manifest.json").read_text())["functions"]["forward_dynamics"]["cortex_m4f_at_most"]
    assert 0 < stated["stack"] <= 1024 and 0 < stated["flash_Os"] < stated["flash_O2"]
    assert f"flash {stated['flash_Os']} bytes, stack {stated['stack']} bytes at most." in (folder / "small.h").read_text()


def test_a_target_holds_one_row_of_states_where_a_host_holds_one_a_link() -> None:
    """Proven like any other, in less memory: 2300 bytes where 4400 were taken at ten links."""
    host, target = (
        lower(derive(chain(trig=trig, want=["state_jacobian"]))).wanted["state_jacobian"] for trig in (None, "bundled")
    )
    assert sum(array.size for array in target.work) < 0.8 * sum(array.size for array in host.work)
    assert cost_of(target, "float").stack < cost_of(host, "float").stack
    assert prove(chain(want=["state_jacobian"])).record["state_jacobian"].startswith("modulo 2^61 - 1")
