"""Paper B's (15) as a Program of its own: digits kept on hard chains, (15) as printed, and what it costs."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import count_operations, evaluate, evaluate_exactly, total_operations
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.reference import reference
from phichain.scene import Scene
from tests.handmade import coefficients
from tests.lowering.chains import random_arguments
from tests.lowering.hard_chains import PLACES, SPREADS, Hard, hard_chain
from tests.lowering.test_accuracy import SHAPES
from tests.reference_cases import relative_error


def check(hard: Hard, slack: float = 20.0) -> None:
    """Against Lagrange multipliers in 30 digits: 1e-14, or what double-precision arguments leave attainable."""
    q, v = hard.inputs["q"], hard.inputs["v"]
    offset = 2 * hard.scene.has_cart
    links = np.array(q[offset:]).reshape(-1, 3)
    q_dot = [*v[:offset], *np.cross(np.array(v[offset:]).reshape(-1, 3), links).ravel().tolist()]
    program = lower_function(derive(hard.scene), "direction_dynamics", "loops")
    given = {**hard.inputs, "q_dot": q_dot}
    found = evaluate(program, {array.name: given[array.name] for array in program.inputs})["q_ddot"]
    error = relative_error(
        found.tolist(), reference(hard.scene, "direction_dynamics", given, digits=30)["q_ddot"]
    )
    assert error < 1e-14 or error < slack * hard.attainable(), error


@pytest.mark.long
@pytest.mark.parametrize(("spread", "place"), list(product(SPREADS, PLACES)), ids=str)
@pytest.mark.parametrize("more", [{}, {"base": "cart", "cart_mass": 1e-6}], ids=["fixed", "light cart"])
def test_masses_and_lengths_over_many_decades(spread: str, place: str, more: dict[str, Any]) -> None:
    check(hard_chain(4, "spatial", spread=spread, place=place, **more))


@pytest.mark.parametrize("more", SHAPES, ids=lambda more: "-".join(f"{k}={v}" for k, v in more.items()))
@pytest.mark.parametrize("place", ["at the end", "half way"])
def test_shapes_and_rates(place: str, more: dict[str, Any]) -> None:
    check(hard_chain(4, "spatial", "heavy tip", place, **more))


@pytest.mark.parametrize("com", [None, [0.3, 1.3, 0.2]], ids=["tip masses", "masses anywhere"])
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize(
    "joints", [{}, {"stiffness": [2.0, 0.5, 1.5], "damping": [0.3, 0.1, 0.2]}], ids=["free", "joints"]
)
def test_it_solves_15_as_printed(joints: dict[str, Any], base: str, com: list[float] | None) -> None:
    """The Program in 40 digits put into the rows of (15), whose coefficients are those of theory sections 1 and 4."""
    mass, length, cart = [0.7, 1.9, 0.4], [0.5, 1.3, 0.8], {"cart_mass": 1.7} if base == "cart" else {}
    chain = Scene("chain", 3, space="spatial", base=base, mass=mass, length=length, com=com, **cart, **joints)
    program = lower_function(derive(chain), "direction_dynamics", "loops")
    offset = 2 * chain.has_cart
    with mp.workdps(40):
        given = {
            name: [mpf(float(x)) for x in values] for name, values in random_arguments(chain, program).items()
        }
        _make_exact(given, offset)
        accelerations = evaluate_exactly(program, given)["q_ddot"]
        residual = _printed(chain, mass, length, com or length, given, accelerations)
        assert max(map(abs, residual)) < mpf(10) ** -33 * max(map(abs, accelerations))


def _make_exact(given: dict[str, list[Any]], offset: int) -> None:
    """Unit vectors and tangent rates to 40 digits."""
    for k in range(offset, len(given["q"]), 3):
        q = mp.matrix(given["q"][k : k + 3])
        q /= mp.norm(q)
        rate = mp.matrix(given["q_dot"][k : k + 3])
        rate -= mp.fdot(q, rate) * q
        given["q"][k : k + 3], given["q_dot"][k : k + 3] = list(q), list(rate)


def _printed(
    chain: Scene,
    mass: list[float],
    length: list[float],
    com: list[float],
    given: dict[str, Any],
    q_ddot: list[Any],
) -> list[Any]:
    """M00 x'' + sum mu_k C^T q_k'' - u and c_ii (q_i'' + |q_i'|^2 q_i) + P_i (mu_i C x'' + sum c_ij q_j'' - mu_i g e_3)."""
    exact = [np.array([mpf(x) for x in values], dtype=object) for values in (mass, length, com)]
    mu, c = coefficients(*exact)
    offset = 2 * chain.has_cart
    q, rate, q_pp = (
        np.array(values[offset:], dtype=object).reshape(-1, 3)
        for values in (given["q"], given["q_dot"], q_ddot)
    )
    cart = np.array([*(q_ddot[:2] if offset else [mpf(0)] * 2), mpf(0)], dtype=object)
    fall = np.array([mpf(0), mpf(0), mpf(float(chain.gravity))], dtype=object)
    rows: list[Any] = []
    if offset:
        total = mpf(float(chain.cart_mass)) + sum(exact[0])  # type: ignore[arg-type]
        rows += list(total * cart[:2] + (mu @ q_pp)[:2] - np.array(given["u"], dtype=object))
    couple = _couples(chain, q, np.cross(q, rate))
    for i in range(chain.links):
        others = mu[i] * (cart - fall) + sum(c[i, j] * q_pp[j] for j in range(chain.links) if j != i)
        across = others - (q[i] @ others) * q[i]
        rows += list(c[i, i] * (q_pp[i] + (rate[i] @ rate[i]) * q[i]) + across + np.cross(couple[i], q[i]))
    return rows


def _couples(chain: Scene, q: np.ndarray, omega: np.ndarray) -> list[Any]:
    """J_i - J_{i+1}, J_k = k_k q_{k-1} x q_k + d_k (omega_k - omega_{k-1})."""
    nothing = np.array([mpf(0)] * 3, dtype=object)
    upright = np.array([mpf(0), mpf(0), mpf(1)], dtype=object)
    stiffness, damping = (
        [mpf(float(x)) for x in values or [0.0] * chain.links] for values in (chain.stiffness, chain.damping)
    )
    joint = [
        k * np.cross(inner, outer) + d * (spin - before)
        for k, d, inner, outer, spin, before in zip(
            stiffness, damping, [upright, *q], q, omega, [nothing, *omega], strict=False
        )
    ]
    return [own - beyond for own, beyond in zip(joint, [*joint[1:], nothing], strict=True)]


def test_it_needs_no_angular_velocity_unless_dampers_do() -> None:
    def names(**joints: Any) -> str:
        chain = Scene("b", 3, space="spatial", base="cart", mass=0.1, length=0.1, cart_mass=0.5, **joints)
        return str(lower_function(derive(chain), "direction_dynamics", "loops"))

    assert "omega" not in names() and "omega" not in names(stiffness=1.0)
    assert "omega" in names(damping=0.1)


@pytest.mark.parametrize("links", [2, 5, 16, 64])
def test_it_takes_60_operations_a_link_and_no_trigonometry(links: int) -> None:
    chain = Scene("b", links, space="spatial", base="cart", mass=0.1, length=0.1, cart_mass=0.5)
    program = lower_function(derive(chain), "direction_dynamics", "unrolled")
    assert total_operations(program) <= 60 * links
    assert not count_operations(program).keys() & {"sin", "cos"}
