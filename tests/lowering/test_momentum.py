"""The generalised momenta: M v, 2 T = p.v, the gradient of T, 50 digits, O(N), and what is conserved along a motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain import build
from phichain.ir import count_operations, evaluate, evaluate_exactly, total_operations
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.scene import Scene
from tests.lowering.chains import Arguments, gap, kinds, label, random_arguments, scene

SPREAD = scene(4, "planar", "cart", "unlike", angles="adjacent"), scene(4, "spatial", "cart", "unlike")


def found(chain: Scene, name: str, arguments: Arguments) -> dict[str, np.ndarray]:
    """A function at arguments that may be too many for it."""
    program = lower_function(derive(chain), name, "loops")
    return evaluate(program, {a.name: arguments[a.name] for a in (*program.params, *program.inputs)})


def drawn(chain: Scene, seed: int = 3) -> Arguments:
    return random_arguments(chain, lower_function(derive(chain), "momentum", "loops"), seed)


@pytest.mark.parametrize("chain", [*kinds()], ids=label)
def test_it_is_the_mass_matrix_times_the_rates(chain: Scene) -> None:
    """In space for tangent rates, where it is orthogonal to every link."""
    arguments = drawn(chain)
    p = found(chain, "momentum", arguments)["out"]
    assert gap(p, found(chain, "mass_matrix", arguments)["out"] @ arguments["v"]) < 1e-14
    assert abs(p @ arguments["v"] - 2 * found(chain, "energy", arguments)["kinetic"]) < 1e-14 * abs(p @ arguments["v"])
    if not chain.is_planar:
        first = 2 * chain.has_cart
        links, momenta = arguments["q"][first:].reshape(-1, 3), p[first:].reshape(-1, 3)
        assert np.max(np.abs(np.sum(links * momenta, axis=1))) < 1e-14 * np.max(np.abs(p))


@pytest.mark.long
@pytest.mark.parametrize("chain", [*kinds()], ids=label)
def test_it_is_the_gradient_of_the_kinetic_energy(chain: Scene) -> None:
    """By complex steps, along every rate whether tangent or not: T asks for omega_k x q_k alone."""
    arguments = drawn(chain, 4)
    slopes = []
    for i in range(chain.nv):
        moved = arguments | {"v": arguments["v"] + 1e-30j * np.eye(chain.nv)[i]}
        slopes.append(found(chain, "energy", moved)["kinetic"].imag / 1e-30)
    assert gap(found(chain, "momentum", arguments)["out"], slopes) < 1e-13


@pytest.mark.parametrize("chain", [*SPREAD, *(c for c in kinds() if c.runtime)], ids=label)
def test_fifty_digits(chain: Scene) -> None:
    """The Program in 60 digits against the dense sum over positions."""
    program, arguments = lower_function(derive(chain), "momentum", "loops"), drawn(chain, 5)
    inputs: dict[str, Any] = {k: v.ravel().tolist() for k, v in arguments.items() if k not in chain.runtime}
    params = {k: v.tolist() for k, v in arguments.items() if k in chain.runtime}
    with mp.workdps(60):
        if not chain.is_planar:
            inputs |= exact_state(chain, inputs)
        known = {k: [mp.mpf(x) for x in np.ravel(v).tolist()] for k, v in params.items()}
        made = evaluate_exactly(program, {**inputs, **known}, 60)["out"]
        expected = reference(chain, "momentum", inputs, digits=50, params=params)["p"]
        apart = max(abs(a - b) for a, b in zip(made, expected, strict=True))
        assert apart < mp.mpf("1e-45") * max(map(abs, expected))


def exact_state(chain: Scene, inputs: dict[str, list[float]]) -> dict[str, list[Any]]:
    """The unit vectors and tangent rates nearest to a state, to the working precision."""
    q, v = [mp.mpf(x) for x in inputs["q"]], [mp.mpf(x) for x in inputs["v"]]
    for start in range(2 * chain.has_cart, chain.nq, 3):
        part = slice(start, start + 3)
        size = mp.sqrt(mp.fdot(q[part], q[part]))
        q[part] = [x / size for x in q[part]]
        along = mp.fdot(v[part], q[part])
        v[part] = [w - along * x for w, x in zip(v[part], q[part], strict=True)]
    return {"q": q, "v": v}


@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("com", [None, 0.03])
def test_operations_grow_with_the_links_alone(space: str, com: float | None) -> None:
    """The same for each further link; masses at the ends of their links leave out what lies beyond them."""

    def counted(links: int, com: float | None) -> int:
        keys: dict[str, Any] = {"mass": 0.1, "length": 0.1, "com": com, "space": space}
        return total_operations(lower_function(derive(Scene("chain", links, **keys)), "momentum", "unrolled"))

    sizes = [counted(links, com) for links in (8, 9, 10)]
    most = {("planar", None): 19, ("planar", 0.03): 28, ("spatial", None): 33, ("spatial", 0.03): 45}[space, com]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0] <= most
    assert counted(8, None) <= counted(8, com)


def test_spatial_chains_need_no_trigonometry_and_no_division() -> None:
    counts = count_operations(lower_function(derive(scene(3, "spatial", "cart", "mid")), "momentum", "unrolled"))
    assert counts.keys() <= {"add", "sub", "mul"}


@pytest.mark.long
@pytest.mark.parametrize("space", ["planar", "spatial"])
def test_the_momentum_of_an_unpushed_cart_is_kept(space: str) -> None:
    """Emitted C along an emitted flow: nothing acts on the chain sideways."""
    chain = replace(scene(3, space, "cart", "mid", actuated="none"), want=("momentum", "propagate"), name=f"free_{space}")
    system, start = build(chain), drawn(chain, 6)
    before = system.momentum(start["q"], start["v"])
    end = system.propagate(start["q"], start["v"], 0.0, 2.0, 1e-14)
    after, axes = system.momentum(end.q, end.v), 1 if chain.is_planar else 2
    assert np.max(np.abs(after[:axes] - before[:axes])) < 1e-12 * np.max(np.abs(before))
    assert np.max(np.abs(after[axes:] - before[axes:])) > 1e-2
