"""Laws of measurements as records and Programs, integral action in closed loop, and what is refused."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import cont2discrete

from phichain.control import Sensors, estimator, lqr, output_law, with_integrals
from phichain.errors import ArrayError, ControlError, EmissionError, OutputError
from phichain.ir import evaluate
from phichain.laws import OutputFeedback
from phichain.lowering.laws import NEXT, output_feedback, output_feedback_reset
from tests.control.closed_loop import after
from tests.control.output.made_laws import CHAINS, LAWS, PERIOD, gains_of, law_of


def test_integrals_take_away_what_a_constant_force_leaves() -> None:
    """Half a newton on the cart, from nowhere: held off its place by the regulator, led there by the integral."""
    system, ends = CHAINS["plane"], {}
    gains = lqr(system, sample=PERIOD, Q=[10, 1, 1, 1, 1, 1])
    for name, law in (("plain", gains.law()), ("integral", output_law(gains, None, {"x": 20.0}))):
        call = law.running() if isinstance(law, OutputFeedback) else law
        x = np.array([0.0, np.pi, 0, 0, 0, 0])
        for k in range(1500):
            x = after(system, x, call(k * PERIOD, x) + 0.5, PERIOD)
        ends[name] = x
    assert abs(ends["plain"][0]) > 0.1
    assert abs(ends["integral"][0]) < 0.04 and np.max(np.abs(ends["integral"][1:] - [np.pi, 0, 0, 0, 0])) < 0.04


def test_integrals_are_placed_with_the_rest() -> None:
    """By NumPy's eigenvalues of the joined loop, sampled by SciPy; one pole is too many or too few otherwise."""
    gains = lqr(CHAINS["plane"], sample=PERIOD)
    poles = [-1.5, -2, -3, -4, -5, -6, -7]
    found = with_integrals(gains, {"x": 1.0}, poles)
    n, nu = gains.B.shape
    flow = expm(np.block([[gains.A, gains.B], [np.zeros((nu, n + nu))]]) * PERIOD)
    a = np.block([[flow[:n, :n], np.zeros((n, 1))], [PERIOD * np.eye(1, n), np.ones((1, 1))]])
    closed = a - np.vstack([flow[:n, n:], np.zeros((1, nu))]) @ np.hstack([found.K, found.K_i])
    assert np.allclose(np.sort(np.log(np.linalg.eigvals(closed)).real / PERIOD)[::-1], poles, rtol=1e-3)
    assert np.allclose(found.poles, poles, rtol=1e-6) and output_law(gains, None, found).integrated == (0,)
    with pytest.raises(ControlError, match="poles: are not as many as states: 7"):
        with_integrals(gains, {"x": 1.0}, poles[1:])


def test_the_integral_gains_fulfil_the_joined_equation() -> None:
    """SciPy's solver on the chain and its integral, sampled by SciPy too."""
    gains = lqr(CHAINS["plane"], sample=PERIOD, Q=2.0, R=0.3)
    found = with_integrals(gains, {"x": 3.0})
    a, b, *_ = cont2discrete((gains.A, gains.B, np.eye(6), np.zeros((6, 1))), PERIOD)
    A, B = np.eye(7), np.vstack([b, [[0.0]]])
    A[:6, :6], A[6, 0] = a, PERIOD
    Q = np.diag([2.0] * 6 + [3.0])
    S = solve_discrete_are(A, B, Q, 0.3 * np.eye(1))
    K = np.linalg.solve(0.3 + B.T @ S @ B, B.T @ S @ A)
    assert np.allclose(np.hstack([found.K, found.K_i]), K, rtol=1e-6, atol=1e-6 * np.max(np.abs(K)))
    assert np.max(np.abs(np.linalg.eigvals(A - B @ np.hstack([found.K, found.K_i])))) < 1


def test_nothing_winds_up_at_a_limit() -> None:
    """Held at its limit for 2000 calls an integral stays where it is, and grows where that relieves the input."""
    law = law_of("plane", None, True, limit=1.0)
    far, memory = np.array([3.0, np.pi, 0, 0, 0, 0]), law.reset(np.zeros(6))
    for _ in range(2000):
        u, memory = law.step(memory, far)
    assert abs(u[0]) == 1.0
    inside = law.step(memory, np.array(law.offsets))[0]
    assert abs(inside[0]) < 1.0
    free = law_of("plane", None, True)
    memory = free.reset(np.zeros(6))
    for _ in range(2000):
        _, memory = free.step(memory, far)
    assert abs(memory["integral"][0]) == pytest.approx(2000 * PERIOD * (3.0 - 0.125))


@pytest.mark.parametrize(("chain", "kind", "integrals"), LAWS)
def test_the_program_is_the_record(chain: str, kind: str | None, integrals: bool) -> None:
    law = law_of(chain, kind, integrals, limit=3.0)
    step, reset = output_feedback(law), output_feedback_reset(law)
    draw = np.random.default_rng(3)
    for scale in (0.01, 0.3, 5.0):
        y = np.array(law.offsets) + scale * draw.normal(size=len(law.offsets))
        started = {name: evaluate(reset, {"y_meas": y} if kind else {})[f"{name}{NEXT}"] for name in law.memory}
        for name, value in started.items():
            assert np.allclose(value, law.reset(y)[name], rtol=1e-13, atol=1e-14)
        memory = {name: scale * draw.normal(size=size) for name, size in law.memory.items()}
        found = evaluate(step, {**memory, "y_meas": y})
        u, following = law.step({"integral": np.zeros(0)} | memory, y)
        assert np.allclose(found["u"], u, rtol=1e-9, atol=1e-10 * scale)
        for name in memory:
            assert np.allclose(found[f"{name}{NEXT}"], following[name], rtol=1e-9, atol=1e-9 * scale)


def test_a_law_on_file_is_the_same_record(tmp_path: Path) -> None:
    for chain, kind, integrals in LAWS[:5]:
        law = law_of(chain, kind, integrals, limit=20)
        assert OutputFeedback.from_npz(law.to_npz(tmp_path / "law.npz")) == law
        assert pickle.loads(pickle.dumps(law)) == law
    assert "a kalman observer of 6 quantities, integrals of x" in str(law_of("plane", "kalman", True))
    plain = lqr(CHAINS["plane"]).law()
    with pytest.raises(OutputError, match="holds a StateFeedback, not a OutputFeedback"):
        OutputFeedback.from_npz(plain.to_npz(tmp_path / "plain.npz"))
    with np.load(law_of("plane").to_npz(tmp_path / "law.npz")) as archive:
        held = {name: archive[name] for name in archive.files}
    for name in ("correction", "gains"):
        np.savez(tmp_path / "altered.npz", **{key: value for key, value in held.items() if key != name})
        with pytest.raises(OutputError):
            OutputFeedback.from_npz(tmp_path / "altered.npz")


def test_what_cannot_be_observed_or_integrated_is_refused() -> None:
    gains, space = gains_of("plane"), gains_of("space")
    for call, words in (
        (lambda: estimator(gains, kind="luenberger"), "observer: is no kind of observer"),
        (lambda: estimator(lqr(CHAINS["plane"])), "sample: is what an observer needs"),
        (lambda: with_integrals(lqr(CHAINS["plane"]), {"x": 1.0}), "sample: is what integral action needs"),
        (lambda: with_integrals(gains, {"y": 1.0}), "integral: is no position of this chain"),
        (lambda: with_integrals(gains, {"x": -1.0}), "integral: is no positive weight"),
        (lambda: with_integrals(gains, {}), "integral: names nothing"),
        (lambda: with_integrals(gains, {"theta_1": 1.0}), "integral: cannot be held by u_0"),
        (lambda: with_integrals(gains, {"x": 1.0, "theta_1": 1.0}), "integral: cannot be held"),
        (lambda: estimator(space, Sensors(measured=("q_1_3",))), "moves only to second order"),
        (lambda: output_law(gains), "are both left out"),
        (lambda: output_law(gains, estimator(gains, Sensors(measured=("x", "theta_1"))), {"theta_2": 1.0}), "cannot be held|is not measured"),
    ):
        with pytest.raises(ControlError, match=words):
            call()


def test_records_that_do_not_fit_are_refused() -> None:
    law = law_of("plane", "kalman", True, limit=2.0)
    assert law.observer is not None
    for change, words in (
        ({"sample": 0.0}, "law.sample: is no time"),
        ({"offsets": (0.0,)}, "law.offsets: must hold finite numbers"),
        ({"low": (3.0,)}, "leave nothing for u_0"),
        ({"integrated": (9,)}, "law.integrated: are not all measured"),
        ({"observer": None}, "law.observer: does not lead from 3 measurements"),
        ({"wraps": (True,)}, "law.wraps: must hold 3 entries"),
    ):
        with pytest.raises(ArrayError, match=words):
            replace(law, **change)
    with pytest.raises(ArrayError, match="observer.correction"):
        replace(law.observer, correction=((1.0,),))


def test_a_memory_that_would_be_read_after_it_is_written_is_refused() -> None:
    """An expectation that is a bare estimate shares its cell with what the next line reads."""
    law = law_of("plane", "kalman")
    assert law.observer is not None
    still = replace(law.observer, advance=tuple(map(tuple, np.zeros((6, 6)))), drive=((0.0,),) * 6)
    with pytest.raises(EmissionError, match="is stored before what is computed of it"):
        output_feedback(replace(law, observer=still))
