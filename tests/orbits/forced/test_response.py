"""Frequency responses against closed forms, another integrator, and each other: by harmonics and by shooting alike."""

from __future__ import annotations

from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.continuation import Options, Special
from phichain.errors import ArrayError, OutputError, UnsupportedError
from phichain.orbits import Response, respond, trace
from phichain.orbits.forced.floquet import Linear, genuine, linear_of_series, on_circle
from phichain.orbits.forced.flow import EmittedFlow
from phichain.orbits.forced.forcing import Forcing, forcing_of
from phichain.orbits.forced.series import forced_problem, outer_of, table_of
from phichain.orbits.harmonics.elimination import Harmonics
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System
from tests import tables
from tests.handmade import paper_b, planar


@lru_cache
def driven(links: int, *, shoots: bool = True, **more: Any) -> System:
    """Paper A's chain of N links with dampers, forced at its first joint."""
    own: dict[str, Any] = {
        "mass": 1 / links, "length": 1 / links, "com": 0.5 / links, "actuated": "none", "damping": {1: 0.02, 2: (0.03, 0.01)}[links],
        "want": ("inverse_and_jacobian", "propagate") if shoots else ("inverse_and_jacobian", "forward_dynamics"),
    }  # fmt: skip
    if shoots:
        own |= {"variational": True, "forced": 1}
    return build(Scene(f"driven{links}", links, **{**own, **more}))


class OtherFlow:
    """The variational equations of one link, m r^2 theta'' = -m g r sin theta - d theta' + A cos(w t), by DOP853."""

    def __init__(self, inertia: float, weight: float, damping: float) -> None:
        self.inertia, self.weight, self.damping = inertia, weight, damping

    def rate(self, t: float, y: np.ndarray, amplitude: float, omega: float) -> np.ndarray:
        theta, v, columns, by_omega = y[0], y[1], y[2:6].reshape(2, 2), y[6:]
        a = (-self.weight * np.sin(theta) - self.damping * v + amplitude * np.cos(omega * t)) / self.inertia
        linear = np.array([[0.0, 1.0], [-self.weight * np.cos(theta) / self.inertia, -self.damping / self.inertia]])
        driven = np.array([0.0, -amplitude * t * np.sin(omega * t) / self.inertia])
        return np.concatenate([[v, a], (linear @ columns).ravel(), linear @ by_omega + driven])

    def _moved(self, x, times, amplitude, omega):
        begin = np.concatenate([x, np.eye(2).ravel(), np.zeros(2)])
        return solve_ivp(self.rate, (0, times[-1]), begin, "DOP853", t_eval=times, rtol=1e-12, atol=1e-13, args=(amplitude, omega)).y

    def __call__(self, x, span, amplitude, omega):
        y = self._moved(x, np.array([span]), amplitude, omega)[:, -1]
        at_end = self.rate(span, y, amplitude, omega)[:2]
        return y[:2], y[2:6].reshape(2, 2), y[6:] - at_end * span / omega

    def sampled(self, x, times, amplitude, omega):
        return self._moved(x, times, amplitude, omega)[:2].T


@lru_cache
def answers(links: int, method: str) -> Response:
    return respond(driven(links), None, 0.1, (3.0, 5.0), method=method)


def test_small_motions_are_the_linear_oscillator() -> None:
    """theta = A / (k - m w^2 + i d w) e^(i w t) with k = m g r, the multipliers e^(T (-z +- sqrt(z^2 - w_0^2))), z = d / (2 m r^2)."""
    found = respond(driven(1), 1, 1e-6, (2.0, 7.0), limits={"step_max": 0.5})
    stiffness, inertia, damping = 9.81 * 0.5, 0.25, 0.02
    exact = 1e-6 / (stiffness - inertia * found.omega**2 + 1j * damping * found.omega)
    # What is not linear is below the square of the largest angle.
    assert found.first[:, 0] == pytest.approx(exact, rel=1e-8) and found.peak[:, 0] == pytest.approx(np.abs(exact), rel=1e-8)
    period, decay = 2 * np.pi / found.omega, damping / (2 * inertia)
    own = np.exp(period * (-decay + np.sqrt(complex(decay**2 - stiffness / inertia))))
    assert found.multipliers[:, 0].real == pytest.approx(own.real, abs=1e-8)
    assert np.abs(found.multipliers[:, 0]) == pytest.approx(np.abs(own), rel=1e-8)
    assert np.all(found.stable) and [event.kind for event in found.events] == ["end of the range"]
    assert found.omega[0] == 2.0 and found.omega[-1] == 7.0


def test_folds_of_one_link_are_those_of_another_integrator() -> None:
    """By both methods alike, and by DOP853 each is a motion that closes after half a period whose map has an eigenvalue -1 there."""
    series, shot = answers(1, "harmonics"), answers(1, "shooting")
    other = OtherFlow(0.25, 9.81 * 0.5, 0.02)
    for found in (series, shot):
        assert [event.kind for event in found.events] == ["fold", "fold", "end of the range"]
        assert not np.all(found.stable) and found.stable[0] and found.stable[-1]
    for one, two in zip(series.located("fold"), shot.located("fold"), strict=True):
        assert one.omega == pytest.approx(two.omega, rel=1e-9) and one.peak == pytest.approx(two.peak, rel=2e-7)
        x = np.array([two.q[0], two.v[0]])
        end, columns, _ = other(x, np.pi / two.omega, 0.1, two.omega)
        assert end == pytest.approx(-x, abs=1e-9) and np.min(np.abs(np.linalg.eigvals(columns) + 1)) < 1e-6
        assert np.min(np.abs(one.multipliers - 1)) < 1e-6 and one.breaks and one.continues
    assert len(series) < 150 and np.max(series.error) <= 1e-8 and np.max(shot.error) < 1e-11


def test_any_flow_can_be_shot_by() -> None:
    """A few points by DOP853 instead of the emitted flow."""
    other = respond(driven(1), 1, 0.1, (3.0, 3.2), method="shooting", flow=OtherFlow(0.25, 9.81 * 0.5, 0.02), limits={"step_max": 0.4})
    own = respond(driven(1), 1, 0.1, (3.0, 3.2), method="shooting")
    assert other.peak[-1] == pytest.approx(own.peak[-1], rel=1e-9) and other.multipliers[-1] == pytest.approx(own.multipliers[-1], abs=1e-9)


def test_the_column_by_omega_is_exact() -> None:
    """Against the variational equations by another integrator, and where the flow carries no such column against differences."""
    exact, plain = (driven(1, variational=names) for names in (("state", "forcing"), True))
    forcing, x, span, omega = forcing_of(plain, 1, 0.1), np.array([0.7, -0.4]), 0.8, 4.1
    end, columns, by_omega = EmittedFlow(exact, forcing)(x, span, 0.1, omega)
    other, own, wanted = OtherFlow(0.25, 9.81 * 0.5, 0.02)(x, span, 0.1, omega)
    for found, right in ((end, other), (columns, own), (by_omega, wanted)):
        np.testing.assert_allclose(found, right, rtol=2e-11, atol=2e-11)
    np.testing.assert_allclose(EmittedFlow(plain, forcing)(x, span, 0.1, omega)[2], by_omega, rtol=1e-8, atol=1e-9)


def test_folds_of_two_links_agree_by_both_methods() -> None:
    series, shot = answers(2, "harmonics"), answers(2, "shooting")
    assert [event.kind for event in series.events] == [event.kind for event in shot.events] and series.located("fold")
    for one, other in zip(series.events, shot.events, strict=True):
        assert one.omega == pytest.approx(other.omega, rel=1e-9) and one.q == pytest.approx(other.q, abs=2e-7)


@pytest.mark.parametrize("links", [1, 2])
def test_multipliers_are_those_of_the_flow(links: int) -> None:
    """At a point of the response: the monodromy by Gauss's collocation, and by the Taylor flow; their product is Liouville's."""
    found, system = answers(links, "harmonics"), driven(links)
    k = len(found) // 2
    x, omega = np.concatenate([found.q[k], found.v[k]]), float(found.omega[k])
    period = 2 * np.pi / omega
    moved = system.propagate(x[:links], x[links:], 0.0, period, 1e-15, forcing=(0.1, omega), transition=np.eye(2 * links))
    assert np.concatenate([moved.q, moved.v]) == pytest.approx(x, abs=1e-7)
    own = np.linalg.eigvals(moved.transition)
    assert np.sort_complex(found.multipliers[k]) == pytest.approx(np.sort_complex(own), abs=1e-6)
    if links == 1:
        assert np.prod(found.multipliers[k]).real == pytest.approx(np.exp(-period * 0.02 / 0.25), rel=1e-9)


def test_a_hard_driven_link_loses_its_symmetry() -> None:
    """Swept down at 0.5 N m the link swings to 2.9 rad, where its half period's map gets an eigenvalue +1: by both methods and DOP853."""
    series, shot = (respond(driven(1), 1, 0.5, (8.0, 2.0), method=method) for method in ("harmonics", "shooting"))
    (one,), (two,) = (found.located("symmetry breaking") for found in (series, shot))
    assert one.omega == pytest.approx(two.omega, rel=1e-8) and one.breaks == "q(t + T/2) = -q(t)"
    half = OtherFlow(0.25, 9.81 * 0.5, 0.02)(np.array([two.q[0], two.v[0]]), np.pi / two.omega, 0.5, two.omega)[1]
    assert np.min(np.abs(np.linalg.eigvals(half) - 1)) < 1e-7
    assert np.min(np.abs(two.multipliers - 1)) < 1e-7


def test_a_pair_that_leaves_the_circle_is_told_from_a_neutral_saddle() -> None:
    """prod (nu_i nu_j - 1) changes sign where a complex pair crosses, and where two real ones are inverse: only the first is a torus."""

    def at(radius: float, angle: float) -> Any:
        turn = radius * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        linear = Linear(np.block([[turn, np.zeros((2, 2))], [np.zeros((2, 2)), np.diag([0.5, 0.3])]]), is_half=False)
        return SimpleNamespace(extra=SimpleNamespace(found=linear)), linear

    (inside, _), (outside, _) = at(0.999, 1.0), at(1.001, 1.0)
    assert on_circle(inside) * on_circle(outside) < 0
    saddle = np.array([2.0, 0.5, 0.3, 0.1], complex)
    for multipliers, true in ((at(1.0, 1.0)[1].multipliers, True), (saddle, False)):
        event = Special("neimark-sacker", 0, np.zeros(3), 0.0, 0.0, multipliers)
        assert genuine(event) is true
    half = Linear(at(0.9, 1.0)[1].map, is_half=True)
    assert np.sort_complex(half.multipliers) == pytest.approx(np.sort_complex(np.linalg.eigvals(half.map) ** 2))


def test_springs_that_rest_aside_take_every_harmonic() -> None:
    """No half period is the mirror of the other: the mean moves with the amplitude, and the series satisfies the equation of motion."""
    system = build(
        Scene("bent", 1, mass=0.7, length=0.6, damping=0.05, stiffness=2.0, rest_angle=0.8, actuated="none", want=("inverse_and_jacobian",))
    )
    found = respond(system, 1, 0.3, (2.0, 6.0))
    k = int(np.argmax(found.peak[:, 0]))

    def rate(t, y):
        torque = -0.7 * 9.81 * 0.6 * np.sin(y[0]) - 0.05 * y[1] - 2.0 * (y[0] - 0.8) + 0.3 * np.cos(found.omega[k] * t)
        return [y[1], torque / (0.7 * 0.36)]

    x = np.array([found.q[k, 0], found.v[k, 0]])
    end = solve_ivp(rate, (0, 2 * np.pi / found.omega[k]), x, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert end == pytest.approx(x, abs=1e-6) and found.peak[k, 0] > 0.3


def test_a_torque_is_the_same_in_all_angles() -> None:
    chain: dict[str, Any] = {"mass": [0.5, 0.3, 0.2], "length": [0.4, 0.3, 0.3], "damping": [0.02, 0.01, 0.01], "actuated": "none"}
    system, other = (build(Scene(f"turned_{kind}", 3, angles=kind, want=("inverse_and_jacobian",), **chain)) for kind in ("relative", "adjacent"))
    one, two = (respond(own, 3, 0.01, (3.0, 4.0), limits={"step_max": 0.5}) for own in (system, other))
    # phi_k = theta_k + theta_(k-1) in these, the sum of all before in relative ones.
    assert one.first[-1] == pytest.approx(np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 1]]) @ two.first[-1], rel=1e-9)


def test_a_response_is_read_back_as_it_was(tmp_path) -> None:
    found = answers(1, "harmonics")
    for copy in (Response.from_npz(found.to_npz(tmp_path / "r.npz")), Response.from_json(found.to_json(tmp_path / "r.json"))):
        assert str(copy) == str(found) and np.array_equal(copy.multipliers, found.multipliers) and np.array_equal(copy.first, found.first)
        assert np.array_equal(copy.events[0].q, found.events[0].q) and copy.column("theta_1")[3] == found.peak[3, 0]
    rows = tables.lines(found.to_csv(tmp_path / "r.csv"))
    assert rows[0].startswith("omega,peak_theta_1,first_theta_1,phase_theta_1") and len(rows) == len(found) + 1
    (tmp_path / "cut.json").write_text((tmp_path / "r.json").read_text()[:400])
    with pytest.raises(OutputError, match="no response can be read there"):
        Response.from_json(tmp_path / "cut.json")


def test_an_unresolved_tail_is_handed_on_or_said() -> None:
    """Five harmonics leave much at the peak: shooting goes on where there is a forced flow, and else the run ends and says so."""
    short = Harmonics(tail=1e-8, most=7)
    alone = respond(driven(1, shoots=False), 1, 0.1, (3.0, 5.0), harmonics=short)
    assert "the harmonics up to 7 leave a tail above 1e-08" in alone.reason and np.max(alone.error) < 1.01e-8
    on = respond(driven(1), 1, 0.1, (3.0, 5.0), harmonics=short)
    assert "shot" in on.reason and on.omega[-1] == 5.0
    folds = [event.omega for event in on.located("fold")]
    assert folds == pytest.approx([event.omega for event in answers(1, "shooting").located("fold")], rel=1e-9)


def _one(**more: Any) -> Forcing:
    return forcing_of(driven(1), **{"forced": 1, "amplitude": 0.1, **more})


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: respond(driven(1), 1, 0.1), ArrayError, "omega: is missing: a forcing without a frequency is a constant load"),
        (lambda: respond(driven(1), 1, 0.1, 3.0), ArrayError, "no range of frequencies"),
        (lambda: respond(driven(1), 1, 0.1, (3.0, 3.0)), ArrayError, "a single frequency"),
        (lambda: respond(driven(1), 1, 0.1, (-1.0, 3.0)), ArrayError, "positive"),
        (lambda: respond(driven(1), 1, None, (2.0, 3.0)), ArrayError, "amplitude: is missing"),
        (lambda: respond(driven(1), 1, -0.1, (2.0, 3.0)), ArrayError, "positive"),
        (lambda: respond(driven(1, shoots=False), None, 0.1, (2.0, 3.0)), ArrayError, "unforced a chain with losses comes to rest"),
        (lambda: _one(forced=2), ArrayError, "use a joint from 1 to 1"),
        (lambda: _one(forced="cart"), ArrayError, "needs a cart"),
        (lambda: _one(forced="base"), ArrayError, "needs a moving base"),
        (lambda: _one(forced="tip"), ArrayError, "nothing that can be forced"),
        (lambda: _one(axis=2), ArrayError, "the axis of a moving base"),
        (lambda: respond(driven(1), 1, 0.1, (2.0, 3.0), method="magic"), ArrayError, "use one of harmonics, shooting"),
        (lambda: respond(driven(1), 1, 0.1, (2.0, 3.0), method="shooting", harmonics=7), ArrayError, "belong to method"),
        (lambda: respond(driven(1, shoots=False), 1, 0.1, (2.0, 3.0), method="shooting"), UnsupportedError, r"\[forcing\] forced = 1"),
        (lambda: respond(planar([1.0], [1.0]), 1, 0.1, (2.0, 3.0)), UnsupportedError, "inverse_and_jacobian"),
        (lambda: respond(paper_b(), "cart", 0.1, (2.0, 3.0)), UnsupportedError, "is spatial"),
        (lambda: trace(driven(1)), UnsupportedError, "phichain response"),
    ],
)
def test_bad_input_is_one_typed_error(call, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_amplitudes_beyond_pi_are_said() -> None:
    found = respond(driven(1), 1, 0.7, (8.0, 1.5), method="shooting", limits={"max_points": 150})
    assert np.max(found.peak) > np.pi
    assert ("beyond pi" in found.reason) == bool(np.max(found.peak) > np.pi)


def test_the_collocation_converges_with_its_steps() -> None:
    """The same motion with twice the harmonics, so twice the steps, has the same map."""
    system = driven(1)
    forcing = forcing_of(system, 1, 0.1)
    problem = forced_problem(system, forcing, omega=4.0, outer=outer_of(system, forcing, None, 3.0), harmonics=Harmonics(tail=1e-8))
    z = problem.evaluate(np.append(np.zeros(len(problem.names) - 1), 3.0))
    series = z.extra.series
    maps = []
    for more in (0, 24):
        wide = np.vstack([series.coefficients, np.zeros((more, 1))])
        maps.append(linear_of_series(system, forcing, table_of(forcing, len(wide)), wide, 3.0, None).map)
    assert maps[0] == pytest.approx(maps[1], abs=1e-9)


def test_options_are_those_of_the_run() -> None:
    found = respond(driven(1), 1, 0.01, (3.0, 3.3), options=Options(step=0.01, step_max=0.01))
    assert np.max(np.diff(found.arclength)) < 0.0101
