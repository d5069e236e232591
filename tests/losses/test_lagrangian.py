"""Forward dynamics with everything that loses energy against the dense Lagrangian in 50 digits, and what losses must do by themselves."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from random import Random
from typing import Any

import numpy as np
import pytest
import sympy
from mpmath import mp, mpf

from phichain.errors import DerivationError, UnsupportedError
from phichain.ir import evaluate
from phichain.lowering import lower, lower_function
from phichain.mechanics import Model, derive
from phichain.mechanics.equilibria import equilibrium
from phichain.mechanics.lagrange import with_symbols
from phichain.reference import reference
from phichain.scene import Scene
from tests.losses.chains import braked, offered
from tests.losses.dense import accelerations

#: Of the accelerations, max norm over max norm.
_DIGITS = 1e-14


def drawn(source: Random, decades: float, base: str, angles: str, com: bool) -> Scene:
    """A random chain; masses, lengths and what acts spread over so many decades."""
    links = source.randrange(1, 7)

    def numbers(spread: float = 0.0) -> list[float]:
        return [10 ** source.uniform(-spread / 2, spread / 2) * source.uniform(0.5, 1.5) for _ in range(links)]

    length = numbers(decades / 2)
    own = {"com": [source.uniform(0.2, 0.9) * x for x in length]} if com else {}
    cart = {"cart_mass": 1.3, "cart_damping": source.uniform(0, 2), "cart_friction": source.uniform(0, 2)} if base == "cart" else {}
    return Scene(
        "dense", links, base=base, angles=angles, mass=numbers(decades), length=length, **own, **cart,
        stiffness=numbers(), rest_angle=[source.uniform(-2, 2) for _ in range(links)], damping=numbers(), friction=numbers(),
        friction_speed=10 ** source.uniform(-3, 0), cart_friction_speed=0.02 if cart else None, actuated="all",
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(("base", "angles"), list(product(("fixed", "cart"), ("relative", "absolute", "adjacent"))))
def test_against_the_dense_lagrangian(base: str, angles: str) -> None:
    source, worst = Random(f"losses {base} {angles}"), 0.0
    for trial in range(24):
        chain = drawn(source, 4.0 if trial % 2 else 0.0, base, angles, com=trial % 3 != 0)
        q, v, u = ([source.uniform(-2, 2) for _ in range(n)] for n in (chain.nq, chain.nv, chain.nu))
        v = [x * 10 ** source.uniform(-3, 0) for x in v]
        program = lower_function(derive(chain), "forward_dynamics", "loops")
        found = evaluate(program, {"q": q, "v": v, "u": u})["a"]
        with mp.workdps(50):
            exact = accelerations(chain, q, v, u)
            moved = accelerations(chain, q, [x * (1 + mpf(2) ** -53) for x in v], u)
            size = max(map(abs, exact))
            error = max(abs(mpf(float(a)) - b) for a, b in zip(found, exact, strict=True)) / size
            own = max(abs(a - b) for a, b in zip(moved, exact, strict=True)) / size
        worst = max(worst, float(error / max(1, own / mpf(10) ** -15)))
    assert worst < _DIGITS


def test_the_reference_is_the_dense_lagrangian_too() -> None:
    """Two routes that share nothing agree to 40 digits."""
    source = Random("two routes")
    for base, angles in product(("fixed", "cart"), ("relative", "adjacent")):
        chain = drawn(source, 2.0, base, angles, com=True)
        state = {name: [source.uniform(-2, 2) for _ in range(n)] for name, n in (("q", chain.nq), ("v", chain.nv), ("u", chain.nu))}
        found = reference(chain, "forward_dynamics", state, digits=45)["a"]
        with mp.workdps(45):
            exact = accelerations(chain, state["q"], state["v"], state["u"])
            assert max(abs(a - b) for a, b in zip(found, exact, strict=True)) < mpf(10) ** -40 * max(map(abs, exact))


def test_a_mass_on_a_rail_obeys_its_equation() -> None:
    """A cart with a link at rest that hangs: m x'' = F - d x' - F_0 tanh(x' / v_0) where the link does not pull."""
    chain = Scene("rail", 1, base="cart", mass=1e-9, length=1.0, cart_mass=2.0, cart_damping=0.5, cart_friction=3.0,
                  cart_friction_speed=0.1)  # fmt: skip
    program = lower_function(derive(chain), "forward_dynamics", "loops")
    for speed in (-2.0, -0.05, 0.0, 0.2):
        found = evaluate(program, {"q": [0.0, 0.0], "v": [speed, 0.0], "u": [1.5]})["a"][0]
        assert found == pytest.approx((1.5 - 0.5 * speed - 3.0 * np.tanh(speed / 0.1)) / 2.0, abs=1e-8)


def test_losses_take_the_power_that_they_say() -> None:
    """d(T + V)/dt = -sum (d_k w_k^2 + F_k w_k tanh(w_k / v_0)), the cart's included; springs that rest elsewhere take none."""
    chain = braked(3, "planar", "cCkdfrm", angles="absolute", actuated="none", want=("energy",))
    source, h = Random("power"), mpf(10) ** -15
    q, v = ([source.uniform(-1, 1) for _ in range(4)] for _ in range(2))
    with mp.workdps(60):
        a = accelerations(chain, q, v)
        ends = []
        for sign in (1, -1):
            place = [mpf(x) + sign * h * mpf(y) + h * h / 2 * z for x, y, z in zip(q, v, a, strict=True)]
            rate = [mpf(x) + sign * h * y for x, y in zip(v, a, strict=True)]
            found = reference(chain, "energy", {"q": place, "v": rate}, digits=55)
            ends.append(found["kinetic"] + found["potential"])
        w = [mpf(v[1]), *(mpf(y) - mpf(x) for x, y in pairwise(v[1:]))]
        lost = sum(mpf(d) * x * x + mpf(F) * x * mp.tanh(x / mpf(0.8)) for d, F, x in zip(chain.damping, chain.friction, w, strict=True))
        lost += mpf(0.45) * mpf(v[0]) ** 2 + mpf(0.9) * v[0] * mp.tanh(mpf(v[0]) / mpf(1.3))
        assert abs((ends[0] - ends[1]) / (2 * h) + lost) < mpf(10) ** -25


def test_joint_dampers_do_not_brake_the_cart() -> None:
    """Forces between links are inner ones: the momentum of cart and links along the rail is kept, whatever joints resist."""
    chain = braked(3, "planar", "kdfm", actuated="none")
    q, v = [0.1, 0.4, -0.9, 0.3], [0.2, 1.0, -2.0, 0.7]
    free = braked(3, "planar", "m", actuated="none")
    with mp.workdps(30):
        pulls = []
        for each in (chain, free):
            a = accelerations(each, q, v)
            u = reference(free, "inverse_dynamics", {"q": q, "v": v, "a": a}, digits=25)["u"]
            pulls.append(u[0])
        assert max(map(abs, pulls)) < mpf(10) ** -20


@pytest.mark.parametrize("energy", ["kinetic", "potential", "dissipation"])
def test_a_model_that_lacks_an_energy_is_refused(energy: str) -> None:
    model = derive(braked(2, "planar", "cCkdfr"))
    with pytest.raises(DerivationError):
        lower(changed(model, **{energy: sympy.S.Zero}))


@pytest.mark.parametrize("law", ["friction", "cart_friction", "cart_damping", "damping", "rest_angle"])
def test_a_model_with_another_law_is_refused(law: str) -> None:
    """A dissipation or a spring of half the size is no form of the scene's."""
    chain, other = braked(2, "planar", "cCkdfr"), {}
    value = getattr(chain, law)
    other[law] = value / 2 if isinstance(value, float) else [x / 2 for x in value]
    given = derive(Scene(**(keys(chain) | other))).energies
    model = derive(chain)
    with pytest.raises(DerivationError, match="Lagrangian"):
        lower(changed(model, dissipation=given.dissipation, potential=given.potential, definitions=given.definitions))


def changed(model: Model, **energies: Any) -> Model:
    """The same with other energies."""
    return replace(model, energies=replace(model.energies, **energies))


def keys(chain: Scene) -> dict[str, object]:
    """The arguments that make a scene."""
    names = ("name", "links", "base", "mass", "length", "cart_mass", "cart_damping", "cart_friction", "cart_friction_speed",
             "stiffness", "damping", "rest_angle", "friction", "friction_speed")  # fmt: skip
    return {name: getattr(chain, name) for name in names}


def test_what_a_model_shows() -> None:
    model = derive(with_symbols(braked(1, "planar", "cCkdfr")))
    text = str(model)
    assert "J_k = k_k (phi_k - phi_{k-1} - alpha_k) + d_k (phi_k' - phi_{k-1}') + F_k tanh((phi_k' - phi_{k-1}') / v_0)" in text
    assert "+ d_0 x' + F_0 tanh(x' / v_0)" in text
    assert {str(model.cart_damping), str(model.cart_friction), str(model.friction[0]), str(model.rest_angle[0])} == {
        "d_0", "F_0", "F_1", "alpha_1",
    }  # fmt: skip
    assert r"\tanh" in derive(braked(4, "planar", "cCfr" + "k")).latex()


def test_what_a_model_shows_in_space() -> None:
    model = derive(braked(2, "spatial", "fCc"))
    text = str(model)
    assert "F_k tanh(|w_k| / v_0) w_k / |w_k|, w_k = omega_k - omega_{k-1}" in text
    assert "+ d_0 x' + F_0 tanh(|x'| / v_0) x' / |x'|" in text
    assert r"\tanh\frac{\|w_k\|}{v_0}" in model.latex()


def test_a_straight_chain_is_no_equilibrium_of_springs_that_rest_elsewhere() -> None:
    model = derive(braked(2, "planar", "kr"))
    for signs in ((1, 1), (-1, -1)):
        with pytest.raises(UnsupportedError, match="rest_angle"):
            equilibrium(model, signs)


def test_what_losses_leave_no_function_of() -> None:
    """phi has no solution in phase; the others are there."""
    assert {"phi", "phi_jacobian"}.isdisjoint(offered(braked(1, "planar", "c")))
    assert {"phi", "phi_jacobian"}.isdisjoint(offered(braked(1, "planar", "kr")))
    dry = offered(braked(1, "planar", "f"), flows=True)
    assert "phi" not in dry and {"propagate", "propagate_batch", "propagate_stiff"} <= set(dry)
