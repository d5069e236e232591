"""Every function of every kind of scene against the dense, un-lowered mechanics in 50 digits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain.contract.functions import ROWS
from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.reference import reference, tangent_directions
from phichain.scene import Scene
from tests.lowering.chains import Arguments, functions, gap, kinds, label, random_arguments, scene
from tests.reference_cases import flat, relative_error

#: What the spatial reference defines otherwise: `test_spatial_jacobian`, `test_spatial_step`, tests/lowering/jacobians/test_step_jacobian.py.
SPATIAL_APART = ("state_jacobian", "dynamics_and_jacobian", "step", "step_jacobian")
ENDS = [scene(n, space, base, "mid") for n in (1, 2) for space in ("planar", "spatial") for base in ("fixed", "cart")]
SPATIAL = [chain for chain in kinds() if not chain.is_planar]


def truth(chain: Scene, name: str, arguments: Arguments) -> dict[str, Any]:
    """The reference's outputs by the Program's names."""
    inputs = {k: v.ravel().tolist() if v.ndim else float(v) for k, v in arguments.items() if k not in chain.runtime}
    params = {k: v.tolist() for k, v in arguments.items() if k in chain.runtime}
    outputs = reference(chain, name, inputs, digits=30, params=params)
    if not chain.nu:
        outputs = {name: value for name, value in outputs.items() if name not in ("B", "dadu")}
    ours = {theirs: mine for mine, theirs in ROWS[name].outputs_in_reference(chain).items()}
    return {ours.get(found, found): value for found, value in outputs.items()}


def error(found: np.ndarray, expected: Any) -> float:
    """Largest difference over the largest entry; what is zero in the reference has to be zero to rounding."""
    scale = max((abs(entry) for entry in flat(expected)), default=mp.one)
    return float(np.max(np.abs(found))) if scale < 1e-60 else relative_error(found.tolist(), expected)


def agree(chain: Scene, names: Iterable[str], of_state: float = 1e-14) -> None:
    """Assert that functions of a chain, at one drawn state, are the reference's; what is told apart in space is left to its own tests.

    `of_state` is how far a step's own estimate may be off, in parts of the state that it is formed from.
    """
    for name in names:
        if not chain.is_planar and name in SPATIAL_APART:
            continue
        program = lower_function(derive(chain), name, "loops")
        arguments = random_arguments(chain, program, seed=1)
        found, expected = evaluate(program, arguments), truth(chain, name, arguments)
        assert set(found) == set(expected), name
        for output in found:
            if output.endswith("_error"):  # an estimate far below the state it belongs to, from which it is formed
                apart = np.abs(found[output] - _floats(expected[output]))
                assert np.max(apart) < of_state * np.max(np.abs(found["v_next"])), (name, output)
                continue
            assert error(found[output], expected[output]) < 1e-12, (name, output)


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds(), *ENDS], ids=label)
def test_every_function(chain: Scene) -> None:
    agree(chain, functions(chain))


@pytest.mark.long
@pytest.mark.parametrize("chain", SPATIAL, ids=label)
def test_spatial_jacobian(chain: Scene) -> None:
    """Along the manifold of unit directions and tangent rates, where alone it is a matter of mechanics."""
    program = lower_function(derive(chain), "state_jacobian", "loops")
    arguments = random_arguments(chain, program, seed=1)
    found, expected = evaluate(program, arguments), truth(chain, "state_jacobian", arguments)
    directions = tangent_directions(chain, arguments["q"], arguments["v"], digits=30)
    along = [found["dadq"] @ _floats(dq) + found["dadv"] @ _floats(dv) for dq, dv in directions]
    assert gap(along, [_floats(row) for row in expected["tangent"]]) < 1e-12
    if chain.nu:
        assert error(found["dadu"], expected["dadu"]) < 1e-12


@pytest.mark.parametrize("chain", SPATIAL[::3], ids=label)
def test_spatial_step(chain: Scene) -> None:
    """Stages leave the manifold by O(h^2), where the reference sees the nearest point of it: O(h^5) remains."""
    program = lower_function(derive(chain), "step", "loops")
    arguments = random_arguments(chain, program, seed=1)
    gaps = []
    for h in (2e-3, 5e-4):
        arguments["h"] = np.array(h)
        found, expected = evaluate(program, arguments), truth(chain, "step", arguments)
        gaps.append(max(error(found[name], expected[name]) for name in ("q_next", "v_next")))
    assert gaps[1] < gaps[0] / 4**4.5 + 1e-13


@pytest.mark.parametrize("chain", [scene(2, "planar", "cart", "mid"), scene(2, "spatial", "fixed", "mid")], ids=label)
def test_step_is_of_order_four(chain: Scene) -> None:
    """Halving the step takes one thirty-second of the local error."""
    program = lower_function(derive(chain), "step", "loops")
    start = random_arguments(chain, program, seed=2)

    def after(h: float, steps: int) -> np.ndarray:
        state = dict(start)
        for _ in range(steps):
            end = evaluate(program, state | {"h": np.array(h)})
            state |= {"q": end["q_next"], "v": end["v_next"]}
        return np.concatenate([state["q"], state["v"]])

    errors = [np.max(np.abs(after(h, 1) - after(h / 16, 16))) for h in (0.004, 0.002)]
    assert 4.7 < np.log2(errors[0] / errors[1]) < 5.3


def _floats(values: Any) -> np.ndarray:
    return np.array([float(mp.mpf(value)) for value in values])
