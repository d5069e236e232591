"""Many harmonics against elliptic integrals, quadrature of handmade dynamics, reference orbits and shooting."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.special import ellipkm1

from phichain.continuation import Engine, Options, start_on
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits import linear_modes, trace
from phichain.orbits.harmonics.balance import balanced, inverse_of
from phichain.orbits.harmonics.basis import KINDS, basis
from phichain.orbits.harmonics.condensed import Harmonics, condensed_problem
from phichain.orbits.harmonics.family import NEEDED
from phichain.orbits.harmonics.judge import Judge
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests.handmade import planar, uniform_planar

CYCLES = json.loads((Path(__file__).parents[2] / "data" / "limit_cycles.json").read_text())["points"]
WANT = (*NEEDED, "propagate", "mass_matrix", "energy")


@lru_cache
def summed(links: int, *, shoots: bool = True, **more: Any) -> System:
    """Paper A's chain of N links without torques, with what harmonics are balanced by."""
    own = {"mass": 1 / links, "length": 1 / links, "com": 0.5 / links, "actuated": "none"}
    want = {"want": WANT, "variational": True} if shoots else {"want": (*NEEDED, "energy")}
    return build(Scene(f"summed{links}", links, **{**own, **want, **more}))


@pytest.mark.parametrize("kind", KINDS)
def test_the_balance_is_the_projection_of_handmade_dynamics(kind) -> None:
    """R = <c_m, M (a - f)> by quadrature with four times the samples, on a cart with springs; its derivatives are its differences."""
    numbers = {"mass": [0.3, 0.5], "length": [0.4, 0.3], "stiffness": [1.0, 0.5], "cart_mass": 0.7}
    system = build(Scene("balanced", 2, base="cart", actuated="none", want=NEEDED, **numbers))
    judge, table = planar(**numbers), basis(kind, 5)
    rng = np.random.default_rng(3)
    series, omega = 0.5 * rng.normal(size=(table.size, 3)) * 0.1 ** table.order[:, None], 2.7
    inverse = inverse_of(system)
    found = balanced(inverse, table, series, omega)
    phase = 2 * np.pi * np.arange(256) / 256
    value, slope, bend = table.at(phase)
    force = np.array([
        judge.mass_matrix(q) @ (a - judge.forward_dynamics(q, v))
        for q, v, a in zip(value @ series, omega * slope @ series, omega**2 * bend @ series, strict=True)
    ])  # fmt: skip
    weight = np.where(table.order == 0, 1.0, 2.0)[:, None]
    # What five harmonics of three unknowns fold back of their products is small, and nothing else is left out.
    assert found.residual == pytest.approx(weight * (value.T @ force) / 256, abs=2e-5)
    step = 1e-5
    for m, i in ((0, 0), (1, 2), (table.size - 1, 1)):
        moved = np.zeros_like(series)
        moved[m, i] = step
        ahead, behind = (balanced(inverse, table, series + sign * moved, omega).residual for sign in (1, -1))
        assert found.jacobian[:, :, m, i] == pytest.approx((ahead - behind) / (2 * step), abs=2e-8)
    ahead, behind = (balanced(inverse, table, series, omega + sign * step).residual for sign in (1, -1))
    assert found.by_omega == pytest.approx((ahead - behind) / (2 * step), abs=2e-8)


def test_one_link_is_the_elliptic_integral_up_to_3_1_rad() -> None:
    """omega = pi omega_0 / (2 K(sin(A/2))) in 40 digits, and the spectrum gets longer on the way."""
    system = summed(1, shoots=False)
    branch = trace(system, method="harmonics", until="theta_1=3.1")
    assert branch.method == "harmonics" and branch.points[-1, 0] == 3.1 and branch.multipliers.shape == (len(branch), 0)
    with mpmath.workdps(40):
        exact = [
            mpmath.pi * mpmath.sqrt(mpmath.mpf(9.81) / 0.5) / (2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(a) / 2) ** 2))
            for a in branch.points[:, 0].tolist()
        ]
        off = np.array([float(abs(mpmath.mpf(w) / e - 1)) for w, e in zip(branch.points[:, 1].tolist(), exact, strict=True)])
    assert np.max(off) < 2e-13 and np.max(branch.error) <= 1e-12
    modes = linear_modes(system)
    problem = condensed_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])
    lengths = [len(problem.evaluate(z).extra.found.coefficients) * 2 - 1 for z in branch.points]
    assert lengths[0] == 7 and lengths[-1] > 60 and lengths == sorted(lengths)


def test_the_error_is_the_tail_and_holds() -> None:
    """With nine harmonics and a loose tail the frequency is off by no more than what the branch says of itself."""
    loose = Harmonics(tail=1e-2, most=9, least=9)
    branch = trace(summed(1, shoots=False), method="harmonics", until="theta_1=2.6", harmonics=loose)
    amplitude, omega = branch.points.T
    exact = [float(mpmath.pi * mpmath.sqrt(9.81 / 0.5) / (2 * mpmath.ellipk(mpmath.sin(a / 2) ** 2))) for a in amplitude]
    off = np.abs(omega / exact - 1)
    large = amplitude > 0.5
    assert np.all(off[large] < branch.error[large]) and off[-1] > 1e-8 and branch.error[-1] < 1e-2


@pytest.mark.long
@pytest.mark.parametrize("cycle", [c for c in CYCLES if c["N"] == 2], ids=lambda c: f"mode{c['mode']}-{c['theta0'][0][:4]}")
def test_reference_orbits_lie_on_their_families(cycle) -> None:
    theta, mode = np.array(cycle["theta0"], float), cycle["mode"]
    branch = trace(summed(2), mode, method="harmonics", until=(f"theta_{mode}", theta[mode - 1]), harmonics=Harmonics(most=47))
    at = branch.points[-1]
    assert at == pytest.approx([*theta, float(cycle["omega"])], abs=1e-11)
    assert branch.energy[-1] == pytest.approx(float(cycle["energy"]), rel=1e-11)


@pytest.mark.long
def test_a_cart_swings_along() -> None:
    """The same point of the same family as shooting, the cart's amplitude among the unknowns."""
    system = summed(1, base="cart", mass=0.7, length=0.6, com=None, cart_mass=1.3)
    series, shot = (trace(system, method=method, until="theta_1=1.2") for method in ("harmonics", "shooting"))
    assert series.names == ("x", "theta_1", "omega")
    assert series.points[-1] == pytest.approx(shot.points[-1], abs=1e-12)


def test_long_series_are_handed_to_shooting() -> None:
    """N = 2 to theta_1 = -2.5 would need some 450 harmonics: 23 serve the start, and no point is left unresolved."""
    short = Harmonics(most=23)
    branch = trace(summed(2), method="harmonics", until="theta_1=-2.5", harmonics=short)
    assert "the harmonics up to 23 leave a tail above 1e-12: from s = " in branch.reason and branch.status == "event"
    assert branch.points[-1] == pytest.approx([-2.5, 0.746387775, 2 * np.pi / 2.27931277388], abs=1e-8)
    assert np.all(np.diff(branch.arclength) > 0) and np.max(branch.error) < 1e-11
    kinds = [event.kind for event in branch.events]
    assert kinds.count("fold amplitude 1") == 1 and kinds.count("fold omega") == 2 and "branch point" in kinds
    for event in branch.events[:-1]:
        assert branch.arclength[event.index] <= event.arclength <= branch.arclength[event.index + 1]
    # A system that cannot shoot ends there and says so; the last point has the tail that is allowed.
    alone = trace(summed(2, shoots=False), method="harmonics", until="theta_1=-2.5", harmonics=short)
    assert "shooting would go on, and the system lacks the functions propagate" in alone.reason and "not reached" in alone.reason
    assert np.max(alone.error) <= 1.01e-12


@pytest.mark.long
def test_a_family_ends_where_its_rest_is_an_equilibrium() -> None:
    """Below the top, where the period grows without bound, and with no event before: beyond it there are no such orbits, whatever the target."""
    branch = trace(summed(1), method="harmonics", until="amplitude=3.5", harmonics=Harmonics(most=15))
    assert [event.kind for event in branch.events] == ["rest at an equilibrium"] and branch.reason.endswith("amplitude = 3.5 was not reached")
    left = np.pi - branch.points[-1, 0]
    assert 2e-5 < left < 6e-5 and branch.points[-1, 1] == pytest.approx(np.pi * np.sqrt(9.81 / 0.5) / (2 * ellipkm1(np.sin(left / 2) ** 2)), rel=1e-10)


def test_a_run_is_gone_on_with_before_and_behind_the_seam(tmp_path) -> None:
    short, limits = Harmonics(most=15), {"max_points": 14}
    whole = trace(summed(2), method="harmonics", until="theta_1=1", harmonics=short)
    for points in (6, 14, 18):
        part = trace(summed(2), method="harmonics", until="theta_1=1", harmonics=short, limits={**limits, "max_points": points})
        file = part.to_json(tmp_path / f"part{points}.json")
        on = trace(summed(2), method="harmonics", until="theta_1=1", harmonics=short, resume=file)
        assert on.points[-1] == pytest.approx(whole.points[-1], abs=1e-11) and on.points[-1, 0] == 1.0


def test_series_have_the_multipliers_of_their_orbits() -> None:
    """kappa of every point and event is that of the orbit that shooting finds beside it; a chain that cannot shoot has none."""
    found = trace(summed(2), method="harmonics", until="theta_1=0.6", limits={"max_points": 12})
    shot = Judge(summed(2), None, float(found.points[0, -1]), found.points[0, :-1]).problem
    assert found.multipliers.shape == (len(found), 1)
    for z, kappa in zip(found.points, found.multipliers, strict=True):
        orbit = start_on(shot, z, np.array([1.0, 0.0, 0.0]), Engine(), fixed=True)
        assert kappa == pytest.approx(orbit.multipliers, abs=1e-7)
    assert np.ptp(found.multipliers[:, 0].real) > 1e-3
    assert Judge(summed(2), None, 3.0, np.ones(2)).kappa(np.array([1.0, 1.0, -3.0])).shape == (1,)


def test_shooting_judges_points_beside_resonances() -> None:
    """A point that is off by 1e-6 across its branch is told, whatever its tail; where overtones are small the tail is the error."""
    system = summed(2)
    modes = linear_modes(system)
    judge = Judge(system, None, modes.omega[0], modes.shapes[:, 0])
    branch = trace(system, method="harmonics", until="theta_1=0.5")
    y, tangent = branch.points[-1] / branch.scale, branch.tangent[-1] / branch.scale
    assert judge.distance(y, tangent) < 1e-12
    across = np.array([tangent[1], -tangent[0], 0.0])
    assert judge.distance(y + 1e-6 * across / np.linalg.norm(across), tangent) == pytest.approx(1e-6, rel=0.5)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: trace(uniform_planar(2), method="harmonics"), UnsupportedError, "lacks the functions inverse_and_jacobian"),
        (lambda: trace(summed(2), 3, method="harmonics"), ArrayError, "modes 1 .. 2"),
        (lambda: trace(summed(2), method="harmonics", harmonics=8), ArrayError, "is even"),
        (lambda: trace(summed(2), method="harmonics", harmonics=1), ArrayError, "at least 3"),
        (lambda: trace(summed(2), method="shooting", harmonics=9), ArrayError, 'belong to method = "harmonics"'),
        (lambda: Harmonics(most=5, least=9), ArrayError, "harmonics that rise"),
        (lambda: Harmonics(tail=2.0), ArrayError, "a tail below 1"),
        (lambda: trace(uniform_planar(2, damping=[1, 1]), method="harmonics"), UnsupportedError, "no periodic motion"),
    ],
)
def test_bad_input_is_one_typed_error(call, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_options_are_those_of_the_run() -> None:
    fine = trace(summed(1, shoots=False), method="harmonics", until="theta_1=0.5", options=Options(step=0.01, step_max=0.02))
    assert np.max(np.diff(fine.arclength)) <= 0.0201
