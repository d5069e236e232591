"""Signal propagation along simulated motions: both ends of both surfaces, the paths, and what is refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.errors import ArrayError, PhichainError, SignalError, UnsupportedError
from phichain.fractional import PATHS, Propagation, propagation
from phichain.system import AbsentFunctionError, System
from tests import tables
from tests.fractional.chains import chain
from tests.handmade import GRAVITY

ALPHA, P = np.linspace(-2.0, 0.0, 9), np.linspace(0.0, 1.0, 5)


@dataclass(frozen=True)
class Recorded:
    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    u: np.ndarray | None = None


def motion_of(system: System, q0: Any, v0: Any = None, end: float = 1.0, count: int = 1001) -> Recorded:
    """A motion with smooth inputs by SciPy at round-off tolerance."""
    t = np.linspace(0.0, end, count)
    start = np.concatenate([q0, np.zeros(system.nv) if v0 is None else v0])

    def inputs(time: Any) -> np.ndarray:
        return np.stack([0.3 * np.sin((k + 1.5) * time + k) for k in range(system.nu)], axis=-1)

    def field(time: float, x: np.ndarray) -> np.ndarray:
        q, v = x[: system.nq], x[system.nq :]
        given = (inputs(time),) if system.nu else ()
        return np.concatenate([v, system.forward_dynamics(q, v, *given)])

    x = solve_ivp(field, (0.0, end), start, "DOP853", t, rtol=3e-14, atol=1e-14).y.T
    return Recorded(t, x[:, : system.nq], x[:, system.nq :], inputs(t) if system.nu else None)


SYSTEMS = {
    "paper A, two links": (chain([0.5] * 2, [0.5] * 2, [0.25] * 2), [0.2, -0.1]),
    "three links, adjacent": (
        chain([1 / 3] * 3, [1 / 3] * 3, [1 / 6] * 3, angles="adjacent"),
        [0.1, 0.05, -0.1],
    ),
    "driven": (chain([1, 2], [1, 0.5], [0.5, 0.4], actuated="all"), [0.2, 0.1]),
    "one driven joint": (chain([1, 2], [1, 0.5], actuated=[2]), [0.2, 0.1]),
    "cart with springs": (
        chain([1, 2], [1, 0.5], cart_mass=0.7, stiffness=[2, 1], damping=[0.1, 0.2], actuated="cart"),
        [0.1, 0.2, -0.1],
    ),
}


@pytest.fixture(scope="module", params=SYSTEMS)
def case(request: pytest.FixtureRequest) -> tuple[System, Recorded]:
    system, q0 = SYSTEMS[request.param]
    return system, motion_of(system, q0, np.linspace(0.2, -0.2, system.nv))


def test_surfaces_run_from_the_forces_to_the_coordinates(case: tuple[System, Recorded]) -> None:
    system, motion = case
    result = propagation(system, motion, P, ALPHA, paths=("total",), order=6)
    inputs = () if motion.u is None else (motion.u,)
    accelerations = system.forward_dynamics(motion.q, motion.v, *inputs)
    theta_p, psi = result.theta_p["total"], result.psi["total"]
    assert theta_p.shape == (1001, 5, system.nv) and psi.shape == (1001, 9, system.nv)
    assert np.array_equal(theta_p[:, 0], result.forces["total"])
    assert np.allclose(theta_p[:, -1], accelerations, rtol=1e-11, atol=1e-11)
    assert np.array_equal(psi[:, -1], theta_p[:, -1])
    admitted = 2e-8 * np.max(np.abs(accelerations))
    assert np.max(np.abs(psi[1:, 4] - motion.v[1:])) < admitted
    assert np.max(np.abs(psi[:, 0] - motion.q)) < admitted
    assert np.all(np.isnan(psi[0, 1:-1])) and np.all(np.isfinite(psi[1:]))
    assert np.array_equal(result.surface("psi", 0), psi[:, :, 0], equal_nan=True)


def test_forces_are_what_the_mass_matrix_needs(case: tuple[System, Recorded]) -> None:
    system, motion = case
    result = propagation(system, motion, [0.0], [0.0], paths=PATHS)
    inputs = () if motion.u is None else (motion.u,)
    accelerations = system.forward_dynamics(motion.q, motion.v, *inputs)
    needed = np.einsum("sij,sj->si", system.mass_matrix(motion.q), accelerations)
    assert np.allclose(result.forces["total"], needed, rtol=0, atol=1e-11 * np.abs(needed).max())
    assert np.allclose(result.forces["feedback"], result.forces["coriolis"] + result.forces["gravity"])
    assert np.array_equal(result.forces["gravity"], -system.gravity_torque(motion.q))


def test_parts_add_up_to_the_total(case: tuple[System, Recorded]) -> None:
    system, motion = case
    result = propagation(system, motion, P, ALPHA, paths=PATHS, initial=False)
    for surfaces in (result.theta_p, result.psi):
        parts = sum(surfaces[path] for path in ("coriolis", "gravity", "input", "joints"))
        assert np.allclose(parts, surfaces["total"], rtol=0, atol=1e-10 * np.abs(surfaces["total"]).max())
        joined = surfaces["coriolis"] + surfaces["gravity"]
        assert np.allclose(joined, surfaces["feedback"], rtol=0, atol=1e-10 * np.abs(joined).max())


def test_accelerations_from_the_spectrum_serve_without_forward_dynamics(
    case: tuple[System, Recorded],
) -> None:
    system, motion = case
    kept = {name: f for name, f in system.functions.items() if name != "forward_dynamics"}
    bare = System(**{**system.__dict__, "functions": kept})
    with_dynamics, without = (propagation(s, motion, P, ALPHA, paths=PATHS) for s in (system, bare))
    for path in PATHS:
        scale = np.abs(with_dynamics.theta_p["total"]).max()
        assert np.allclose(with_dynamics.theta_p[path], without.theta_p[path], rtol=0, atol=1e-11 * scale)
        assert np.allclose(
            with_dynamics.psi[path], without.psi[path], rtol=0, atol=1e-10 * scale, equal_nan=True
        )


def test_one_link_has_a_closed_form() -> None:
    # I = m r^2: theta_p = -(m r^2)^-p m g r sin theta.
    system = chain([2.0], [1.5], [0.8])
    motion = motion_of(system, [0.9])
    result = propagation(system, motion, P, [-1.0, 0.0])
    torque = -2.0 * GRAVITY * 0.8 * np.sin(motion.q[:, 0])
    for k, p in enumerate(P):
        assert np.allclose(result.theta_p["gravity"][:, k, 0], torque * (2.0 * 0.64) ** -p, rtol=1e-13)
    assert np.all(result.theta_p["coriolis"] == 0.0)


def test_without_initial_terms_the_second_integral_misses_the_start() -> None:
    system, q0 = SYSTEMS["paper A, two links"]
    motion = motion_of(system, q0)
    bare = propagation(system, motion, [1.0], [-2.0], initial=False, order=6).psi["total"][:, 0]
    assert np.max(np.abs(bare + motion.q[0] - motion.q)) < 1e-8
    assert "without initial terms" in str(propagation(system, motion, [1.0], [-2.0], initial=False))


def test_record_leaves_memory_whole(tmp_path: Path) -> None:
    system, q0 = SYSTEMS["paper A, two links"]
    result = propagation(system, motion_of(system, q0, count=41), P, ALPHA)
    result.to_npz(tmp_path / "p.npz")
    back = Propagation.from_npz(tmp_path / "p.npz")
    for mine, its in ((result.forces, back.forces), (result.theta_p, back.theta_p), (result.psi, back.psi)):
        assert list(mine) == list(its)
        assert all(np.array_equal(mine[path], its[path], equal_nan=True) for path in mine)
    assert (back.coordinates, back.initial, back.order, back.name) == (result.coordinates, True, result.order, result.name)
    assert all(np.array_equal(getattr(back, name), getattr(result, name)) for name in ("time", "p", "alpha"))
    result.to_csv(tmp_path / "p.csv", "theta_p", 1, "gravity")
    lines = tables.lines(tmp_path / "p.csv")
    assert lines[0].split(",")[:2] == ["t", "p=0.0"] and len(lines) == 42
    assert float(lines[1].split(",")[-1]) == result.theta_p["gravity"][0, -1, 1]


def test_what_has_no_fractional_view_is_refused() -> None:
    spatial = System("s", "spatial", "fixed", 1, 3, 3, 0)
    still = Recorded(np.linspace(0, 1, 20), np.zeros((20, 3)), np.zeros((20, 3)))
    with pytest.raises(UnsupportedError, match="second integral is not q"):
        propagation(spatial, still, P, ALPHA)
    system = chain([1.0], [1.0])
    bare = System(**{**system.__dict__, "functions": {}})
    with pytest.raises(AbsentFunctionError, match="coriolis"):
        propagation(bare, Recorded(still.t, np.zeros((20, 1)), np.zeros((20, 1))), P, ALPHA)


@pytest.mark.parametrize(
    ("change", "options", "error", "words"),
    [
        ({"t": np.linspace(0, 1, 20) ** 2}, {}, SignalError, "resample"),
        ({"q": np.full((20, 2), np.nan)}, {}, SignalError, "not finite"),
        ({"q": np.zeros((20, 3))}, {}, ArrayError, r"\(states, 2\)"),
        ({"u": None}, {}, ArrayError, "no inputs"),
        ({}, {"alpha": [0.5]}, SignalError, r"\[-2, 0\]"),
        ({}, {"paths": ("friction",)}, SignalError, "no such path"),
        ({}, {"order": 0}, SignalError, "no such quadrature"),
    ],
)
def test_bad_input_is_one_clear_error(
    change: dict, options: dict, error: type[PhichainError], words: str
) -> None:
    system = chain([1, 2], [1, 0.5], actuated="all")
    fields = {
        "t": np.linspace(0, 1, 20),
        "q": np.zeros((20, 2)),
        "v": np.zeros((20, 2)),
        "u": np.zeros((20, 2)),
    }
    with pytest.raises(error, match=words):
        propagation(system, Recorded(**{**fields, **change}), P, options.pop("alpha", ALPHA), **options)
    with pytest.raises(SignalError, match="was not computed"):
        propagation(system, Recorded(**fields), P, ALPHA).surface("psi", 0, "input")
