"""Observers and integral action: against Riccati equations in 60 digits, in closed loop, and as compiled C with a memory."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import pickle
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import cont2discrete

from phichain import generate_controller
from phichain.control import Gains, Sensors, estimator, lqr, output_law, with_integrals
from phichain.control.equations.kalman import gathered
from phichain.emit.law import law_files
from phichain.errors import ArrayError, ControlError, EmissionError, OutputError
from phichain.ir import evaluate
from phichain.laws import OutputFeedback
from phichain.lowering.laws import NEXT, output_feedback, output_feedback_reset
from tests.control.closed_loop import after
from tests.handmade import planar, spatial
from tests.one_program import STRICT

PERIOD = 0.002
CHAINS = {
    "plane": planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart"),
    "space": spatial([0.2], [0.4], cart_mass=0.5),
}
KINDS = ("kalman", "reduced")
INTEGRALS = {"plane": {"x": 2.0}, "space": {"x_1": 1.0, "x_2": 0.5}}


@cache
def gains_of(chain: str) -> Gains:
    return lqr(CHAINS[chain], sample=PERIOD)


@cache
def law_of(chain: str, kind: str | None = "kalman", integrals: bool = False, **more: Any) -> OutputFeedback:
    gains = gains_of(chain)
    estimate = None if kind is None else estimator(gains, Sensors(), kind)
    return output_law(gains, estimate, INTEGRALS[chain] if integrals else None, [0.125] * CHAINS[chain].cart_size, **more)


LAWS = [(chain, kind, integrals) for chain in CHAINS for kind in (*KINDS, None) for integrals in (False, True) if kind or integrals]


@pytest.mark.parametrize("chain", CHAINS)
def test_the_kalman_filter_fulfils_its_equation_in_60_digits(chain: str) -> None:
    """The recursion of the covariance in mpmath, from what SciPy's solver leaves, ends at the record's correction."""
    gains = gains_of(chain)
    estimate = estimator(gains, Sensors(noise=0.01))
    n, m = len(gains.A), len(gains.A) // 2
    variances = [(1e-4 if name.startswith("x") else 2 * np.pi / 4096) ** 2 / 12 + 0.01**2 for name in estimate.measured]
    a, _ = held_exactly(gains.A, gains.B)
    rough = solve_discrete_are(np.array(a.tolist(), float).T, estimate.seen.T, added(gains.A, m), np.diag(variances))
    with mp.workdps(60):
        C, V, W, P = (mp.matrix(part.tolist()) for part in (estimate.seen, np.diag(variances), added(gains.A, m), rough))
        for _ in range(60):
            L = P * C.T * mp.inverse(C * P * C.T + V)
            P = a * (P - L * C * P) * a.T + W
        expected = np.array(L.tolist(), dtype=float)
    assert np.max(np.abs(estimate.L - expected)) < 1e-11 * np.max(np.abs(expected))
    kept = (np.eye(n) - estimate.L @ estimate.seen) @ estimate.advance
    assert np.allclose(np.sort(np.abs(np.linalg.eigvals(kept))), np.sort(np.exp(estimate.poles.real * PERIOD)), rtol=1e-9)


def held_exactly(A: np.ndarray, B: np.ndarray) -> tuple[mp.matrix, mp.matrix]:
    n, nu = B.shape
    with mp.workdps(60):
        whole = mp.zeros(n + nu)
        for i in range(n):
            for j in range(n + nu):
                whole[i, j] = mp.mpf(float(A[i, j] if j < n else B[i, j - n])) * mp.mpf(PERIOD)
        flow = mp.expm(whole)
        return flow[:n, :n], flow[:n, n:]


def added(A: np.ndarray, m: int) -> np.ndarray:
    """The integral of e^(A t) N e^(A^T t) by Gauss's rule, N the identity on the accelerations."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    N = np.diag([0.0] * m + [1.0] * m)
    flows = [expm(A * (1 + node) * PERIOD / 2) for node in nodes]
    return sum(weight * PERIOD / 2 * flow @ N @ flow.T for weight, flow in zip(weights, flows, strict=True))


@pytest.mark.parametrize("chain", CHAINS)
def test_what_noise_adds_is_its_integral(chain: str) -> None:
    A = lqr(CHAINS[chain], sample=PERIOD).A
    m = len(A) // 2
    found = gathered(A, np.diag([0.0] * m + [1.0] * m), PERIOD).high
    assert np.allclose(found, added(A, m), rtol=1e-12, atol=1e-16 * np.max(found))


@pytest.mark.parametrize("chain", CHAINS)
def test_the_reduced_observer_is_the_kalman_filter_of_exact_sensors(chain: str) -> None:
    gains = gains_of(chain)
    exact = estimator(gains, Sensors(resolution=0.0), "reduced")
    near = estimator(gains, Sensors(resolution=1e-9, disturbance=1.0), "kalman")
    assert np.allclose(exact.L, near.L, rtol=1e-5, atol=1e-5 * np.max(np.abs(near.L)))
    assert np.allclose(exact.seen @ exact.L, np.eye(len(exact.seen)), atol=1e-15)
    assert len(exact.poles) == len(gains.A) - len(exact.seen) and exact.spread.min() == 0
    # Its errors are those of the matrices that the law holds, which are zero beside its poles.
    errors = (np.eye(len(gains.A)) - exact.L @ exact.seen) @ exact.advance
    moving = np.sort(np.abs(np.linalg.eigvals(errors)))[len(exact.seen) :]
    assert np.allclose(moving, np.sort(np.exp(exact.poles.real * PERIOD)), rtol=1e-6)
    noisy = estimator(gains, Sensors(resolution=0.01), "reduced")
    assert noisy.poles[0].real > exact.poles[0].real


def test_a_part_of_the_positions_is_enough_where_it_shows_every_mode() -> None:
    gains = gains_of("plane")
    estimate = estimator(gains, Sensors(measured=("x", "theta_2")))
    errors = (np.eye(6) - estimate.L @ estimate.seen) @ estimate.advance
    assert np.max(np.abs(np.linalg.eigvals(errors))) < 1
    with pytest.raises(ControlError, match=r"measured: do not show the mode lambda = 0.*measure x too") as refused:
        estimator(gains, Sensors(measured=("theta_1", "theta_2")))
    assert refused.value.measured == ("theta_1", "theta_2", "x") and refused.value.margin < 1e-12


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


def result_of(folder: Path) -> int:
    """The result of the folder's self-test."""
    sources = [str(path) for path in folder.glob("*.c")]
    command = ["cc", *STRICT[:-2], "-O0", *sources, "-lm", "-o", str(folder / "t")]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.parametrize(
    ("chain", "kind", "integrals", "real"),
    [("plane", "kalman", True, "double"), ("space", "reduced", False, "float"), ("plane", None, True, "float")],
)
def test_the_folder_passes_its_own_test(chain: str, kind: str | None, integrals: bool, real: str, tmp_path: Path) -> None:
    law = law_of(chain, kind, integrals, limit=20)
    folder = generate_controller(law, tmp_path, real)
    assert result_of(folder) == 0
    record = json.loads((folder / "manifest.json").read_text())
    assert record["state_bytes"] == (8 if real == "double" else 4) * sum(law.memory.values())
    assert (record["observer"] is None) == (kind is None) and len(record["integrated"]) == (1 if integrals else 0)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("state->expected[1] = theta_1_next;", "state->expected[1] = 2.0F * theta_1_next;"),
        ("state->integral[0]\n        + (", "state->integral[0]\n        - ("),
        ("< 0.0F ? 0.0F :", "> 0.0F ? 0.0F :"),
        ("u_0_held", "u_0_wanted"),
        ("- 3.1415927F", "- 3.1415F"),
        ("state->expected[3] = 0.0F;", "state->expected[3] = 0.5F;"),
    ],
)
def test_mutants_of_the_c_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    for name, text in mutated().items():
        (tmp_path / name).write_text(text)
    source = tmp_path / "handmade_controller.c"
    text = source.read_text()
    assert right in text
    head, *rest = text.split(right)
    # The last place: of a name that is defined and used, a use.
    source.write_text(right.join([head, *rest[:-1]]) + wrong + rest[-1])
    assert result_of(tmp_path) > 0


@cache
def mutated() -> dict[str, str]:
    """The law of which the test above takes mutants."""
    return law_files(law_of("plane", "kalman", True, limit=20), "float")


@pytest.fixture(scope="module")
def in_c(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """A float law with observer and integral as a shared object."""
    folder = generate_controller(law_of("plane", "kalman", True, limit=20), tmp_path_factory.mktemp("c"), "float")
    library = folder / "law.so"
    source = str(folder / "handmade_controller.c")
    done = subprocess.run(["cc", *STRICT, source, "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


class InC:
    """The law in C with its memory, for one run."""

    def __init__(self, library: ctypes.CDLL, ny: int, kept: int, nu: int) -> None:
        self.library, self.state = library, (ctypes.c_float * kept)()
        self.y, self.u = (ctypes.c_float * ny)(), (ctypes.c_float * nu)()

    def reset(self, y: np.ndarray) -> None:
        self.y[:] = y
        self.library.handmade_controller_reset(self.state, self.y)

    def __call__(self, y: np.ndarray) -> np.ndarray:
        self.y[:] = y
        self.library.handmade_controller(self.state, self.y, self.u)
        return np.array(self.u)


def test_the_float_c_holds_the_chain_from_coarse_encoders(in_c: ctypes.CDLL) -> None:
    """A thousand counts a turn, half a millimetre, every two milliseconds: upright from 0.05 rad, as the record in double does."""
    law = law_of("plane", "kalman", True, limit=20)
    steps = np.array([5e-4, 2 * np.pi / 1000, 2 * np.pi / 1000])

    def seen(x: np.ndarray) -> np.ndarray:
        return np.round(x[:3] / steps) * steps

    start = np.array([0.0, np.pi + 0.05, -0.02, 0, 0, 0])
    emitted = InC(in_c, 3, sum(law.memory.values()), 1)
    emitted.reset(seen(start))
    ends = []
    for call in (lambda t, x: emitted(seen(x)), law.running(lambda y: np.round(y / steps) * steps)):
        x = start
        for k in range(1500):
            x = after(CHAINS["plane"], x, call(k * PERIOD, x), PERIOD)
        ends.append(x)
    assert np.max(np.abs(np.array(ends)[:, :3] - [0.125, np.pi, 0])) < 0.12
    assert np.allclose(*np.array(ends)[:, :3], atol=0.02)


def test_a_silent_sensor_leaves_the_estimate_to_its_model(in_c: ctypes.CDLL) -> None:
    law = law_of("plane", "kalman", True, limit=20)
    emitted, y = InC(in_c, 3, sum(law.memory.values()), 1), np.array(law.offsets) + [0.01, 0.02, -0.01]
    emitted.reset(y)
    memory = law.reset(y)
    for silent in ([np.nan, y[1], y[2]], [np.inf, np.nan, -np.inf], y):
        u, memory = law.step(memory, np.array(silent))
        assert np.all(np.isfinite(u)) and emitted(np.array(silent)) == pytest.approx(u, rel=2e-4)
    assert np.all(np.isfinite(list(emitted.state)))


@pytest.mark.parametrize(("chain", "kind", "integrals"), [("plane", "kalman", True), ("space", "reduced", True)])
def test_casadi_has_the_same_law(chain: str, kind: str, integrals: bool, tmp_path: Path) -> None:
    law = law_of(chain, kind, integrals, limit=20)
    folder = generate_controller(law, tmp_path)
    spec = importlib.util.spec_from_file_location(folder.name, folder / f"{folder.name}_casadi.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    function, start = (getattr(module, name)() for name in (folder.name, f"{folder.name}_reset"))
    draw = np.random.default_rng(1)
    for _ in range(5):
        y = np.array(law.offsets) + draw.normal(size=len(law.offsets))
        memory = {name: draw.normal(size=size) for name, size in law.memory.items()}
        u, following = law.step(memory, y)
        *kept, inputs = (np.array(part).ravel() for part in function(*memory.values(), y))
        assert inputs == pytest.approx(u, rel=1e-9)
        for name, part in zip(memory, kept, strict=True):
            assert part == pytest.approx(following[name], rel=1e-9, abs=1e-9)
        assert np.array(start(y)[0]).ravel() == pytest.approx(law.reset(y)["expected"], rel=1e-12, abs=1e-14)


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


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"measured": ("theta",)}, "measured: is nothing of this chain's state"),
        ({"measured": ()}, "measured: names nothing"),
        ({"measured": ("x", "x")}, "measured: names nothing, or something twice"),
        ({"resolution": -1.0}, "resolution: is negative"),
        ({"resolution": {"x": np.nan}}, "resolution: is not a finite number"),
        ({"resolution": {"theta_9": 0.1}}, "resolution: is nothing that it could be of"),
        ({"resolution": 0.0}, "leave a measurement without error"),
        ({"disturbance": 0.0}, "disturbance: leaves no stationary observer"),
    ],
)
def test_sensors_that_make_no_observer_are_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ControlError, match=words):
        estimator(gains_of("plane"), Sensors(**arguments))


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
