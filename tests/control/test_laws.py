"""Laws: records of controllers against the regulator's own law, at 50 digits, as compiled C, in closed loop, and on file."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain.control import Gains, feedback, lqr
from phichain.errors import ArrayError, ControlError, OutputError
from phichain.ir import evaluate, evaluate_exactly, total_operations
from phichain.laws import StateFeedback
from phichain.lowering.laws import controller, full_turn
from phichain.motion import simulate
from phichain.system import System
from tests.handmade import paper_b, planar, spatial
from tests.one_program import c_text, compiled

CHAINS = {
    "cart": lambda: planar([0.3, 0.2], [0.4, 0.3], cart_mass=0.7, actuated="cart"),
    "all": lambda: planar([0.3, 0.2], [0.4, 0.3], cart_mass=0.7, actuated="all", angles="absolute"),
    "fixed": lambda: planar([0.3, 0.2], [0.4, 0.3], actuated="all"),
    "space": lambda: spatial([0.2, 0.1], [0.3, 0.4], cart_mass=0.5),
}
PLACE = {"cart": [0.25], "all": [-0.5], "fixed": [], "space": [0.1, -0.2]}


def made(kind: str, s: list[int] | None = None, **more: Any) -> tuple[System, Gains, StateFeedback]:
    system = CHAINS[kind]()
    gains = lqr(system, s)
    return system, gains, gains.law(PLACE[kind], **more)


def states(system: System, count: int, seed: int = 1) -> np.ndarray:
    """States all over, many turns from the target in the plane, on the spheres in space."""
    draw = np.random.default_rng(seed)
    q, v = 4 * draw.normal(size=(count, system.nq)), draw.normal(size=(count, system.nv))
    if system.is_planar:
        q[:, system.cart_size :] *= 5
    else:
        unit = draw.normal(size=(count, system.links, 3))
        unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
        q[:, system.cart_size :] = unit.reshape(count, -1)
        rates = draw.normal(size=unit.shape)
        v[:, system.cart_size :] = (rates - np.sum(rates * unit, axis=-1, keepdims=True) * unit).reshape(count, -1)
    return np.concatenate([q, v], axis=1)


def exactly(law: StateFeedback, x: np.ndarray) -> list[Any]:
    """The law's formula in mpmath, angles turned back by rounding to the nearest turn; call within workdps."""
    away = [mp.mpf(float(a)) - mp.mpf(b) for a, b in zip(x, law.target, strict=True)]
    turned = [d - 2 * mp.pi * mp.nint(d / (2 * mp.pi)) if turns else d for d, turns in zip(away, law.wraps, strict=True)]
    found = []
    for row, rest, low, high in zip(law.gains, law.rest, law.low, law.high, strict=True):
        u = mp.mpf(rest) - mp.fdot([mp.mpf(k) for k in row], turned)
        found.append(min(max(u, mp.mpf(low)), mp.mpf(high)))
    return found


@pytest.mark.parametrize("s", [None, [1, -1], [1, 1]])
@pytest.mark.parametrize("kind", CHAINS)
def test_the_record_is_the_regulators_law(kind: str, s: list[int] | None) -> None:
    """Two routes: `feedback` forms z of (19), in space by cross products; the record multiplies the measured state."""
    system, gains, law = made(kind, s)
    wanted = feedback(system, gains, PLACE[kind])
    for x in states(system, 40):
        expected = wanted(0.0, x)
        assert np.allclose(law(0.0, x), expected, rtol=1e-11, atol=1e-11 * np.max(np.abs(gains.K)))
    at_rest = np.concatenate([gains.equilibrium, np.zeros(system.nv)])
    at_rest[: system.cart_size] = PLACE[kind]
    assert np.all(law(0.0, at_rest) == 0)
    assert law.state_names[: system.nq] == system.q_names and law.input_names == system.u_names
    assert len(law.state_units) == system.nx and law.input_units[0] == ("N m" if kind == "fixed" else "N")


@pytest.mark.parametrize("limit", [None, 0.5])
@pytest.mark.parametrize("kind", CHAINS)
def test_the_program_is_the_formula_at_fifty_digits(kind: str, limit: float | None) -> None:
    system, _gains, law = made(kind, limit=limit, u_0=[0.125] * CHAINS[kind]().nu)
    program = controller(law)
    assert [array.name for array in program.inputs] == ["x_meas"] and [array.name for array in program.outputs] == ["u"]
    limited = 0
    for x in [*states(system, 12), 0.01 * states(system, 1)[0] + law.target]:
        with mp.workdps(60):
            expected = exactly(law, x)
            found = evaluate_exactly(program, {"x_meas": x}, digits=60)["u"]
            assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < mp.mpf(10) ** -45
        assert np.allclose(evaluate(program, {"x_meas": x})["u"], [float(u) for u in expected], rtol=0, atol=scale(law, x))
        limited += sum(abs(u) == limit for u in expected)
    assert (limited > 5) == (limit is not None)


def scale(law: StateFeedback, x: np.ndarray) -> float:
    """Rounding errors of the sum: 1e-15 of its terms, angles at the size that they are read off at."""
    return 4e-15 * float(np.max(np.abs(np.array(law.gains)) @ (np.abs(x) + np.abs(law.target) + 1)))


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("kind", CHAINS)
def test_the_emitted_c_is_the_formula(kind: str, real: str, tmp_path) -> None:
    system, _gains, law = made(kind, limit=5.0)
    call = compiled(controller(law), tmp_path, real)
    coarse = 2.0**29 if real == "float" else 1.0
    for x in states(system, 20, seed=7):
        read = x.astype(np.float32).astype(float) if real == "float" else x
        with mp.workdps(50):
            expected = [float(u) for u in exactly(law, read)]
        assert np.allclose(call(read)["u"], expected, rtol=0, atol=coarse * scale(law, read))
        assert np.max(np.abs(call(read)["u"])) <= 5.0
    broken = np.array(law.target)
    broken[0] = np.nan
    reads = np.array(law.gains)[:, 0] != 0  # in space each force reads the positions of its own plane
    assert reads.any() and np.array_equal(np.isnan(call(broken)["u"]), reads)
    text = c_text(controller(law), real)
    assert "theta_1_away" in text or kind == "space"
    assert "static" not in text


def test_what_is_zero_costs_nothing() -> None:
    """Five spatial links on a cart: two inputs, 12 tilts and places, 12 rates, nothing for the vertical components."""
    gains = lqr(paper_b())
    law = gains.law()
    operations = total_operations(controller(law))
    used = np.count_nonzero(law.gains)
    assert used == np.count_nonzero(gains.K)
    # A product and a sum each; the targets of what is used are zero but for nothing.
    assert operations <= 2 * used
    assert total_operations(controller(gains.law(limit=3.0))) == operations + 4
    # Within the 60 multiply-adds, and nothing kept on the stack, that a Cortex-M4F is to need for (22).
    assert used <= 60 and not controller(law).work


def test_an_angle_many_turns_away_is_where_it_looks() -> None:
    _system, gains, law = made("cart")
    x = np.array(law.target) + 0.01
    turned = x.copy()
    turned[1:3] += 2 * np.pi * np.array([3, -2])
    assert np.allclose(law(0.0, turned), law(0.0, x), rtol=1e-12)
    plain = gains.law(PLACE["cart"], wrap=False)
    assert not any(plain.wraps)
    assert np.allclose(plain(0.0, turned), -(gains.K @ (turned - law.target)), rtol=1e-13)
    with mp.workdps(60):
        assert abs(mp.mpf(full_turn().numerator) / full_turn().denominator - 2 * mp.pi) < mp.mpf(10) ** -58


@pytest.mark.parametrize("kind", ["cart", "space"])
def test_the_compiled_law_holds_the_chain_upright_within_its_limits(kind: str, tmp_path) -> None:
    system, _gains, law = made(kind, limit=20.0)
    call = compiled(controller(law), tmp_path)
    start = np.array(law.target)
    start[: system.cart_size] += 0.05
    if system.is_planar:
        start[system.cart_size] += 0.02 + 4 * np.pi
    motion = simulate(system, start, np.linspace(0, 6, 61), u=lambda t, x: call(x)["u"], tol=1e-8)
    away = motion.x[-1] - law.target
    away[np.array(law.wraps)] = (away[np.array(law.wraps)] + np.pi) % (2 * np.pi) - np.pi
    assert np.max(np.abs(away)) < 2e-2 * np.max(np.abs(motion.x[0] - law.target)) + 1e-3
    same = simulate(system, start, np.linspace(0, 6, 61), u=law, tol=1e-8)
    assert np.allclose(same.x, motion.x, rtol=0, atol=1e-6)


def test_laws_and_gains_say_which_scene_they_belong_to(tmp_path) -> None:
    system = replace(CHAINS["cart"](), digest="d" * 64)
    gains = lqr(system)
    law = gains.law()
    assert gains.digest == law.digest == "d" * 64 and law.name == system.name
    assert Gains.from_npz(gains.to_npz(tmp_path / "gains.npz")).digest == gains.digest


def test_a_law_on_file_is_the_same_record(tmp_path) -> None:
    for kind in CHAINS:
        for more in ({}, {"limit": 2.5}):
            _, _, law = made(kind, **more)
            assert StateFeedback.from_npz(law.to_npz(tmp_path / "law.npz")) == law
            assert pickle.loads(pickle.dumps(law)) == law
            assert controller(StateFeedback.from_npz(tmp_path / "law.npz")) == controller(law)
    with pytest.raises(FrozenInstanceError):
        law.target = ()  # type: ignore[misc]
    assert "state feedback from 16 measured" in str(law) and "2 limited" in str(law)


def test_files_that_hold_no_law_are_refused(tmp_path) -> None:
    _, gains, law = made("cart")
    with pytest.raises(OutputError, match="holds a Gains, not a StateFeedback"):
        StateFeedback.from_npz(gains.to_npz(tmp_path / "gains.npz"))
    path = law.to_npz(tmp_path / "law.npz")
    with np.load(path) as archive:
        held = {name: archive[name] for name in archive.files}
    for name, change, words in (
        ("gains", None, "gains: is missing"),
        ("gains", np.ones((3, 3)), "gains: has another shape"),
        ("target", np.full(6, np.nan), "no StateFeedback can be read there"),
    ):
        altered = {key: value for key, value in held.items() if key != name or change is not None}
        altered |= {} if change is None else {name: change}
        np.savez(tmp_path / "altered.npz", **altered)
        with pytest.raises(OutputError, match=words):
            StateFeedback.from_npz(tmp_path / "altered.npz")


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"target": [0.0, 1.0]}, ArrayError, "target: must hold 1 position"),
        ({"target": ["far"]}, ControlError, "target: does not hold real numbers"),
        ({"limit": [1.0, 2.0]}, ArrayError, "limit: must be one number or hold 1"),
        ({"limit": 0.0}, ArrayError, "limit: is not positive"),
        ({"limit": -3.0}, ArrayError, "limit: is not positive"),
        ({"limit": np.nan}, ArrayError, "limit: is not positive"),
        ({"u_0": [1.0, 2.0]}, ArrayError, "law.rest: must hold finite numbers"),
        ({"u_0": [np.inf]}, ArrayError, "law.rest: must hold finite numbers"),
        ({"target": [np.nan]}, ArrayError, "law.target: must hold finite numbers"),
    ],
)
def test_laws_that_do_not_fit_are_refused(arguments, error, words) -> None:
    gains = lqr(CHAINS["cart"]())
    with pytest.raises(error, match=words):
        gains.law(**arguments)


def test_records_that_do_not_fit_are_refused() -> None:
    _, _, law = made("cart")
    for field, value, words in (
        ("wraps", (True,), "law.wraps: must hold 6 entries"),
        ("state_units", ("m",), "law.state_units: must hold 6 entries"),
        ("gains", ((1.0,),), "law.gains: must hold finite numbers of shape"),
    ):
        with pytest.raises(ArrayError, match=words):
            replace(law, **{field: value})
