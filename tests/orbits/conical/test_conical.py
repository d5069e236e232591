"""Conical families against the conical pendulum, the double spherical pendulum in 40 digits, and conservation laws."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import mpmath
import numpy as np
import pytest

from phichain.continuation import Branch
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits import trace
from phichain.orbits.conical import conical_families, conical_problem, conical_starts
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests import tables
from tests.handmade import uniform_planar
from tests.orbits.conical.double import Double

WANT = ("forward_dynamics", "state_jacobian", "energy", "mass_matrix")
DOUBLE = Double(("1", "0.5"), ("1", "2"), ("1", "1.6"))


@lru_cache
def chain(links: int, **more) -> System:
    own = {"mass": 0.7, "length": 0.5, "com": 0.4, "space": "spatial", "want": WANT}
    return build(Scene(f"conical{links}_{len(more)}", links, **{**own, **more}))


def double(**more) -> System:
    numbers = {name: tuple(map(float, getattr(DOUBLE, name))) for name in ("mass", "length", "com")}
    return chain(2, **numbers, **more)


@pytest.fixture(scope="module")
def families() -> tuple[Branch, ...]:
    return conical_families(double())


def test_one_link_is_the_conical_pendulum() -> None:
    """(m r^2 + J) Omega^2 cos(theta) = m g r; a thin rod beside it swings with s^2 = -Omega^2 (1 + 3 cos^2 theta)."""
    system = chain(1, inertia=0.01)
    branch = trace(system, until="theta_1=1.5", method="conical")
    theta, omega = branch.points.T
    share = 0.7 * 0.4**2 + 0.01
    assert branch.points[-1, 0] == 1.5
    assert omega == pytest.approx(np.sqrt(0.7 * 9.81 * 0.4 / (share * np.cos(theta))), rel=2e-15)
    assert branch.residual.max() < 1e-13
    assert branch.multipliers[:, 0] == pytest.approx(np.cos(2 * np.pi * np.sqrt(1 + 3 * np.cos(theta) ** 2)), abs=1e-12)
    assert branch.energy == pytest.approx(share * (omega * np.sin(theta)) ** 2 / 2 + 0.7 * 9.81 * 0.4 * (1 - np.cos(theta)), rel=1e-13)
    assert branch.momentum == pytest.approx(share * omega * np.sin(theta) ** 2, rel=1e-13)


def test_two_links_turn_as_the_lagrangian_says(families: tuple[Branch, ...]) -> None:
    """Every point, in the amended potential of the Lagrangian from positions."""
    gradient = DOUBLE.pencil[0]
    for branch in families:
        assert branch.residual.max() < 1e-13
        for theta1, theta2, omega in branch.points[::9].tolist():
            left = gradient(theta1, theta2, omega)
            size = abs(omega) ** 2 * 4 + 20
            assert max(abs(float(value)) for value in left) < 1e-13 * size


def test_all_branches_of_the_double_spherical_pendulum_are_there(families: tuple[Branch, ...]) -> None:
    """Whatever the ratio of the sines, the relative equilibrium in closed form lies on one of the families, and each serves some."""
    fastest = max(branch.points[:, -1].max() for branch in families)
    scale = families[0].scale
    served = set()
    ratios = np.concatenate([np.tan(np.linspace(-1.56, 1.56, 301)), [-1e3, 1e3]])
    for a in ratios.tolist():
        with mpmath.workdps(30):
            known = DOUBLE.turning(mpmath.mpf(a))
        if known is None or known[-1] > fastest:
            continue
        there = np.array([float(value) for value in known])
        distance = [min(_distance(branch, there * sign, scale) for sign in ([1, 1, 1], [-1, -1, 1])) for branch in families]
        assert min(distance) < 2e-3, (a, there, distance)
        served.add(int(np.argmin(distance)))
    assert served == set(range(len(families))) and len(families) == 5


def _distance(branch: Branch, point: np.ndarray, scale: np.ndarray) -> float:
    """From a point to the polygon of a branch, angles up to whole turns."""
    steps = branch.points.copy()
    steps[:, :-1] += 2 * np.pi * np.round((point[:-1] - steps[:, :-1]) / (2 * np.pi))
    y, z = steps / scale, point / scale
    edges = np.diff(y, axis=0)
    share = np.clip(np.sum((z - y[:-1]) * edges, axis=1) / np.sum(edges**2, axis=1), 0, 1)
    return float(np.min(np.linalg.norm(y[:-1] + share[:, None] * edges - z, axis=1)))


def test_exponents_are_those_of_the_lagrangian(families: tuple[Branch, ...]) -> None:
    with mpmath.workdps(40):
        for branch in families:
            for k in (len(branch) // 5, len(branch) // 2):
                theta1, theta2, omega = (mpmath.mpf(x) for x in branch.points[k].tolist())
                _, squares = DOUBLE.squares(theta1, theta2, omega)
                turn = 2 * mpmath.pi / omega
                kappa = [complex(mpmath.cosh(mpmath.sqrt(s) * turn)) for s in squares]
                own = list(branch.multipliers[k])
                for value in kappa:
                    nearest = min(own, key=lambda other: abs(other - value))
                    assert abs(nearest - value) < 1e-9 * max(1.0, abs(value))
                    own.remove(nearest)
                assert branch.momentum[k] == pytest.approx(float(DOUBLE.momentum(theta1, theta2, omega)), rel=1e-12)


def test_energy_and_angular_momentum_turn_together(families: tuple[Branch, ...]) -> None:
    """dE = Omega dJ along every family, and both turn at the event that says so."""
    for branch in families:
        middle = (branch.points[1:, -1] + branch.points[:-1, -1]) / 2
        rise = np.diff(branch.energy)
        assert np.diff(branch.momentum) * middle == pytest.approx(rise, rel=2e-2, abs=2e-3 * np.max(np.abs(rise)))
    folded = next(branch for branch in families if branch.located("energy extremum"))
    [event] = folded.located("energy extremum")
    with mpmath.workdps(30):
        a = _root_beside(lambda a: mpmath.diff(lambda b: DOUBLE.momentum(*DOUBLE.turning(b)), a), event.z)
        assert event.z[-1] == pytest.approx(float(DOUBLE.turning(a)[-1]), rel=1e-11)


def test_folds_and_krein_collisions_are_where_the_closed_form_has_them(families: tuple[Branch, ...]) -> None:
    folded = next(branch for branch in families if branch.located("fold omega"))
    [fold] = folded.located("fold omega")
    with mpmath.workdps(30):
        a = _root_beside(lambda a: mpmath.diff(lambda b: DOUBLE.turning(b)[-1], a), fold.z)
        assert fold.z[-1] == pytest.approx(float(DOUBLE.turning(a)[-1]), rel=1e-12)

        def discriminant(a):
            (lead, b, c, d), _ = DOUBLE.squares(*DOUBLE.turning(a))
            return 18 * lead * b * c * d - 4 * b**3 * d + b**2 * c**2 - 4 * lead * c**3 - 27 * lead**2 * d**2

        for branch in families[1:2]:
            for event in branch.located("krein"):
                a = _root_beside(discriminant, event.z)
                assert event.z[-1] == pytest.approx(float(DOUBLE.turning(a)[-1]), rel=1e-9)
    assert families[1].located("krein")


def _root_beside(function, z: np.ndarray):
    """The ratio of sines near that of z at which a function of it vanishes."""
    near = mpmath.sin(mpmath.mpf(float(z[1]))) / mpmath.sin(mpmath.mpf(float(z[0])))
    return mpmath.findroot(function, (near * (1 - mpmath.mpf("1e-6")), near * (1 + mpmath.mpf("1e-6"))))


def test_a_free_cart_goes_round_as_well() -> None:
    """The centre of mass stays on the axis, so that the chain turns as one with c_ij - mu_i mu_j / M; two events mark its stability."""
    system = double(base="cart", cart_mass=0.7)
    branch = trace(system, 2, method="conical", until="omega=9")
    assert branch.names == ("x", "theta_1", "theta_2", "omega") and branch.points[-1, -1] == 9.0
    x, theta, omega = branch.points[:, 0], branch.points[:, 1:3], branch.points[:, -1]
    mu, whole = np.array([1.0 + 0.5, 0.5 * 1.6]), 0.7 + 1.5
    c = np.array([[1.0 + 0.5, 0.8], [0.8, 0.5 * 1.6**2]]) - np.outer(mu, mu) / whole
    assert np.abs(x + np.sin(theta) @ mu / whole).max() < 1e-14
    left = 9.81 * mu * np.sin(theta) - omega[:, None] ** 2 * np.cos(theta) * (np.sin(theta) @ c)
    assert np.abs(left).max() < 1e-12
    assert branch.multipliers.shape == (len(branch), 3)
    assert branch.located("krein")


def test_families_from_infinity_lie_flat_around_the_centre_of_mass() -> None:
    """With link 1 flat the other has c_22 sin(theta_2) = -c_12, in the couplings of a chain whose cart gives way."""
    starts = [start for start in conical_starts(double(base="cart", cart_mass=0.7)) if start.is_flat]
    c12, c22, c11 = 0.8 - 1.5 * 0.8 / 2.2, 1.28 - 0.8**2 / 2.2, 1.5 - 1.5**2 / 2.2
    wanted = [(1.0, 1.0), (1.0, -1.0), *[(1.0, -c12 / c22)] * 2, *[(-c12 / c11, 1.0)] * 2]
    assert len(starts) == len(wanted)
    for start, sines in zip(starts, wanted, strict=True):
        assert np.sin(start.base[1:]) == pytest.approx(sines, abs=0.04)


def test_what_draws_the_links_into_their_plane_is_known() -> None:
    """Across the plane M b'' = (Omega^2 C - Lambda) b with M = C and Lambda_i = g mu_i / cos(theta_i); the turning itself has none."""
    system = double()
    problem = conical_problem(system, omega=3.0)
    z = trace(system, 2, method="conical", until="omega=6").points[-1]
    across = problem.evaluate(z).extra.found.across
    mu, c = np.array([1.5, 0.8]), np.array([[1.5, 0.8], [0.8, 1.28]])
    whole = z[-1] ** 2 * np.eye(2) - np.linalg.solve(c, np.diag(9.81 * mu / np.cos(z[:2])))
    assert -across[0, 0] == pytest.approx(np.trace(whole), rel=1e-12)


def test_springs_hold_the_links_together() -> None:
    branch = trace(double(stiffness=3.0), method="conical", until="omega=4")
    theta, omega = branch.points[:, :2], branch.points[:, -1]
    mu, c = np.array([1.5, 0.8]), np.array([[1.5, 0.8], [0.8, 1.28]])
    bent = 3.0 * np.sin(theta[:, 0] - theta[:, 1])
    springs = np.stack([3.0 * np.sin(theta[:, 0]) + bent, -bent], axis=1)
    left = springs + 9.81 * mu * np.sin(theta) - omega[:, None] ** 2 * np.cos(theta) * (np.sin(theta) @ c)
    assert np.abs(left).max() < 1e-12


def test_a_start_is_a_state_that_turns_as_if_it_were_stiff(families: tuple[Branch, ...]) -> None:
    """q_k' = omega_k x q_k = Omega e_3 x q_k, and omega_k' = Omega e_3 x omega_k by the forward dynamics."""
    branch = families[3]
    q, v = np.split(branch.states[20], 2)
    omega = branch.points[20, -1]
    links, rates = q.reshape(-1, 3), v.reshape(-1, 3)
    axis = np.array([0.0, 0.0, omega])
    assert np.cross(rates, links) == pytest.approx(np.cross(axis, links), abs=1e-14)
    assert double().forward_dynamics(q, v).reshape(-1, 3) == pytest.approx(np.cross(axis, rates), abs=1e-12)


def test_files_hold_the_whole_family(families: tuple[Branch, ...], tmp_path: Path) -> None:
    branch = next(branch for branch in families if branch.located("fold omega"))
    text = branch.to_json(tmp_path / "a.json").read_text()
    for read in (Branch.from_json(tmp_path / "a.json"), Branch.from_npz(branch.to_npz(tmp_path / "a.npz"))):
        assert read.to_json(tmp_path / "b.json").read_text() == text
    head = tables.lines(branch.to_csv(tmp_path / "a.csv"))[0]
    assert head.startswith("arclength,theta_1,theta_2,omega,energy,momentum")


def test_a_run_goes_on_bit_by_bit(families: tuple[Branch, ...], tmp_path: Path) -> None:
    part = trace(double(), method="conical", limits={"max_points": 7})
    assert part.status == "points"
    whole = trace(double(), method="conical", resume=part.to_json(tmp_path / "part.json"))
    assert np.array_equal(whole.points, families[0].points) and np.array_equal(whole.momentum, families[0].momentum)


def test_beginnings_are_the_linear_modes_first() -> None:
    starts = conical_starts(double())
    hanging = np.array([[1.5, 0.8], [0.8, 1.28]])
    squares = np.linalg.eigvals(np.linalg.solve(hanging, np.diag([9.81 * 1.5, 9.81 * 0.8])))
    assert [start.omega for start in starts[:2]] == pytest.approx(np.sqrt(np.sort(squares)), rel=1e-13)
    assert [start.where for start in starts] == [
        "hanging", "hanging", "links 1 standing", "links 2 standing", *["from infinity"] * 6,
    ]  # fmt: skip


def test_what_has_no_conical_families_is_refused() -> None:
    with pytest.raises(UnsupportedError, match="about the vertical"):
        trace(uniform_planar(2), method="conical")
    with pytest.raises(UnsupportedError, match="come to rest"):
        trace(chain(1, damping=0.1), method="conical")
    with pytest.raises(UnsupportedError, match="lacks the functions energy, mass_matrix"):
        trace(chain(1, want=("forward_dynamics", "state_jacobian")), method="conical")
    with pytest.raises(ArrayError, match="1 .. 10"):
        trace(double(), 11, method="conical")
    with pytest.raises(UnsupportedError, match='method = "conical"'):
        trace(double(), method="shooting")
