"""The variational step with rotors at the joints: discrete Euler-Lagrange equations of the discrete Lagrangian, dense, in 40 digits."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.lowering.chains import Arguments, gap, label, random_arguments, scene
from tests.lowering.test_against_reference import error, truth

STEP = "step_variational"
CHAINS = [
    scene(2, "planar", "fixed", "mid", "geared", actuated="all"),
    scene(3, "planar", "fixed", "tip", "geared", actuated=[3]),
    scene(2, "planar", "cart", "rigid", "geared", angles="absolute", actuated="all"),
    scene(3, "planar", "cart", "held", "geared", angles="adjacent", actuated="none"),
]
#: Gravity that moves nothing, of a chain that may turn as a whole.
FREE = scene(3, "planar", "fixed", "mid", "geared", actuated="none", gravity=1e-30)
Numbers = list[Any]


@cache
def program(chain: Scene) -> Any:
    return lower_function(derive(chain), STEP, "loops")


def after(chain: Scene, state: Arguments, h: float) -> Arguments:
    """The state a step later, by the Program."""
    end = evaluate(program(chain), state | {"h": np.array(h)})
    return state | {"q": end["q_next"], "v": end["v_next"], "residual": end["residual"]}


def absolute(chain: Scene, angles: Numbers) -> Numbers:
    """Angles, or rates, of the links against the vertical."""
    found: Numbers = []
    for k, own in enumerate(angles):
        inner = {"absolute": 0, "relative": found[k - 1] if k else 0, "adjacent": angles[k - 1] if k else 0}
        found.append(own + inner[str(chain.angles)])
    return found


def spots(chain: Scene, q: Numbers) -> list[tuple[Any, Any, Any]]:
    """(weight, x, y): masses where they are, and moments of inertia at the ends of unit vectors along their links."""
    cart = int(chain.has_cart)
    x, y = (q[0] if cart else mpf(0)), mpf(0)
    found = [(mpf(chain.cart_mass), x, y)] if cart else []
    com, spin = chain.com or chain.length, chain.inertia or (0.0,) * chain.links
    for m, l, r, j, angle in zip(chain.mass, chain.length, com, spin, absolute(chain, q[cart:]), strict=True):
        s, c = mp.sin(angle), mp.cos(angle)
        found += [(mpf(m), x + mpf(r) * s, y + mpf(r) * c), (mpf(j), s, c)]
        x, y = x + mpf(l) * s, y + mpf(l) * c
    return found


def rotors(chain: Scene, turned: Numbers) -> Any:
    """sum A_k (turn of joint k)^2."""
    phi = absolute(chain, turned[int(chain.has_cart) :])
    return sum(mpf(a) * (b - c) ** 2 for a, b, c in zip(chain.armature, phi, [0, *phi], strict=False))


def falling(chain: Scene, q: Numbers) -> Any:
    """-V."""
    masses = spots(chain, q)[int(chain.has_cart) :: 2]
    return mpf(chain.gravity) * sum(m * y for m, _, y in masses)


def discrete(chain: Scene, h: Any, q0: Numbers, q1: Numbers) -> Any:
    """L_d: half the weighed squares of how far all has moved, and of how far joints have turned, over h; less h times the mean of V."""
    far = sum(w * ((b - a) ** 2 + (d - c) ** 2) for (w, a, c), (_, b, d) in zip(spots(chain, q0), spots(chain, q1), strict=True))
    far += rotors(chain, [b - a for a, b in zip(q0, q1, strict=True)])
    return far / (2 * h) + h / 2 * (falling(chain, q0) + falling(chain, q1))


def slopes(of: Callable[[Numbers], Any], at: Numbers, by: Any = None) -> Numbers:
    """Derivatives by every entry, from differences: tiny ones, or of any size where `of` is quadratic."""
    tiny = mpf(10) ** -12 if by is None else mpf(by)

    def moved(i: int, by: Any) -> Any:
        return of([entry + (by if i == k else 0) for k, entry in enumerate(at)])

    return [(moved(i, tiny) - moved(i, -tiny)) / (2 * tiny) for i in range(len(at))]


def energy(chain: Scene, q: Numbers, v: Numbers) -> Any:
    """T."""
    tiny = mpf(10) ** -12
    ends = ([a + by * b for a, b in zip(q, v, strict=True)] for by in (tiny, -tiny))
    before, then = (spots(chain, end) for end in ends)
    moving = sum(w * ((a - b) ** 2 + (c - d) ** 2) for (w, a, c), (_, b, d) in zip(before, then, strict=True)) / (2 * tiny) ** 2
    return (moving + rotors(chain, v)) / 2


def forces(chain: Scene, u: Numbers) -> Numbers:
    found = [mpf(0)] * chain.nv
    cart = int(chain.has_cart)
    targets = [*([0] if chain.has_force else []), *(cart + joint - 1 for joint in chain.actuated_joints)]
    for target, entry in zip(targets, u, strict=True):
        found[target] = entry
    return found


def exact(chain: Scene, state: Arguments, h: float, near: Any) -> tuple[Numbers, Numbers]:
    """The step by -D_1 L_d = p_0 + h/2 F, solved from nearby, and p_1 = D_2 L_d + h/2 F."""
    q0, v0, step = list(map(mpf, state["q"])), list(map(mpf, state["v"])), mpf(h)
    half = [step / 2 * entry for entry in forces(chain, list(map(mpf, state.get("u", ()))))]
    kicked = [p + f for p, f in zip(slopes(lambda v: energy(chain, q0, v), v0, 1), half, strict=True)]

    def gap_at(*q1: Any) -> Numbers:
        left = slopes(lambda q: discrete(chain, step, q, list(q1)), q0)
        return [a + p for a, p in zip(left, kicked, strict=True)]

    q1 = list(mp.findroot(gap_at, list(map(mpf, near)), tol=mpf(10) ** -40))
    p1 = [p + f for p, f in zip(slopes(lambda q: discrete(chain, step, q0, q), q1), half, strict=True)]
    columns = [slopes(lambda v: energy(chain, q1, v), [mpf(int(i == k)) for k in range(chain.nv)], 1) for i in range(chain.nv)]
    return q1, list(mp.lu_solve(mp.matrix(columns).T, mp.matrix(p1)))


@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_it_is_the_discrete_euler_lagrange_equations(chain: Scene) -> None:
    """Where links turn by up to a tenth of a radian and the rotors weigh as much as the links."""
    h = 0.05
    state = random_arguments(chain, program(chain), 2)
    found = after(chain, state, h)
    with mp.workdps(40):
        q, v = exact(chain, state, h, found["q"])
    assert gap(found["q"], [float(x) for x in q]) < 2e-15
    assert gap(found["v"], [float(x) for x in v]) < 1e-14
    assert found["residual"] < 1e-15


@pytest.mark.parametrize("rate", [-60.0, 0.0, 1.0, 40.0])
def test_a_free_link_and_its_rotor_share_one_momentum(rate: float) -> None:
    """m l^2 sin(turn) / h + A turn / h stays (m l^2 + A) rate: between the arcsine of a link and the line of a rotor."""
    mass, length, rotor, h = 0.7, 0.5, 0.25, 0.01
    chain = Scene("rotor", 1, mass=mass, length=length, armature=rotor, gravity=1e-30)
    own = mass * length**2
    turn = float(mp.findroot(lambda x: own * mp.sin(x) + rotor * x - h * (own + rotor) * rate, h * rate))
    end = after(chain, {"q": np.array([0.4]), "v": np.array([rate])}, h)
    assert abs(end["q"][0] - 0.4 - turn) < 5e-15 and abs(end["v"][0] - rate) < 1e-13


@pytest.mark.parametrize("chain", [FREE, CHAINS[3]], ids=["turning as a whole", "on a cart"])
def test_what_a_symmetry_conserves_is_kept_to_rounding(chain: Scene) -> None:
    """The moment of a chain without gravity, in which rotors count; the horizontal momentum of one on a cart that nobody pushes."""
    state = random_arguments(chain, program(chain), 3)
    momentum = lower_function(derive(chain), "momentum", "loops")

    def whole(at: Arguments) -> float:
        return float(evaluate(momentum, {"q": at["q"], "v": at["v"]})["out"][0])

    first, moved = whole(state), state
    for _ in range(10):
        moved = after(chain, moved, 0.02)
    assert gap(moved["q"], state["q"]) > 0.03
    assert abs(whole(moved) - first) < 1e-13 * abs(first)


def test_angles_that_have_wound_up_turn_as_small_ones_do() -> None:
    """The turn of a step is found from the vectors: thousands of turns round the end's angle and nothing else."""
    chain = CHAINS[0]
    state = random_arguments(chain, program(chain), 4)
    wound = state | {"q": state["q"] + 2 * np.pi * np.array([1e4, -3e3])}
    one, other = after(chain, state, 0.02), after(chain, wound, 0.02)
    assert gap(other["q"] - wound["q"], one["q"] - state["q"]) < 1e-8
    assert gap(other["v"], one["v"]) < 1e-10


@pytest.mark.parametrize("armature", [1e-8, 1e8])
@pytest.mark.parametrize("mass", [[1.0, 1e-8, 1.0], [1.0, 1.0, 1e8]], ids=["light link", "heavy tip"])
@pytest.mark.parametrize("com", [None, [0.3, 0.8, 0.5]], ids=["tip", "mid"])
def test_masses_and_gears_may_spread_over_eight_decades(com: Any, mass: list[float], armature: float) -> None:
    chain = Scene(
        "hard", 3, base="cart", cart_mass=1.0, mass=mass, length=[0.5, 1.3, 0.8], com=com, actuated="none", angles="absolute",
        armature=[armature, 0.0, 1.0],
    )  # fmt: skip
    arguments = random_arguments(chain, program(chain), 1) | {"h": np.array(7e-7)}
    found, expected = evaluate(program(chain), arguments), truth(chain, STEP, arguments)
    assert max(error(found[output], expected[output]) for output in found) < 2e-13
