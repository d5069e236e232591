"""Neighbours that fly beside the steps of a Taylor run: the run is the same to the last bit, and what they say of its errors is true."""

from __future__ import annotations

import gc
import pickle
import weakref
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import build
from phichain.motion import simulate
from phichain.motion.error.measure import Measure
from phichain.native import build_folder
from phichain.native.flows import beside as judged
from phichain.native.flows import motion
from phichain.native.flows.beside import Beside
from phichain.scene import Scene
from phichain.system import System
from phichain.system.propagation import Stop

WANT = ("forward_dynamics", "propagate")
PAIR = {"mass": [1.0, 0.6], "length": [1.0, 0.7], "want": WANT}
ROD: dict[str, Any] = {"com": [0.4, 0.7], "inertia": [0.02, 0.01]}
SCENES = {
    scene.name: scene
    for scene in (
        Scene("plain", 2, **PAIR),
        Scene("geared_cart", 2, base="cart", cart_mass=1.5, cart_damping=0.1, armature=0.05, **PAIR | ROD),
        Scene("sprung", 2, stiffness=2.0, damping=0.02, friction=0.02, friction_speed=0.5, actuated="all", **PAIR | ROD | {"mass": "runtime"}),
        Scene("ball", 2, "spatial", **PAIR),
        Scene("flying", 2, "spatial", "cart", cart_mass=1.5, **PAIR | ROD),
    )
}
REFERENCE = Path(__file__).parents[3] / "generated" / "reference" / "planar2"
TIMES = np.linspace(0.0, 16.0, 65)


@cache
def system(name: str) -> System:
    return build(SCENES[name], prove=False)


def start(of: System) -> np.ndarray:
    rng = np.random.default_rng(3)
    if of.is_planar:
        return rng.normal(size=of.nx)
    q, v = rng.normal(size=of.nq), rng.normal(size=of.nv)
    for k in range(of.cart_size, of.nq, 3):
        q[k : k + 3] /= np.linalg.norm(q[k : k + 3])
        v[k : k + 3] -= q[k : k + 3] * (q[k : k + 3] @ v[k : k + 3])
    return np.concatenate([q, v])


def run(of: System, tol: float | None, times: np.ndarray = TIMES, **options: Any) -> Any:
    if of.nu:
        options["u"] = np.array([0.3, -0.2])[: of.nu]
    if of.numbers.mass == "runtime":
        options["p"] = {"mass": [1.0, 0.6]}
    return simulate(of, start(of), times, "taylor", tol, **options)


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_the_same_to_the_last_bit(name: str) -> None:
    of = system(name)
    for tol in (None, 1e-7):
        along, alone = run(of, tol), run(of, tol, error_estimate=False)
        assert np.array_equal(along.x, alone.x) and along.counts == alone.counts
    own, grid = run(of, 1e-7, TIMES[[0, -1]]), np.linspace(0.0, 16.0, 7)
    assert len(own.error) == len(own.t) > 65
    assert np.array_equal(own.resample(grid).x, run(of, 1e-7, TIMES[[0, -1]], error_estimate=False).resample(grid).x)


@pytest.mark.parametrize("tol", [1e-6, 1e-9])
@pytest.mark.parametrize("name", SCENES)
def test_estimates_are_those_against_a_run_at_round_off(name: str, tol: float) -> None:
    """Between a tenth and the twentyfold, wherever the finer run is much finer."""
    of = system(name)
    rough, fine = run(of, tol), run(of, None)
    true = Measure.of(of, rough.x)(rough.x - fine.x)
    seen = (true > 30 * fine.error) & (true < 0.1)
    ratio = rough.error[seen] / true[seen]
    assert seen.sum() > 20
    assert np.all((ratio > 0.1) & (ratio < 20)) and 0.3 < np.median(ratio) < 4


def test_neighbours_of_a_stiffly_sprung_chain_do_not_grow_by_themselves() -> None:
    """Over tens of thousands of steps without chaos, in which what a low order leaves out of each would add up to a thousandfold."""
    springs = {"stiffness": [15.3, 11692.4], "gravity": 9.81, "mass": [1.376, 1.038], "length": [1.963, 0.617], "com": [1.961, 0.293]}
    of, x0, times = build(Scene("stiff", 2, want=WANT, **springs), prove=False), np.array([0.14, -0.68, -0.41, 1.35]), np.linspace(0.0, 30.0, 31)
    rough, fine = (simulate(of, x0, times, "taylor", tol) for tol in (1e-9, None))
    true = Measure.of(of, rough.x)(rough.x - fine.x)[20:]
    assert rough.counts["steps"] > 30000 and np.all(true > 30 * fine.error[20:])
    assert np.all((rough.error[20:] > 0.3 * true) & (rough.error[20:] < 10 * true))


WOUND = {
    "pair_1": ({"mass": [0.876, 1.835], "length": [1.923, 1.402], "com": [1.028, 1.136]}, [1.325357378837742, -2.16523490975777, 0.8826125909396209, -0.21569870012135894]),
    "pair_2": ({"mass": [0.775, 1.022], "length": [1.428, 1.483], "com": [1.409, 1.033], "gravity": 1.62}, [-2.167566937179801, -1.332273739120682, 0.0, 0.0]),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(("name", "until"), [("pair_1", 36.0), ("pair_2", 58.0)])
def test_what_is_lost_is_as_far_off_as_the_motion_winds_up_by_since_then(name: str, until: float) -> None:
    """Not by all of it: angles here have wound up to 28 and 46 rad by the time that a run is lost, at errors of 0.05 and 0.4."""
    keys, x0 = WOUND[name]
    of, times = build(Scene(name, 2, want=WANT, **keys), prove=False), np.arange(0.0, until + 1, 2.0)
    rough, fine = (simulate(of, x0, times, "taylor", tol) for tol in (1e-6, None))
    true = Measure.of(of, rough.x)(rough.x - fine.x)[1:]
    ratio = rough.error[1:] / true
    assert fine.error[-1] < 1e-3 * true[-1] and rough.error[-1] > 1.0 and np.max(np.abs(rough.x)) > 20.0
    assert np.all((ratio > 0.1) & (ratio < 100))


RETURNING = {
    "back_1": ({"mass": [0.473, 0.414], "length": [1.425, 0.848], "gravity": 9.8}, [-2.174984876561223, 0.36491377241597434, 0.0, 0.0], 26.0),
    "back_2": ({"mass": [0.876, 1.835], "length": [1.923, 1.402], "com": [1.028, 1.136]}, [2.444681936053664, -0.3836194334367029, -0.8888487631383244, 0.029893407949824424], 22.0),
    "aside": (
        {"links": 3, "mass": [0.805, 0.623, 0.491], "length": [0.824, 1.633, 1.459], "com": [0.659, 1.503, 0.608], "gravity": 1.62},
        [0.519147529692443, -2.1506821307941766, -0.7588241031756633, 0.0, 0.0, 0.0], 30.0,
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", RETURNING)
def test_errors_as_large_as_the_motion_are_known_and_come_back(name: str) -> None:
    """Two fall from 0.5 to 0.05 and from 0.3 to 0.03 again, where neighbours once ran off along steps too long for them; one was small, as its errors all but cancel."""
    keys, x0, until = RETURNING[name]
    of, times = build(Scene(name, **{"links": 2, "gravity": 9.81, "want": WANT, **keys}), prove=False), np.arange(0.0, until + 1, 2.0)
    rough, fine = (simulate(of, x0, times, "taylor", tol) for tol in (1e-6, None))
    true = Measure.of(of, rough.x)(rough.x - fine.x)[1:]
    ratio = rough.error[1:] / true
    assert fine.error[-1] < 1e-3 * true[-1] and np.max(true) > 0.3
    assert np.all((ratio > 0.3) & (ratio < 60))


def test_errors_at_round_off_are_neither_none_nor_large() -> None:
    for name in SCENES:
        error = run(system(name), None).error
        assert 1e-16 < error[-1] < 1e-5


def test_they_go_on_where_a_run_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Progress is told after every thousand steps: neighbours fly on; and where memory is short, errors of the first pieces are not forgotten."""
    of, times, told = system("plain"), np.linspace(0.0, 60.0, 31), list[float]()
    whole, cut = run(of, None, times), run(of, None, times, progress=lambda done, t: told.append(done))
    assert len(told) > 1
    assert np.all(cut.error > 0) and 0.01 < cut.error[8] / whole.error[8] < 100
    monkeypatch.setattr(motion, "ROOM", 2**10)
    own = of.propagate(start(of)[:2], start(of)[2:], 0.0, 8.0, 1e-9, own=True, beside=(beside := of.propagate.beside()))
    assert len(own.t_at) > 2**10 // 40 and beside.errors.shape == (len(own.t_at) + 1, 2) and np.all(beside.errors > 0)
    assert np.array_equal(beside.errors[-1], beside.errors[-2])


def test_a_call_of_no_step_ends_with_the_errors_of_the_last_one() -> None:
    of = system("plain")
    beside, longer = of.propagate.beside(), of.propagate.beside()
    for one in (beside, longer):
        found = of.propagate(start(of)[:2], start(of)[2:], 0.0, 8.0, 1e-9, beside=one)
    of.propagate(found.q, found.v, 8.0, 8.0, 1e-9, lost=found.lost, beside=longer)
    assert beside.errors.shape == (1, 2) and np.all(beside.errors > 0) and np.array_equal(longer.errors, beside.errors)


@pytest.mark.parametrize("name", ["plain", "ball", "flying"])
def test_steps_that_fill_their_room_change_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The flow goes on as if it had not stopped, to the last bit: whole turns and unit vectors included."""
    of, times, found = system(name), np.linspace(0.0, 16.0, 33)[1:], []
    for room in (2**20, 2**10):
        monkeypatch.setattr(motion, "ROOM", room)
        fresh, beside = build(SCENES[name], prove=False), of.propagate.beside()
        x = start(of)
        x[-1] += 10.0 * of.is_planar
        flown = fresh.propagate(x[: of.nq], x[of.nq :], 0.0, 16.0, 1e-9, times=times, beside=beside)
        found.append((flown.q_at, flown.v_at, flown.q, flown.v, flown.t, flown.lost, beside.errors))
    assert all(np.array_equal(one, other) for one, other in zip(*found, strict=True)) and len(found[0][-1]) == 33


@pytest.mark.parametrize("name", ["sprung", "ball"])
def test_steps_beyond_what_is_kept_are_judged_on_the_way(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the same errors, to the last bit; and no frame that waits for the next run keeps the steps of the last one."""
    of, monkey, found = system(name), monkeypatch.setattr, []
    monkey(motion, "ROOM", 2**10)
    for most in (2**26, 2**13):
        monkey(judged, "MOST_BYTES", most)
        beside, given = of.propagate.beside(), {"p": {"mass": [1.0, 0.6]}, "u": [0.3, -0.2]} if of.nu else {}
        fresh = start(of)
        of.propagate(fresh[: of.nq], fresh[of.nq :], 0.0, 16.0, 1e-9, beside=beside, times=np.linspace(0.0, 16.0, 33)[1:], **given)
        kept = sum(piece.nbytes for piece in beside._pieces)
        assert (kept <= 2**13) == (most == 2**13)
        found.append((beside.errors, beside.errors))
    assert np.array_equal(found[0][0], found[1][0]) and len(found[1][1]) == 33 and np.all(found[0][0] > 0)
    gone = weakref.ref(beside)
    del beside
    gc.collect()
    assert gone() is None


def test_a_run_of_many_steps_needs_no_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    of, x, beside = system("plain"), start(system("plain")), system("plain").propagate.beside()
    monkeypatch.setattr(motion, "ROOM", 2**10)
    alone, along = of.propagate(x[:2], x[2:], 0.0, 8.0, 1e-9), of.propagate(x[:2], x[2:], 0.0, 8.0, 1e-9, beside=beside)
    assert np.array_equal(along.q, alone.q) and along.steps == alone.steps > 2**10 // 40 and beside.errors.shape == (1, 2)


@pytest.mark.parametrize("name", ["plain", "geared_cart"])
def test_errors_of_steps_are_those_against_steps_at_round_off(name: str) -> None:
    """With their signs: what a series leaves, measured by where the flow at round-off goes from the same state in the same time."""
    of = system(name)
    beside, given = of.propagate.beside(), {"u": np.array([0.3, -0.2])[: of.nu]} if of.nu else {}
    of.propagate(start(of)[: of.nq], start(of)[of.nq :], 0.0, 8.0, 1e-6, own=True, beside=beside, **given)
    steps, ratios = beside._pieces[0], []
    for step in steps[:60]:
        x, error = step[4 : 4 + of.nx], step[4 + of.nx : 4 + 2 * of.nx]
        rough, fine = (of.propagate(x[: of.nq], x[of.nq :], 0.0, step[2], tol, max_steps=many, **given) for tol, many in ((1e-6, 1), (1e-16, 100)))
        true = np.concatenate([rough.q - fine.q, rough.v - fine.v])
        ratios += (error / np.where(np.abs(true) > 1e-13, true, np.nan)).tolist()
    seen = np.array(ratios)[np.isfinite(ratios)]
    assert len(seen) > 50 and np.all(np.abs(np.quantile(seen, (0.25, 0.5, 0.75)) - 1) < 0.15)


@pytest.mark.parametrize("cut", ["an event", "columns"])
def test_steps_that_are_cut_are_measured_where_they_end(cut: str) -> None:
    """By an event or by columns of derivatives: what is said at the end is what uncut steps say."""
    of = build(Scene("varied", 2, variational=True, **PAIR), prove=False)
    x, more = start(of), {"stop": Stop("v", 0)} if cut == "an event" else {"transition": np.eye(4)}
    beside, alone = of.propagate.beside(), of.propagate.beside()
    found = of.propagate(x[:2], x[2:], 0.0, 8.0, 1e-9, beside=beside, **more)
    of.propagate(x[:2], x[2:], 0.0, found.t, 1e-9, beside=alone)
    assert np.all(beside.errors < 100 * alone.errors + 1e-16) and np.all(beside.errors > alone.errors / 100)


def test_no_run_is_of_a_lower_order_than_its_neighbours() -> None:
    """Which read coefficients of the path up to order 5."""
    for of in (system("plain"), build(Scene("single", 1, mass=1.0, length=1.0, want=WANT), prove=False)):
        q, v = np.full((2, of.nq), 0.5)
        assert of.propagate(q, v, 0.0, 1.0, 1.0).order > 5


def test_neighbours_that_are_no_numbers_are_as_far_off_as_can_be() -> None:
    of = system("plain")
    beside = of.propagate.beside()
    of.propagate(start(of)[:2], start(of)[2:], 0.0, 8.0, 1e-9, beside=beside)
    beside._pieces[0][7, 4:] = np.nan
    assert np.all(beside.errors[-1] == np.inf)


def test_what_is_lost_stays_lost() -> None:
    found = run(system("plain"), 1e-6, np.linspace(0.0, 200.0, 101))
    assert found.status == "doubtful" and found.error[-1] > 0.5 and np.all(np.diff(found.error[found.error > 0.5]) >= 0)


def test_a_generated_folder_has_none_and_is_judged_by_a_second_run() -> None:
    of = build_folder(REFERENCE)
    assert not hasattr(of.propagate, "beside")
    x0, u = np.array([2.0, 0.5, 0.0, 0.0]), np.zeros(2)
    rough, fine = (simulate(of, x0, TIMES, "taylor", tol, u=u) for tol in (1e-7, None))
    true = Measure.of(of, rough.x)(rough.x - fine.x)
    seen = true > 30 * fine.error
    assert seen.sum() > 20 and np.all((rough.error[seen] > 0.2 * true[seen]) & (rough.error[seen] < 20 * true[seen]))


def test_a_run_that_nobody_asks_flies_no_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """And whoever asks, once or after a journey, is told the same."""
    flown, found = [], Beside._further
    monkeypatch.setattr(Beside, "_further", lambda beside, pieces: flown.append(len(pieces)) or found(beside, pieces))
    unread, read, sent = (run(system("plain"), 1e-9) for _ in range(3))
    assert not flown
    verdict = read.error, read.status, read.reason, read.holds_until
    arrived = pickle.loads(pickle.dumps(sent))
    assert np.array_equal(arrived.error, verdict[0]) and (arrived.status, arrived.reason, arrived.holds_until) == verdict[1:]
    assert np.array_equal(read.error, verdict[0]) and flown == [1, 1]
    assert np.array_equal(unread.resample(TIMES[::4]).error, verdict[0][::4]) and flown == [1, 1, 1]
