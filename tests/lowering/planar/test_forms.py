"""Loops and straight-line code are the same function, for every function of every kind of scene."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.ir import evaluate, evaluate_exactly, prune, unroll
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.chains import functions, gap, kinds, label, random_arguments, scene

SMALL = [
    scene(links, space, base, masses)
    for links, masses in ((1, "tip"), (1, "mid"), (2, "mid"))
    for space in ("planar", "spatial")
    for base in ("fixed", "cart")
]
LARGE = [scene(3, "planar", "cart", "mid", "damped", actuated="all"), scene(3, "spatial", "cart", "mid", "damped")]


DIFFERENCES = ("q_error", "v_error", "residual")
"""What a step says about itself: small differences, good to the rounding of the state they are taken of."""


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds(), *SMALL], ids=label)
def test_loops_and_straight_line_code_agree(chain: Scene) -> None:
    for name in functions(chain):
        if name == "state_jacobian" and not chain.is_planar and chain.links > 2 and not chain.tip_masses:
            continue  # its straight-line form is large: `test_a_large_jacobian_agrees`
        _check(chain, name)


def test_a_large_jacobian_agrees() -> None:
    _check(LARGE[1], "state_jacobian")


def _check(chain: Scene, name: str) -> None:
    loops, flat = lower_function(derive(chain), name, "loops"), lower_function(derive(chain), name, "unrolled")
    assert flat.is_straight_line
    assert [a.name for a in loops.outputs] == [a.name for a in flat.outputs]
    arguments = random_arguments(chain, loops)
    by_loops, by_flat = evaluate(loops, arguments), evaluate(flat, arguments)
    for output, expected in by_flat.items():
        assert np.all(np.isfinite(expected))
        if output in DIFFERENCES:
            scale = max(1.0, *(np.max(np.abs(by_flat[state])) for state in ("q_next", "v_next")))
            assert np.max(np.abs(by_loops[output] - expected)) < 1e-13 * scale, (name, output)
        else:
            assert gap(by_loops[output], expected) < 1e-13, (name, output)


@pytest.mark.parametrize("chain", LARGE, ids=label)
def test_unrolling_is_exact(chain: Scene) -> None:
    """In 50 digits the two forms differ in the last one, so they are the same formulas."""
    loops = lower_function(derive(chain), "forward_dynamics", "loops")
    arguments = {k: v.ravel().tolist() for k, v in random_arguments(chain, loops).items()}
    found, expected = (evaluate_exactly(p, arguments)["a"] for p in (loops, unroll(loops)))
    assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < 1e-45


@pytest.mark.parametrize("chain", LARGE, ids=label)
def test_nothing_is_left_to_prune(chain: Scene) -> None:
    for code in ("loops", "unrolled"):
        program = lower_function(derive(chain), "forward_dynamics", code)
        assert prune(program) == program


@pytest.mark.parametrize("chain", LARGE, ids=label)
def test_a_batch_is_its_rows(chain: Scene) -> None:
    program = lower_function(derive(chain), "forward_dynamics", "loops")
    rows = [random_arguments(chain, program, seed) for seed in range(3)]
    batch = evaluate(program, {name: np.stack([row[name] for row in rows]) for name in rows[0]})["a"]
    assert batch.shape == (3, chain.nv)
    for row, found in zip(rows, batch, strict=True):
        assert np.array_equal(found, evaluate(program, row)["a"])


def test_lowering_is_the_same_every_time() -> None:
    for chain in LARGE:
        assert lower_function(derive(chain), "forward_dynamics") == lower_function(derive(chain), "forward_dynamics")
