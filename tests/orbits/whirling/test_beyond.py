"""Beyond lost planes and lost reversals: orbits that stand still off any plane, and orbits that no mirror image is the reversal of."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.continuation import Branch
from phichain.errors import ArrayError, UnsupportedError
from phichain.orbits import pick, trace
from phichain.orbits.in_space import space_problem
from phichain.orbits.parameter import vary
from phichain.orbits.unmirrored import unmirrored_problem
from phichain.orbits.unmirrored.doubled import twice
from phichain.orbits.whirling import NEEDED, whirling_problem
from phichain.orbits.whirling.fixed import turned
from phichain.pipeline import build
from phichain.report.figures import family
from phichain.scene import Scene
from phichain.system import System
from phichain.system.state import rhs
from tests.orbits.whirling.monodromy import spectrum
from tests.orbits.whirling.test_whirling import chain, cone

R = "runtime"
P = {"mass": [1.5, 1.9], "length": [0.55, 0.67], "com": [0.27, 0.5]}


@lru_cache
def uneven() -> System:
    """Two unlike links, whose plane is lost at their rests."""
    return build(Scene("uneven2", 2, mass=R, length=R, com=R, space="spatial", want=NEEDED, variational=True))


@lru_cache
def flat() -> Branch:
    return trace(uneven(), method="in a plane", until="amplitude=1.8", p=P)


@lru_cache
def still() -> Branch:
    """The orbits that begin where the plane is lost first, to their end."""
    return trace(uneven(), method="in space", start=(flat(), flat().located("plane loss")[1]), p=P)


@lru_cache
def lost() -> Branch:
    """The second whirling family beside a conical orbit, its turn held, until it has lost its reversal."""
    return trace(chain(2), 2, method="whirling", start=cone(2), hold="turn", limits={"max_points": 45})


@lru_cache
def free(points: int = 40) -> Branch:
    return trace(chain(2), method="unmirrored", start=(lost(), lost().located("reversal loss")[0]), limits={"max_points": points})


def flown(system: System, x: np.ndarray, span: float, p: Any = None) -> np.ndarray:
    """By another integrator."""
    return solve_ivp(lambda t, y: rhs(system)(t, y, None, p), (0, span), x, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


@pytest.mark.long
def test_orbits_stand_still_off_any_plane() -> None:
    """At rest, after T/2 at rest where half a turn about the vertical brings them, by another integrator; and truly in space."""
    found = still()
    for k in (6, len(found) // 2):
        x, half = found.states[k], np.pi / found.points[k, -1]
        end = flown(uneven(), x, half, P)
        assert np.max(np.abs(end[6:])) < 1e-11 and end[:6] == pytest.approx(x[:6] * np.tile([-1, -1, 1], 2), abs=1e-11)
        flat_parts = x[:6].reshape(2, 3)[:, :2]
        assert np.linalg.svd(flat_parts, compute_uv=False)[-1] > 0.02
    assert found.residual[1:-2].max() < 1e-13 and np.all(np.abs(found.column("unfolding")) < 1e-12)


def test_such_a_family_joins_two_places_where_the_plane_is_lost() -> None:
    """It ends where the family in the plane has found, by another map, that it loses the plane."""
    found, others = still(), flat().located("plane loss")
    assert found.reason == "ended in a plane" and found.events[-1].kind == "in a plane"
    at = found.points[-1, [0, 1, -1]]
    assert min(np.max(np.abs(np.abs(event.z) - np.abs(at))) for event in others[2:]) < 1e-6


@pytest.mark.parametrize("which", ["in space", "unmirrored"])
def test_multipliers_are_those_of_the_whole_monodromy(which: str) -> None:
    system, branch, p = (uneven(), still(), {"p": P}) if which == "in space" else (chain(2), free(), {})
    found = pick(system, branch, "point=12", **p)
    own = spectrum(system, np.concatenate([found.q[0], found.v[0]]), found.period, found.turn, p)
    assert len(found.multipliers) == 4 and found.closure < 1e-12
    for value in own:
        assert np.min(np.abs(found.multipliers - value)) < 1e-5 * abs(value)


def test_orbits_without_a_reversal_come_back_turned() -> None:
    """By another integrator, the turn held; off every state that a reversal keeps, and between two of the whirling family at both ends."""
    found = free()
    for k in (8, 20):
        x, turn, omega = found.states[k], *found.points[k, -2:]
        assert turned(flown(chain(2), x, 2 * np.pi / omega), -turn) == pytest.approx(x, abs=1e-10 * np.max(np.abs(x)))
        assert turn == pytest.approx(lost().points[0, -2], abs=1e-13)
    assert found.reason == "ended at its own mirror image"
    # Somewhere on the last one all links are in one vertical plane, moving across it: a whirling orbit, by its own equations.
    x, omega = found.states[-1], found.points[-1, -1]
    times = np.linspace(0, 2 * np.pi / omega, 4001)[1:]
    way = chain(2).propagate(x[:6], x[6:], 0.0, times[-1], 1e-16, times=times)
    flat_parts = np.concatenate([way.q_at.reshape(-1, 2, 3)[:, :, :2], way.v_at.reshape(-1, 2, 3)[:, :, :2] / omega], axis=1)
    _, sizes, rows = np.linalg.svd(flat_parts)
    k = int(np.argmin(sizes[:, -1]))
    at = turned(np.concatenate([way.q_at[k], way.v_at[k]]), -np.arctan2(rows[k, 0, 1], rows[k, 0, 0])).reshape(4, 3)
    theta = np.arctan2(at[:2, 0], at[:2, 2])
    rates = -(np.cos(theta) * at[2:, 0] - np.sin(theta) * at[2:, 2])
    z = np.concatenate([theta, rates, found.points[-1, -2:]])
    problem = whirling_problem(chain(2), held="turn", value=z[-2], omega=omega)
    assert np.max(np.abs(problem.evaluate(z).residual)) < 0.05


@lru_cache
def whirl() -> Branch:
    """A whirling family whose period doubles before it loses its reversal."""
    return trace(chain(2), 3, method="whirling", start=trace(chain(2), method="conical", until="theta_1=0.4"), limits={"max_points": 60})


@lru_cache
def doubling() -> tuple[Branch, Branch]:
    """A family without a reversal until its period doubles, and the one that begins there."""
    begun = whirl()
    single = trace(chain(2), method="unmirrored", start=(begun, begun.located("reversal loss")[0]), limits={"max_points": 34})
    return single, trace(chain(2), method="unmirrored", start=(single, single.located("period doubling")[0]), limits={"max_points": 14})


def test_beyond_a_period_doubling_orbits_come_back_after_two() -> None:
    """By another integrator: turned by twice the angle after twice the time, and not after once; the momentum held, its own period doubling told."""
    single, double = doubling()
    event = single.located("period doubling")[0]
    assert event.multipliers == pytest.approx([-1, event.multipliers[1]], abs=1e-9) and "unmirrored" in event.continues
    assert double.points[0, -1] == pytest.approx(event.z[-1] / 2, rel=1e-4) and double.points[0, -2] == pytest.approx(2 * event.z[-2], rel=1e-4)
    for k in (0, 6):
        x, turn, omega = double.states[k], *double.points[k, -2:]
        assert turned(flown(chain(2), x, 2 * np.pi / omega), -turn) == pytest.approx(x, abs=2e-11 * np.max(np.abs(x)))
        assert np.max(np.abs(turned(flown(chain(2), x, np.pi / omega), -turn / 2) - x)) > 0.1
    assert np.ptp(double.momentum) < 1e-12 and double.momentum[0] == pytest.approx(single.momentum[0], rel=1e-12)
    assert double.residual.max() < 1e-13 and [event.kind for event in double.events] == ["period doubling"]
    assert twice(chain(2), None, event.z * np.append(np.ones(len(event.z) - 2), [2.0, 0.5]), 1) < 1e-8 < twice(chain(2), None, double.points[3], 1)


def test_events_say_which_method_follows_what_begins_there_or_that_none_does() -> None:
    """No method takes a start that says so; each other one opens a family by the method that it names."""
    ends = {"whirling": (chain(2), whirl(), {}), "in space": (uneven(), still(), {"p": P})}
    said = [(event.kind, *ends[name], event) for name in ends for event in ends[name][1].events]
    assert {"period doubling", "reversal loss", "odd loss"} <= {kind for kind, *_ in said}
    for kind, system, branch, p, event in said:
        if kind in ("period doubling", "odd loss"):
            assert event.continues.endswith("which no method here follows")
            for method in ("whirling", "unmirrored", "in space"):
                with pytest.raises(ArrayError, match="start: "):
                    trace(system, method=method, start=(branch, event), **p)
        else:
            assert "no method" not in event.continues


@pytest.mark.parametrize("held", ["momentum", "energy", "turn"])
def test_the_jacobians_are_those_of_the_residuals(held: str) -> None:
    """Off any orbit, by differences."""
    rng = np.random.default_rng(5)
    problems = [(unmirrored_problem(chain(2), held=held, value=0.3, omega=4.0, link=1), np.concatenate(
        [[0.6, 0.1, 0.8, 0.5, 0.9], rng.uniform(-2, 2, 5), 0.1 * rng.standard_normal(6), [0.9, 6.0]]))]  # fmt: skip
    if held == "turn":
        problems.append((space_problem(uneven(), P, omega=4.0, kept=1), np.array([0.7, 0.9, 0.3, 0.05, 3.0])))
    for problem, z in problems:
        own = problem.evaluate(z).jacobian
        steps = 1e-6 * np.eye(len(z))
        rough = np.array([(problem.evaluate(z + h).residual - problem.evaluate(z - h).residual) / 2e-6 for h in steps]).T
        if held == "turn" and len(z) == 5:
            # What unfolds has a direction of its own, which is zero times anything on an orbit.
            own, rough = own[:, [3, 4]][:, :1], rough[:, [3, 4]][:, :1]
        assert own == pytest.approx(rough, abs=2e-6)


def test_both_are_gone_on_with_bit_by_bit(tmp_path: Path) -> None:
    event = flat().located("plane loss")[1]
    for system, method, whole, start, p in (
        (uneven(), "in space", still(), (flat(), event), {"p": P}),
        (chain(2), "unmirrored", free(), (lost(), lost().located("reversal loss")[0]), {}),
    ):
        begun = trace(system, method=method, start=start, limits={"max_points": 6}, **p)
        on = trace(system, method=method, resume=begun.to_json(tmp_path / "b.json"), limits={"max_points": 6}, **p)
        assert on.points.tolist() == whole.points[: len(on)].tolist() and len(on) > 8


def test_both_are_followed_in_a_parameter() -> None:
    """At another length both still come back, by that chain's flow; what was held is."""
    p = {**P, "length": [0.551, 0.67]}
    there = vary(uneven(), "length[1]", (still(), 12), 0.551, hold="theta_2", p=P)
    end = flown(uneven(), there.states[-1], np.pi / there.points[-1, -2], p)
    assert there.method == "in space in length[1]" and there.points[-1, 1] == still().points[12, 1]
    assert np.max(np.abs(end[6:])) < 1e-11 and end[:6] == pytest.approx(there.states[-1, :6] * np.tile([-1, -1, 1], 2), abs=1e-11)
    begun = trace(uneven(), method="whirling", start=trace(uneven(), method="conical", until="theta_1=0.8", p=P), mode=2, hold="turn", p=P,
                  limits={"max_points": 32})  # fmt: skip
    loose = trace(uneven(), method="unmirrored", start=(begun, begun.located("reversal loss")[0]), p=P, limits={"max_points": 8})
    there = vary(uneven(), "length[1]", loose, 0.551, hold="q_1_2", p=P)
    x, turn, omega = there.states[-1], *there.points[-1, -3:-1]
    end = turned(flown(uneven(), x, 2 * np.pi / omega, p), -turn)
    assert end == pytest.approx(x, abs=1e-10 * np.max(np.abs(x))) and turn == pytest.approx(loose.points[0, -2], abs=1e-12)
    assert there.points[-1, -1] == 0.551


def test_both_are_drawn() -> None:
    """Over angles of the rests, and over arclength where a start is none."""
    for branch, label in ((still(), "amplitude (rad)"), (free(), "arclength")):
        axes = family(branch).axes
        assert axes[0].get_xlabel() == label and axes[1].get_xlabel() == "energy (J)"


def test_what_is_refused() -> None:
    with pytest.raises(ArrayError, match="is nothing that brake orbits in space begin at"):
        trace(uneven(), method="in space", start=flat(), p=P)
    with pytest.raises(ArrayError, match="is nothing that such orbits begin at"):
        trace(chain(2), method="unmirrored", start=lost())
    with pytest.raises(UnsupportedError, match='use method = "in space"'):
        trace(uneven(), method="whirling", start=(flat(), flat().located("plane loss")[1]), p=P)
    with pytest.raises(ArrayError, match="is no quantity of orbits that do not start in a plane"):
        trace(chain(2), method="unmirrored", start=(lost(), lost().located("reversal loss")[0]), until="theta_1=1")
