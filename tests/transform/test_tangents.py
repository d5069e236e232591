"""Exact Jacobians of lowered functions, in both forms of the tangent pass, against complex step and 60-digit differences."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

from phichain.ir import Program, evaluate, evaluate_exactly, unroll
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from phichain.transform import Block, jacobian, sparsity
from tests.lowering.chains import Arguments, gap, kinds, label, random_arguments, scene

DRIVEN = scene(3, "planar", "cart", "runtime", "damped", actuated="all")
RUNTIME = [
    scene(2, space, base, masses, gravity="runtime", **({"cart_mass": "runtime"} if base == "cart" else {}))
    for space in ("planar", "spatial")
    for base, masses in (("fixed", "runtime"), ("cart", "runtime_tip"))
]


def complex_step(program: Program, arguments: Arguments, output: str, argument: str) -> np.ndarray:
    """d output / d argument, exact to rounding for analytic functions."""
    columns = []
    for i in range(arguments[argument].size):
        moved = arguments[argument].astype(complex)
        moved.flat[i] += 1e-30j
        columns.append(evaluate(program, arguments | {argument: moved})[output].imag.ravel() / 1e-30)
    return np.array(columns).T


def differences(program: Program, arguments: Arguments, output: str, argument: str) -> np.ndarray:
    """d output / d argument by central differences in 60 digits."""
    columns = []
    with mp.workdps(60):
        width = mp.mpf(10) ** -20
        flat = {name: list(map(mp.mpf, value.ravel().tolist())) for name, value in arguments.items()}
        for i in range(len(flat[argument])):
            ends = []
            for sign in (1, -1):
                moved = list(flat[argument])
                moved[i] += sign * width
                ends.append(evaluate_exactly(program, flat | {argument: moved}, digits=60)[output])
            columns.append([float((a - b) / (2 * width)) for a, b in zip(*ends, strict=True)])
    return np.array(columns).T


@pytest.mark.long
@pytest.mark.parametrize("chain", list(kinds()), ids=label)
def test_state_jacobian_is_the_complex_step(chain: Scene) -> None:
    forward = lower_function(derive(chain), "forward_dynamics", "loops")
    program = lower_function(derive(chain), "state_jacobian", "loops")
    arguments = random_arguments(chain, program, seed=3)
    found = evaluate(program, arguments)
    assert set(found) == {f"dad{array.name}" for array in forward.inputs}
    for array in forward.inputs:
        expected = complex_step(forward, arguments, "a", array.name)
        assert gap(found[f"dad{array.name}"], expected) < 2e-13, array.name


@pytest.mark.parametrize("form", ["loops", "unrolled"])
@pytest.mark.parametrize("chain", RUNTIME, ids=label)
def test_parameters_too(chain: Scene, form: str) -> None:
    """Derivatives with respect to masses, lengths, centres of mass, the cart's mass and gravity."""
    forward = lower_function(derive(chain), "forward_dynamics", "loops")
    shaped = forward if form == "loops" else unroll(forward)
    names = [array.name for array in forward.params]
    program = jacobian(shaped, "sensitivity", "", [Block("a", name, f"dad{name}") for name in names], keep_outputs=True)
    assert program.is_straight_line == (form == "unrolled")
    arguments = random_arguments(chain, program, seed=4)
    found = evaluate(program, arguments)
    assert gap(found["a"], evaluate(forward, arguments)["a"]) < 1e-14
    for name in names:
        assert gap(found[f"dad{name}"], differences(forward, arguments, "a", name)) < 1e-12, name


def test_phi_jacobian_by_differences() -> None:
    """Bessel functions have no complex step in NumPy's real routines' digits; differences in 60 digits have all."""
    chain = scene(3, "planar", "cart", "mid", "sprung")
    phi, program = (lower_function(derive(chain), name, "loops") for name in ("phi", "phi_jacobian"))
    arguments = random_arguments(chain, program, seed=5)
    found = evaluate(program, arguments)["out"]
    assert found.shape == (4, 5)
    assert gap(found[:, :4], differences(phi, arguments, "out", "amplitude")) < 1e-13
    assert gap(found[:, 4:], differences(phi, arguments, "out", "omega")) < 1e-13


@pytest.mark.parametrize("name", ["energy", "positions", "coriolis", "inverse_dynamics", "step"])
def test_any_function_can_be_differentiated(name: str) -> None:
    function = unroll(lower_function(derive(DRIVEN), name, "loops"))
    blocks = [Block(out.name, "q", f"d_{out.name}") for out in function.outputs]
    program = jacobian(function, "slope", "", blocks)
    arguments = random_arguments(DRIVEN, program, seed=6)
    found = evaluate(program, arguments)
    for out in function.outputs:
        assert gap(found[f"d_{out.name}"], complex_step(function, arguments, out.name, "q")) < 1e-12


def test_second_derivatives() -> None:
    """The tangent pass applies to its own results."""
    chain = scene(2, "planar", "fixed", "mid")
    first = lower_function(derive(chain), "state_jacobian", "unrolled")
    second = jacobian(first, "curvature", "", [Block("dadq", "q", "curvature")])
    arguments = random_arguments(chain, second, seed=7)
    expected = complex_step(first, arguments, "dadq", "q")
    assert gap(evaluate(second, arguments)["curvature"], expected) < 1e-12
    curvature = expected.reshape(2, 2, 2)
    assert gap(curvature, np.swapaxes(curvature, 1, 2)) < 1e-11


def test_blocks_side_by_side() -> None:
    forward = lower_function(derive(DRIVEN), "forward_dynamics", "unrolled")
    width = DRIVEN.nq + DRIVEN.nv
    blocks = [Block("a", "q", "dadx", 0, width), Block("a", "v", "dadx", DRIVEN.nq, width)]
    program = jacobian(forward, "state", "", blocks)
    apart = jacobian(forward, "apart", "", [Block("a", "q", "dadq"), Block("a", "v", "dadv")])
    arguments = random_arguments(DRIVEN, program, seed=8)
    found, expected = evaluate(program, arguments)["dadx"], evaluate(apart, arguments)
    assert np.array_equal(found, np.hstack([expected["dadq"], expected["dadv"]]))


def test_sparsity_is_what_is_not_zero() -> None:
    """Gravity's torque on a link depends on its own absolute angle alone; nothing depends on where the cart is."""
    chain = scene(4, "planar", "cart", "mid", angles="absolute")
    gravity = jacobian(lower_function(derive(chain), "gravity_torque", "unrolled"), "g", "", [Block("out", "q", "slope")])
    assert sparsity(gravity) == {"slope": (6, 12, 18, 24)}
    program = lower_function(derive(chain), "state_jacobian", "unrolled")
    known = sparsity(program)
    seen = np.zeros(25, dtype=bool)
    for seed in range(3):
        seen |= evaluate(program, random_arguments(chain, program, seed))["dadq"].ravel() != 0
    assert set(np.flatnonzero(seen)) == set(known["dadq"])
    assert not set(known["dadq"]) & set(range(0, 25, 5))
