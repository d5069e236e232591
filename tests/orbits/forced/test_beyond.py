"""What events of a frequency response open: the damped driven pendulum of the literature, its branches against the motions it settles to.

With theta'' + theta' / 2 + sin theta = g cos(2 t / 3) (Baker and Gollub, Chaotic Dynamics, 1990) the motion that has lost its symmetry doubles its
period at g = 1.0663, and once more at 1.0793; at g = 1.07 it takes two periods.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.errors import ArrayError
from phichain.orbits import Response, respond
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

DRIVEN = 2 / 3
UP = 1.07


@lru_cache
def pendulum() -> System:
    """Units of its own: m l^2 = 1 and g / l = 1."""
    scene = Scene(
        "baker", 1, mass=9.81**-2, length=9.81, damping=0.5, forced=1, variational=True, want=("propagate", "inverse_and_jacobian")
    )
    return build(scene)


@lru_cache
def found(amplitude: float = UP) -> tuple[Response, Response]:
    """The symmetric motions, and those beyond the loss of that."""
    first = respond(pendulum(), 1, amplitude, (1.0, 0.64), method="shooting")
    number = 1 + [event.kind for event in first.events].index("symmetry breaking")
    return first, respond(pendulum(), 1, amplitude, (1.0, 0.64), beyond=(first, number))


def doubled(to: float) -> Response:
    broken = found()[1]
    number = 1 + [event.kind for event in broken.events].index("period doubling")
    return respond(pendulum(), 1, UP, (1.0, to), beyond=(broken, number))


def settled(amplitude: float, omega: float, start: tuple[float, float], periods: int) -> np.ndarray:
    """(theta, theta') at phase zero of the last eight periods, by another integrator."""

    def rate(t, x):
        return [x[1], -x[1] / 2 - np.sin(x[0]) + amplitude * np.cos(omega * t)]

    times = 2 * np.pi / omega * np.arange(periods - 8, periods)
    return solve_ivp(rate, (0, times[-1]), start, "DOP853", rtol=1e-10, atol=1e-12, t_eval=times).y.T


def test_motions_of_two_periods_are_those_it_settles_to() -> None:
    branch = doubled(DRIVEN)
    assert branch.periods == 2 and branch.omega[-1] == DRIVEN and branch.stable[-1]
    last = settled(UP, DRIVEN, (-2.0, 1.0), 160)
    assert last[-1] == pytest.approx(last[-3], abs=1e-8) and abs(last[-1, 0] - last[-2, 0]) > 0.05
    x = np.array([branch.q[-1, 0], branch.v[-1, 0]])
    # From either side it may settle to the mirror image, half a period later, too.
    turned = np.concatenate([settled(UP, DRIVEN, tuple(x), 10)[:2], [x]])
    assert min(np.max(np.abs(last[-1] - own)) for own in turned) < 1e-7


def test_the_period_doubles_where_the_literature_has_it() -> None:
    """On the branch without symmetry at g = 1.0663 the event is beside 2 / 3, to the literature's digits."""
    _, broken = found(1.0663)
    (event,) = broken.located("period doubling")[:1]
    assert event.omega == pytest.approx(DRIVEN, abs=2e-4) and np.min(np.abs(event.multipliers + 1)) < 1e-7


def test_a_motion_without_symmetry_is_one() -> None:
    first, broken = found()
    (event,) = first.located("symmetry breaking")
    assert broken.omega[0] == pytest.approx(event.omega, abs=1e-3) and "beyond the symmetry breaking" in broken.name
    k = len(broken) // 2
    x, omega = np.array([broken.q[k, 0], broken.v[k, 0]]), float(broken.omega[k])
    flow = pendulum().propagate(x[:1], x[1:], 0.0, np.pi / omega, 1e-15, forcing=(UP, omega))
    half = np.array([flow.q[0], flow.v[0]])
    assert np.max(np.abs(half + x)) > 0.1
    whole = pendulum().propagate(x[:1], x[1:], 0.0, 2 * np.pi / omega, 1e-15, forcing=(UP, omega))
    assert [whole.q[0], whole.v[0]] == pytest.approx(x, abs=1e-12)
    assert np.prod(broken.multipliers[k]).real == pytest.approx(np.exp(-np.pi / omega), rel=1e-9)


def test_it_is_kept_on_file(tmp_path) -> None:
    branch = doubled(0.667)
    for copy in (Response.from_npz(branch.to_npz(tmp_path / "r.npz")), Response.from_json(branch.to_json(tmp_path / "r.json"))):
        assert copy.periods == 2 and str(copy) == str(branch)


def test_what_is_refused() -> None:
    first, _ = found()
    end = len(first.events)
    for beyond, words in (((first, 9), "events"), ((first, end), "opens no branch"), ("1", "is no"), ((first, True), "events")):
        with pytest.raises(ArrayError, match=words):
            respond(pendulum(), 1, UP, (1.0, 0.64), beyond=beyond)
    with pytest.raises(ArrayError, match="another scene, place or amplitude"):
        respond(pendulum(), 1, 1.08, (1.0, 0.64), beyond=(first, 1))


def test_two_damped_links_lose_their_period_to_a_torus() -> None:
    """A pair of multipliers leaves the unit circle on a real chain: before it deviations die out, behind it the pair grows, by the flow itself."""
    system = build(
        Scene("torus2", 2, mass=[0.305, 1.078], length=[0.903, 0.282], com=[0.519, 0.26], damping=[0.00313, 0.01026], stiffness=[2.55, 1.182],
              forced=1, actuated="none", variational=True, want=("propagate", "inverse_and_jacobian"))
    )  # fmt: skip
    response = respond(system, 1, 0.33, (3.3, 3.005), method="shooting", limits={"max_points": 60, "step_max": 0.3})
    event = response.located("neimark-sacker")[0]
    assert event.omega == pytest.approx(3.00964852562, rel=1e-8)
    period = 2 * np.pi / event.omega
    moved = system.propagate(event.q, event.v, 0.0, period, 1e-15, forcing=(0.33, event.omega), transition=np.eye(4))
    assert np.concatenate([moved.q, moved.v]) == pytest.approx(np.concatenate([event.q, event.v]), abs=1e-10)
    own = np.linalg.eigvals(moved.transition)
    pair = own[np.abs(own.imag) > 0.1]
    assert len(pair) == 2 and np.abs(pair) == pytest.approx(1.0, abs=1e-7)
    before, behind = (np.abs(response.multipliers[k][np.abs(response.multipliers[k].imag) > 0.1]) for k in (event.after, event.after + 1))
    assert np.max(before) < 1 < np.max(behind) or np.max(behind) < 1 < np.max(before)
