"""Linear modes where springs and masses spread over decades, against 34 digits of the generalised eigenproblem."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from phichain.errors import UnsupportedError
from phichain.orbits import linear_modes, trace
from phichain.orbits.factored import _points
from phichain.orbits.modes import _of_jacobian
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from phichain.system.angles import absolute_angles, scene_angles
from phichain.system.described import Joints, Numbers
from tests.handmade import coefficients
from tests.orbits.shot import uniform

WANT = ("phi", "phi_jacobian")


@pytest.mark.parametrize("code", ["auto", "loops"])
@pytest.mark.parametrize(
    ("stiffness", "expected"),
    [(1e8, (191492.1272506973, 2088858.723506835)), (1e12, (19149212.70486444, 208885872.3149687))],
)
def test_stiff_springs_leave_the_masses_their_digits(stiffness: float, expected: tuple[float, float], code: str) -> None:
    sprung = Scene(
        "sprung", 2, mass=0.1, length=0.1, com=0.05, stiffness=stiffness, gravity=9.81, actuated="none", code=code, want=WANT
    )
    assert linear_modes(build(sprung)).omega == pytest.approx(expected, rel=4e-15)


def test_stiffer_springs_are_no_error() -> None:
    """At 1e14 the frequencies are those of 1e12 times ten: gravity is far below."""
    sprung = Scene("sprung", 2, mass=0.1, length=0.1, com=0.05, stiffness=1e14, gravity=9.81, actuated="none", want=WANT)
    assert linear_modes(build(sprung)).omega == pytest.approx((191492127.0486444, 2088858723.149687), rel=5e-13)


def unused(*_: object) -> None:
    raise AssertionError("the numbers serve")


def in_numbers(angles: str, mass, length, com=None, cart_mass=None, stiffness=None, armature=None) -> System:
    """A chain of which nothing but its numbers is looked at."""
    size = len(mass) + (cart_mass is not None)
    return System(
        "spread", "planar", "fixed" if cart_mass is None else "cart", len(mass), size, size, 0, angles=angles,
        functions={"phi_jacobian": unused}, numbers=Numbers(mass, length, com, cart_mass, 9.81), joints=Joints(stiffness, armature=armature),
    )  # fmt: skip


def exact_modes(system: System, mass, length, com, cart=(), spring=None, rotor=None) -> tuple[list, np.ndarray]:
    """Frequencies (rising) and shapes in the scene's angles from det(K - omega^2 M) of absolute angles in 60 digits."""
    n, carts = len(mass), len(cart)
    with mpmath.workdps(60):
        m, l, r = (mpmath.matrix(list(map(float, part))) for part in (mass, length, com))
        k = mpmath.matrix(list(map(float, spring or [0.0] * n)))
        lever = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(i + 1):
                lever[i, j] = r[i] if i == j else l[j]
        whole = mpmath.zeros(carts + n)
        whole[carts:, carts:] = lever
        for i in range(carts + n if carts else 0):
            whole[i, 0] = mpmath.mpf(1)
        masses = mpmath.diag([*map(mpmath.mpf, cart), *m])
        M = whole.T * masses * whole
        K = mpmath.zeros(carts + n)
        for i in range(n):
            K[carts + i, carts + i] += mpmath.mpf(9.81) * sum(m[j] * lever[j, i] for j in range(n)) + k[i]
            if i:
                K[carts + i - 1, carts + i - 1] += k[i]
                K[carts + i - 1, carts + i] -= k[i]
                K[carts + i, carts + i - 1] -= k[i]
        for i, a in enumerate(rotor or ()):  # A/2 (phi_i' - phi_(i-1)')^2
            M[carts + i, carts + i] += a
            if i:
                M[carts + i - 1, carts + i - 1] += a
                M[carts + i - 1, carts + i] -= a
                M[carts + i, carts + i - 1] -= a
        squares, vectors = mpmath.eig(M**-1 * K)
        rising = sorted(range(carts + n), key=lambda i: mpmath.re(squares[i]))[carts:]
        omega = [mpmath.sqrt(mpmath.re(squares[i])) for i in rising]
        shapes = np.array([[float(mpmath.re(vectors[j, i] / mpmath.norm(vectors[:, i]))) for i in rising] for j in range(carts + n)])
    own = np.column_stack([scene_angles(system, column) for column in shapes[carts:].T])
    largest = np.max(np.abs(own), axis=0)
    first = own[np.argmax(np.abs(own) > 1e-6 * largest, axis=0), np.arange(n)]
    return omega, np.vstack([shapes[:carts], own]) / largest * np.sign(first)


SPREAD = {
    "light above heavy": {"mass": [1e-6, 1.0], "length": [1.0, 0.5]},
    "heavy above light": {"mass": [1.0, 1e-6], "length": [1.0, 0.5]},
    "lighter still": {"mass": [1e-13, 1.0, 1e-13, 1.0], "length": [1.0, 0.5, 0.7, 0.3]},
    "on a cart": {"mass": [1e-8, 1.0, 1e-4], "length": [1.0, 0.5, 0.1], "cart_mass": 1e-5},
    "masses within": {"mass": [1e-6, 1.0, 1e-3], "length": [1.0, 0.5, 2.0], "com": [0.3, 0.1, 1.9]},
    "springs over decades": {"mass": [1e-6, 1.0, 1e-3], "length": [1.0, 0.5, 2.0], "com": [0.3, 0.1, 1.9], "stiffness": [1e9, 1e-3, 1e3]},
    "rotors behind stiff springs": {
        "mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8], "com": [0.3, 0.9, 0.5], "stiffness": [1e12, 1.0, 1e6], "armature": [0.1, 0.2, 0.3],
    },
    "heavy rotors on a cart": {"mass": [0.7, 1e-3, 4.0], "length": [0.5, 1.3, 0.8], "cart_mass": 2.0, "armature": [10.0, 0.0, 0.3]},
    "two stiff springs": {"mass": [1.0, 2.0, 0.3], "length": [1.0, 0.5, 0.7], "stiffness": [1e12, 1e-3, 1e12]},
}


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
@pytest.mark.parametrize("kind", SPREAD)
def test_spread_masses_leave_every_frequency_its_digits(kind: str, angles: str) -> None:
    given = SPREAD[kind]
    system = in_numbers(angles, **given)
    found = linear_modes(system)
    cart = [given["cart_mass"]] if "cart_mass" in given else []
    omega, shapes = exact_modes(system, given["mass"], given["length"], given.get("com", given["length"]), cart, given.get("stiffness"), given.get("armature"))
    assert [float(abs(a / b - 1)) for a, b in zip(found.omega, omega, strict=True)] == pytest.approx([0.0] * len(omega), abs=2e-15)
    assert found.shapes == pytest.approx(shapes, abs=1e-14)


def test_a_light_mass_above_a_heavy_one() -> None:
    omega = linear_modes(in_numbers("relative", [1e-6, 1.0], [1.0, 0.5])).omega
    assert omega[1] == pytest.approx(5424.944505706814, rel=1e-15)


def test_runtime_numbers_and_both_routes_agree() -> None:
    """Phi's Jacobian alone serves where the numbers are not known, or gravity pulls upwards on springs."""
    names = ("mass", "length", "com", "gravity", "stiffness")
    runtime = build(Scene("told", 3, actuated="none", want=WANT, **dict.fromkeys(names, "runtime")))
    p = {"mass": [1.0, 2.0, 0.5], "length": [0.5, 0.4, 0.3], "com": [0.4, 0.1, 0.3], "gravity": 9.81, "stiffness": [1.0, 2.0, 3.0]}
    fixed = linear_modes(in_numbers("relative", **{name: value for name, value in p.items() if name != "gravity"}))
    told = linear_modes(runtime, p)
    assert told.omega.tolist() == fixed.omega.tolist() and told.shapes.tolist() == fixed.shapes.tolist()
    other = _of_jacobian(runtime, runtime.phi_jacobian, runtime.parameters(p))
    assert other.omega == pytest.approx(fixed.omega, rel=1e-13) and other.shapes == pytest.approx(fixed.shapes, abs=1e-12)
    lifted = p | {"gravity": -0.01}
    upwards = _of_jacobian(runtime, runtime.phi_jacobian, runtime.parameters(lifted))
    assert linear_modes(runtime, lifted).omega.tolist() == upwards.omega.tolist()


def test_a_damped_scene_is_told_what_it_lacks() -> None:
    """Not to ask for a function that it would be refused."""
    damped = System("damped", "planar", "fixed", 2, 2, 2, 0, joints=Joints(damping=(0.1, 0.2)))
    with pytest.raises(UnsupportedError, match="damping: .*no periodic motion.*leave the dampers out") as caught:
        trace(damped)
    assert "phi_jacobian" not in str(caught.value)


@pytest.mark.parametrize(
    ("k", "known"),
    [(1e8, (191492.1272506973, 2088858.723506835)), (1e12, (19149212.70486444, 208885872.3149687)), (1e14, None)],
)
def test_stiff_springs_leave_every_frequency_its_digits(k: float, known) -> None:
    """Two links of .1 kg and .1 m, com .05, right to 34 digits by others, and by 60 digits here."""
    system = in_numbers("relative", [0.1, 0.1], [0.1, 0.1], [0.05, 0.05], stiffness=[k, k])
    found = linear_modes(system).omega
    exact, _ = exact_modes(system, [0.1, 0.1], [0.1, 0.1], [0.05, 0.05], spring=[k, k])
    assert found == pytest.approx([float(omega) for omega in exact], rel=1e-15)
    assert known is None or found == pytest.approx(known, rel=1e-15)


def test_no_function_is_needed_where_the_numbers_are_known() -> None:
    bare = replace(in_numbers("relative", [1e-6, 1.0], [1.0, 0.5]), functions={})
    assert linear_modes(bare).omega[1] == pytest.approx(5424.944505706814, rel=1e-15)


def test_links_with_inertia_move_as_chains_of_their_percussion_points() -> None:
    """mu_k and c_ij of rods with masses over decades, and what is left at the base, from positive terms only."""
    mass, length, inertia = np.array([1.0, 1e-6, 2.0, 0.3]), np.array([1.0, 0.5, 0.7, 0.2]), np.array([0.1, 1e-9, 0.0, 0.01])
    com = np.array([0.5, 0.7, 0.7, 0.05])
    masses, places, _, left = _points(mass, length, com, inertia)
    mu, c = coefficients(mass, length, com)
    own_mu, own_c = coefficients(masses, length, places)
    assert own_mu == pytest.approx(mu, rel=1e-14) and own_c == pytest.approx(c + np.diag(inertia), rel=1e-14)
    assert left + masses.sum() == pytest.approx(mass.sum(), rel=1e-15) and left > 0


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"friction": 0.1, "friction_speed": 0.1}, "friction: .*come to rest"),
        ({"base": "cart", "cart_mass": 1.0, "cart_damping": 0.1}, "cart_damping: .*come to rest"),
        ({"base": "cart", "cart_mass": 1.0, "cart_friction": 0.1, "cart_friction_speed": 0.1}, "cart_friction: .*come to rest"),
        ({"stiffness": 1.0, "rest_angle": [0.1, 0.2]}, "rest_angle: .*bends"),
        ({"base": "cart", "drive": "acceleration"}, 'drive: .*base = "fixed"'),
    ],
)
def test_a_chain_without_families_is_told_why(keys: dict[str, Any], words: str) -> None:
    system = build(Scene("without_families", 2, mass=1.0, length=[1.0, 0.5], want=["forward_dynamics"], **keys))
    with pytest.raises(UnsupportedError, match=words.replace("bends", "bend")):
        linear_modes(system)


@pytest.mark.parametrize("angles", ["absolute", "relative", "adjacent"])
def test_angles_of_the_scene_are_those_of_each_row(angles: str) -> None:
    """Many chains' angles at once, as one by one, and back."""
    system, phi = replace(uniform(3), angles=angles), np.random.default_rng(3).normal(size=(5, 3))
    theta = scene_angles(system, phi)
    assert absolute_angles(system, theta) == pytest.approx(phi, abs=1e-14)
    assert all(np.array_equal(row, scene_angles(system, own)) for row, own in zip(theta, phi, strict=True))
