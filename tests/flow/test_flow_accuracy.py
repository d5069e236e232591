"""The compiled Taylor flow against closed forms, 50-digit references and invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.ir.evaluate import evaluate
from phichain.lowering.lower import lower_function
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.flow.extreme_cases import CASES, EPS, TURN, of_case, start
from tests.flow.flows import compiled, planar, scene


def energy(chain: Scene, q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    found = evaluate(lower_function(derive(chain), "energy", "loops"), {"q": q, "v": v})
    return found["kinetic"] + found["potential"]


@pytest.mark.parametrize("name", ["B01", "B04", "B07"])
def test_planar_reference_cases(name: str) -> None:
    """Near the separatrix, over 1000 periods against elliptic functions, and a regular motion over 1000 s."""
    case = CASES[name]
    q, v = start(case)
    times = [float(t) for t in case["times"]]
    found = compiled(of_case(case))(q, v, 0.0, times[-1], 1e-15, times=times)
    kappa = case["kappa_initial_state"]
    sensitivity = 0.0
    for at, rate, (key, reference) in zip(found.q_at, found.v_at, case["reference"].items(), strict=True):
        expected = np.array(reference, dtype=float)
        scale = float(np.max(np.abs(expected)))
        sensitivity = max(sensitivity, kappa[key])
        error = float(np.max(np.abs(np.append(at, rate) - expected)))
        # B01 stands still for seconds just beside its separatrix, where an angle near pi holds 4e-16: over tolerances from
        # 2e-16 to 1e-15 its error at 15 s spreads from 1e-7 to 5e-5, whatever the step lengths are.
        assert error <= 300 * EPS * (20 + sensitivity) * scale, key
    if name == "B01":
        assert found.q[0] < -3.0, "the wrong side of the separatrix"


def test_a_thousand_periods_of_a_pendulum_keep_its_phase() -> None:
    case = CASES["B04"]
    found = compiled(of_case(case))([2.0], [0.0], 0.0, float(case["times"][1]), 1e-15)
    assert abs(found.v[0] - float(case["reference"]["2665.8709428349257"][1])) < 1e-10


@pytest.mark.parametrize("name", ["B14", "B16"])
def test_unit_vectors_through_both_poles_and_whirling(name: str) -> None:
    case = CASES[name]
    chain, (q, v) = of_case(case), start(case)
    times = [float(t) for t in case["times"]]
    found = compiled(chain)(q, v, 0.0, times[-1], 1e-15, u=[0, 0], times=times)
    for at, rate, reference in zip(found.q_at, found.v_at, case["reference"].values(), strict=True):
        expected = np.array(reference, dtype=float)
        parts = np.array([at[2:], rate[2:]]).reshape(2, -1, 3) * TURN
        mine = np.concatenate([parts[0].ravel(), parts[1].ravel(), TURN[:2] * at[:2], TURN[:2] * rate[:2]])
        other = np.concatenate([parts.transpose(1, 0, 2).ravel(), mine[-4:]])
        error = min(np.max(np.abs(mine - expected)), np.max(np.abs(other - expected)))
        assert error <= 1e-12 * max(1.0, float(np.max(np.abs(expected))))


def test_a_chain_released_from_the_horizontal_misleads_no_tolerance() -> None:
    """64 links at rest: the leading coefficients of all outer links vanish. Energy, and one answer for all tolerances."""
    chain = scene("horizontal", "planar", "fixed", links=64, mass=1 / 64, length=1 / 64)
    q = np.zeros(64)
    q[0] = math.pi / 2
    ends = [compiled(chain)(q, np.zeros(64), 0.0, 0.5, tol) for tol in (1e-6, 1e-9, 1e-15)]
    angles = [np.cumsum(end.q) for end in ends]
    assert np.max(np.abs(angles[0] - angles[2])) < 1e-5
    assert np.max(np.abs(angles[1] - angles[2])) < 1e-8
    assert abs(energy(chain, ends[2].q, ends[2].v) - energy(chain, q, np.zeros(64))) < 1e-12


def test_energy_does_not_drift() -> None:
    """N = 2 at 0.4 rad, tolerance at round-off, 1e4 s: a random walk of rounding errors at most."""
    chain = planar(2)
    found = compiled(chain)([0.4, 0], [0, 0], 0.0, 1e4, 1e-15, times=[100.0, 1e4])
    rest = energy(chain, np.zeros(2), np.zeros(2))
    first = energy(chain, np.array([0.4, 0]), np.zeros(2)) - rest
    drift = np.abs(energy(chain, found.q_at, found.v_at) - rest - first) / first
    assert drift[1] < 1e-13


PAPER_B = scene("paper_b", "spatial", "cart", links=5, mass=0.1, length=0.1, cart_mass=0.5)


def test_paper_b_keeps_energy_and_length() -> None:
    """Paper B's Fig. 2, (23): E = 0.299285058894842 J, links stay in their plane, the cart leaves it at -0.1 m/s."""
    lean = math.radians(1.0)
    links = [[0, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, 1], [math.sin(lean), 0, -math.cos(lean)]]
    x, y = np.append([0.2, 0.1], links), np.append([0.0, -0.1], np.zeros(15))
    found = compiled(PAPER_B)(x, y, 0.0, 10.0, 1e-12, u=[0, 0], times=np.linspace(0.5, 10, 20))
    before = energy(PAPER_B, x, y)
    assert abs(before - 0.299285058894842) < 1e-15
    assert np.max(np.abs(energy(PAPER_B, found.q_at, found.v_at) / before - 1)) < 1e-13
    assert np.max(np.abs(np.linalg.norm(found.q_at[:, 2:].reshape(-1, 5, 3), axis=2) - 1)) < 1e-14
    assert not found.q_at[:, 3::3].any() and np.all(found.v_at[:, 1] == -0.1)
    assert np.max(np.abs(found.q_at[:, 1] - (0.1 - 0.1 * np.linspace(0.5, 10, 20)))) < 1e-14


def test_a_tumbling_chain_keeps_energy_and_length() -> None:
    random = np.random.default_rng(2)
    q = random.normal(size=(5, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    w = np.cross(q, random.normal(size=(5, 3)))
    x, y = np.append([0.0, 0.0], q), np.append([0.1, 0.0], w)
    found = compiled(PAPER_B)(x, y, 0.0, 10.0, 1e-12, u=[0, 0], times=np.linspace(0.5, 10, 20))
    hanging = energy(PAPER_B, np.array([0.0, 0, *[0, 0, 1] * 5]), np.zeros(17))
    before = energy(PAPER_B, x, y)
    drift = energy(PAPER_B, found.q_at, found.v_at) - before
    assert np.max(np.abs(drift)) < 1e-13 * (before - hanging)
    assert np.max(np.abs(np.linalg.norm(found.q_at[:, 2:].reshape(-1, 5, 3), axis=2) - 1)) < 1e-14
