"""The variational equations along the flow: closed forms, differences of the flow itself, invariants, and what goes wrong."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from phichain import build
from phichain.emit.flow.propagate import flow
from phichain.errors import ArrayError, UnsupportedError
from phichain.ir.evaluate import evaluate_exactly
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.native.flows.propagate import Propagate
from phichain.scene import Scene, scene_from_dict
from phichain.system.propagation import Stop
from tests.flow.flows import STRICT, compiled, planar, unit

Vector = NDArray[np.float64]
ASKED: dict[str, Any] = {"functions": {"want": ["propagate"]}, "flow": {"variational": True}}


def chain(name: str, space: str, base: str, links: int, **more: Any) -> Scene:
    tables = {key: more.pop(key) for key in ("joints", "target") if key in more}
    table = {"links": links, "space": space, "base": base, **more}
    return scene_from_dict({"name": name, "chain": table, **tables, **ASKED})


ONE = chain("one", "planar", "fixed", 1, mass=1, length=1)
TWO = planar(2, "two", **ASKED)
FIVE = planar(5, "five", **ASKED)
CHAINS = {
    "two": TWO,
    "five": FIVE,
    "cart": chain(
        "carted", "planar", "cart", 2, mass=[1, 0.3], length=[1, 0.5], cart_mass=0.7,
        joints={"stiffness": [5, 0], "damping": [0.1, 0.2], "angles": "absolute"},
    ),
    "loops": chain("looped", "planar", "fixed", 3, mass=1, length=1, com=0.5, target={"code": "loops"}),
}  # fmt: skip


def start(scene: Scene) -> Vector:
    return np.concatenate([np.linspace(0.5, -0.3, scene.nq), np.linspace(-0.4, 0.6, scene.nv)])


def ends(go: Propagate, scene: Scene, x: Vector, t: float, **more: Any) -> Vector:
    u = {"u": np.full(scene.nu, 0.2)} if scene.nu else {}
    found = go(x[: scene.nq], x[scene.nq :], 0.0, t, 1e-16, **u, **more)
    return np.append(found.q, found.v)


def differences(move: Any, step: float = 2e-3) -> Vector:
    """Derivative at 0 of a vector function, central differences of order 10."""
    weights = (5 / 6, -5 / 21, 5 / 84, -5 / 504, 1 / 1260)
    pairs = (w * (move(k * step) - move(-k * step)) for k, w in enumerate(weights, 1))
    return np.sum(list(pairs), axis=0) / step


# --- against closed forms and the flow itself --------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.5, 2.0, 3.0])
def test_monodromy_of_the_pendulum(amplitude: float) -> None:
    """Over a period T(A) from rest at A: the identity, but for d theta'/dA = -T'(A) theta''(0)."""
    with mpmath.workdps(30):
        g = mpmath.mpf(981) / 100

        def period(a: Any) -> Any:
            return 4 * mpmath.ellipk(mpmath.sin(a / 2) ** 2) / mpmath.sqrt(mpmath.mpf(9.81))

        shear = float(mpmath.diff(period, mpmath.mpf(amplitude)) * g * mpmath.sin(mpmath.mpf(amplitude)))
        t = float(period(mpmath.mpf(amplitude)))
    found = compiled(ONE)([amplitude], [0.0], 0.0, t, 1e-16, transition=np.eye(2)).transition
    assert found is not None
    assert np.max(np.abs(found - [[1, 0], [shear, 1]])) < 2e-14 * (1 + abs(shear)) * (1 + abs(shear))


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
def test_transition_is_the_derivative_of_the_flow(name: str) -> None:
    scene, x = CHAINS[name], start(CHAINS[name])
    go, size = compiled(scene), 2 * scene.nq
    u = {"u": np.full(scene.nu, 0.2)} if scene.nu else {}
    t = 0.1
    found = go(x[: scene.nq], x[scene.nq :], 0.0, t, 1e-16, transition=np.eye(size), **u).transition
    assert found is not None
    for i, unit_vector in enumerate(np.eye(size)):
        column = differences(lambda s, e=unit_vector: ends(go, scene, x + s * e, t))  # type: ignore[misc]
        assert np.max(np.abs(found[:, i] - column)) < 1e-11 * np.max(np.abs(found))


def test_tangent_vectors_on_the_sphere() -> None:
    """A link turned about any axis, its rate turned with it and made faster."""
    scene = chain("whirl", "spatial", "cart", 2, mass=[0.1, 0.2], length=0.1, cart_mass=0.5)
    go, random = compiled(scene), np.random.default_rng(3)
    q = random.normal(size=(2, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    omega, axes, faster = (np.cross(q, random.normal(size=(2, 3))) for _ in range(3))

    def moved(s: float) -> Vector:
        turned = [_turned(axis, s) for axis in axes]
        directions = [turn @ row for turn, row in zip(turned, q, strict=True)]
        rates = [turn @ (row + s * more) for turn, row, more in zip(turned, omega, faster, strict=True)]
        return np.concatenate([[0.1 * s, 0.2], *directions, [0.3, 0.1 - s], *rates])

    tangent = differences(moved)[:, None]
    found = go(moved(0)[:8], moved(0)[8:], 0.0, 0.2, 1e-16, u=[0.2, 0.2], transition=tangent).transition
    assert found is not None
    expected = differences(lambda s: ends(go, scene, moved(s), 0.2))
    assert np.max(np.abs(found[:, 0] - expected)) < 1e-11 * np.max(np.abs(expected))


def _turned(axis: Vector, angle: float) -> Vector:
    """The rotation about an axis (Rodrigues), angle in units of the axis' length."""
    x, y, z = axis
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    size = float(np.linalg.norm(axis))
    sine, cosine = np.sin(angle * size) / size, (1 - np.cos(angle * size)) / size**2
    return np.eye(3) + sine * hat + cosine * hat @ hat


def test_transition_is_symplectic_in_momenta() -> None:
    """P^T J P = J for P the transition in (q, p), p = M(q) v, its derivatives in 40 digits."""
    mass = lower_function(derive(TWO), "mass_matrix", "loops")

    def momentum(x: Any) -> Any:
        m = evaluate_exactly(mass, {"q": x[:2]}, 40)["out"]
        return [mpmath.fsum(m[2 * i + j] * x[2 + j] for j in range(2)) for i in range(2)]

    def to_momenta(x: Vector) -> Vector:
        with mpmath.workdps(40):
            step, exact = mpmath.mpf(10) ** -12, [mpmath.mpf(value) for value in x]
            columns = []
            for i in range(4):
                ahead, behind = list(exact), list(exact)
                ahead[i], behind[i] = ahead[i] + step, behind[i] - step
                columns.append(
                    [
                        float((a - b) / (2 * step))
                        for a, b in zip(momentum(ahead), momentum(behind), strict=True)
                    ]
                )
        return np.vstack([np.eye(4)[:2], np.array(columns).T])

    x = np.array([1.2, -0.4, 0.3, 2.0])
    found = compiled(TWO)(x[:2], x[2:], 0.0, 2.0, 1e-16, transition=np.eye(4))
    assert found.transition is not None
    end = np.append(found.q, found.v)
    symplectic = to_momenta(end) @ found.transition @ np.linalg.inv(to_momenta(x))
    j = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
    assert np.max(np.abs(symplectic)) > 3
    assert np.max(np.abs(symplectic.T @ j @ symplectic - j)) < 1e-13 * np.max(np.abs(symplectic)) ** 2


def test_there_and_back_is_the_identity() -> None:
    go = compiled(FIVE)
    x = start(FIVE)
    there = go(x[:5], x[5:], 0.0, 0.3, 1e-16, transition=np.eye(10))
    back = go(there.q, there.v, 0.3, 0.0, 1e-16, transition=there.transition)
    assert back.transition is not None and there.transition is not None
    assert np.max(np.abs(back.transition - np.eye(10))) < 1e-13 * np.linalg.cond(there.transition)


# --- what it leaves alone, and accuracy --------------------------------------------------------------------------------


def test_the_state_is_that_without_derivatives() -> None:
    go = compiled(TWO)
    alone, along = (
        go([0.9, 0.1], [0, 0], 0.0, 5.0, 1e-12, **more) for more in ({}, {"transition": np.eye(4)})
    )
    assert alone.transition is None
    assert alone.steps <= along.steps <= 1.5 * alone.steps
    assert np.max(np.abs(alone.q - along.q)) < 1e-11


@pytest.mark.parametrize("tol", [1e-6, 1e-9, 1e-12])
def test_errors_of_derivatives_follow_the_tolerance(tol: float) -> None:
    go = compiled(FIVE)
    exact, found = (
        go([0.4, 0, 0, 0, 0], np.zeros(5), 0.0, 1.0, t, transition=np.eye(10)).transition
        for t in (1e-16, tol)
    )
    assert exact is not None and found is not None
    assert np.max(np.abs(found - exact)) < tol * np.max(np.abs(exact))


@pytest.mark.parametrize("tol", [1e-6, 1e-9, 1e-12])
def test_columns_hardly_shorten_the_steps(tol: float) -> None:
    """Relative to the motion their goal would cost a quarter more steps."""
    go = compiled(FIVE)
    alone, along = (
        go([0.4, 0, 0, 0, 0], np.zeros(5), 0.0, 1.0, tol, **more) for more in ({}, {"transition": np.eye(10)})
    )
    assert along.steps < 1.15 * alone.steps


def test_vectors_of_columns_are_those_of_the_processor() -> None:
    """Wider ones would be taken apart in memory; narrower ones than all columns need are not padded."""
    wide, narrow = unit(FIVE)[0], unit(TWO)[0]
    sizes = [line.split()[-1] for line in wide.splitlines() if "TANGENT_BYTES " in line]
    assert sizes == ["64", "32", "16"]
    assert "__AVX512F__" in wide and [
        line.split()[-1] for line in narrow.splitlines() if "define TWO_TANGENT_BYTES" in line
    ] == ["32", "32", "16"]


def test_columns_do_not_depend_on_their_company() -> None:
    """Some columns alone, in blocks that are not full, are those of the whole matrix."""
    go = compiled(FIVE)
    q, v = np.linspace(0.4, 0, 5), np.zeros(5)
    whole = go(q, v, 0.0, 0.5, 1e-16, transition=np.eye(10)).transition
    some = go(q, v, 0.0, 0.5, 1e-16, transition=np.eye(10)[:, 2:9]).transition
    assert whole is not None and some is not None
    assert some.shape == (10, 7)
    assert np.max(np.abs(some - whole[:, 2:9])) < 1e-13 * np.max(np.abs(whole))


def test_pieces_and_stops_carry_it_on() -> None:
    go = compiled(TWO)
    whole = go([0.9, 0.1], [0, 0], 0.0, 1.0, 1e-13, transition=np.eye(4))
    q, v, t, lost, carried = np.array([0.9, 0.1]), np.zeros(2), 0.0, None, np.eye(4)
    met = 0
    while t != 1.0:
        part = go(q, v, t, 1.0, 1e-13, max_steps=3, stop=Stop("v", 0), lost=lost, transition=carried)
        q, v, t, lost, carried = part.q, part.v, part.t, part.lost, part.transition
        met += part.outcome == "event"
    assert met >= 1
    assert whole.transition is not None and carried is not None
    assert np.max(np.abs(carried - whole.transition)) < 1e-12 * np.max(np.abs(whole.transition))


# --- text and trouble ----------------------------------------------------------------------------------------------------


def test_scenes_that_do_not_ask_have_no_trace_of_it() -> None:
    made = flow(derive(planar(2)))
    assert "column" not in made.declarations + made.definitions


@pytest.mark.long
@pytest.mark.parametrize(
    "scene", [*CHAINS.values(), planar(2, "single", target={"real": "float"}, **ASKED)], ids=lambda s: s.name
)
def test_strict_compilers_have_nothing_to_say(scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "flow.c").write_text(unit(scene)[0])
    done = subprocess.run(
        ["cc", *STRICT, "-O2", "-c", "flow.c"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and not done.stderr, done.stderr[:3000]


def test_single_precision() -> None:
    single = compiled(planar(2, "single", target={"real": "float"}, **ASKED))
    found = single([0.4, 0], [0, 0], 0.0, 0.5, 1e-6, transition=np.eye(4)).transition
    exact = compiled(TWO)([0.4, 0], [0, 0], 0.0, 0.5, 1e-13, transition=np.eye(4)).transition
    assert found is not None and exact is not None
    assert np.max(np.abs(found - exact)) < 2e-5 * np.max(np.abs(exact))


def test_derivatives_that_overflow_are_said() -> None:
    found = compiled(TWO)([0.4, 0], [0, 0], 0.0, 1.0, 1e-12, transition=np.full((4, 1), 1.7e308))
    assert found.outcome == "not finite" and found.t < 1.0


def test_a_scene_without_them_refuses() -> None:
    with pytest.raises(UnsupportedError, match="variational = true"):
        compiled(planar(2))([0, 0], [0, 0], 0.0, 1.0, 1e-9, transition=np.eye(4))


@pytest.mark.parametrize(
    "given", [np.eye(3), np.ones(4), np.ones((4, 0)), np.ones((4, 5)), np.full((4, 1), np.nan)]
)
def test_what_are_no_columns_is_refused(given: Vector) -> None:
    with pytest.raises(ArrayError, match="propagate.transition"):
        compiled(TWO)([0, 0], [0, 0], 0.0, 1.0, 1e-9, transition=given)


def test_a_built_system_carries_them() -> None:
    """Through generation, the cache and the loader; and on a chain whose workspace is too large for the stack."""
    system, alone = build(FIVE), compiled(FIVE)
    q, v = np.linspace(0.4, 0, 5), np.zeros(5)
    built, found = (go(q, v, 0.0, 0.2, 1e-14, transition=np.eye(10)) for go in (system.propagate, alone))
    assert np.max(np.abs(built.transition - found.transition)) < 1e-12 * np.max(np.abs(found.transition))
