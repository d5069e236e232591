"""The rules of a run in C, each asked by itself: which steps are taken, and whether a function may have come to zero where its signs do not say so."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from phichain.emit.stencil import stencils_folder
from phichain.native.flows.desk import Desk, desk_fields, event_fields, offsets, row_fields
from tests.emit.test_stencil import STRICT

SOURCE = """#define PHI_Q 2
#define PHI_CART 0
#include "orbits/alone.c"
int phi_propagate(phi_flow *flow, phi_real t_end, unsigned long most, const phi_real *u, phi_real *q, phi_real *v)
{
    const phi_real omega = BRAKE_HALF_PI / t_end;
    (void)most;
    (void)u;
    q[0] -= 0.3;
    q[1] -= omega;
    v[0] = 0;
    v[1] = omega / t_end;
    flow->steps = 1;
    return PHI_FLOW_DONE;
}
void phi_mass_matrix(const phi_real *q, phi_real *mass) { (void)q; mass[0] = mass[3] = 1; mass[1] = mass[2] = 0; }
int judged(brake_desk *desk, phi_real *next);
int may_dip(brake_desk *desk, int k);
int corrected(brake_desk *desk, phi_real allowed);
int located(brake_desk *desk, int k);
int judged(brake_desk *desk, phi_real *next) { return run_judged(desk, next); }
int may_dip(brake_desk *desk, int k) { return dip_may_dip(desk, k); }
int corrected(brake_desk *desk, phi_real allowed) { phi_flow begun = {0}; brake_correct(&begun, desk, allowed); return desk->orbit.converged > 0; }
int located(brake_desk *desk, int k) { phi_flow begun = {0}; met_line(desk); return met_located(&begun, desk, k); }
"""
"""Beside the rules a chain whose brake orbits are a straight line, (0.3, omega): its end of a quarter is q_0 less that."""
ON, SIGN, SMALL = 0, 2, 3
WHOLE = offsets(desk_fields(2, 2))


@pytest.fixture(scope="module")
def rules(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("rules")
    (folder / "rules.c").write_text(SOURCE)
    strict = [word for word in STRICT if not word.startswith("-Wmissing")]
    words = ["cc", *strict, "-Wno-unused-function", f"-I{stencils_folder()}", "-O2", "-shared", "-fPIC", str(folder / "rules.c"), "-o", str(folder / "rules.so"), "-lm"]
    subprocess.run(words, check=True)
    return ctypes.CDLL(str(folder / "rules.so"))


def judged(rules: Any, step: float, before: float, changed: float = 0.1, change: tuple[float, float, float] = (1.0, 1.0, 1.0), **more: float) -> tuple[int, float]:
    """What becomes of a step behind one of a length, and the step to try next."""
    memory = np.zeros(max(end for _, end, _ in WHOLE.values()))
    desk, following = Desk(memory, WHOLE), ctypes.c_double()
    said = {"step": step, "moved": step, "turned": 1.0, "max_angle": 0.3, "aim_angle": 0.1, "max_change": 0.7, "step_min": 1e-7, "step_max": 100.0, "changed": changed,
            "most_corrections": 7.0, "count": 2.0} | more
    for name, value in said.items():
        desk[name].fill(value)
    desk["at"][1], desk["change"][...] = before, np.diag(change)
    return rules.judged(ctypes.c_void_p(memory.ctypes.data), ctypes.byref(following)), following.value


def test_a_leap_that_changes_no_sign_is_refused(rules: Any) -> None:
    """Usual steps are at most twice as long as the one before, and one that changes the sign has leapt over one place."""
    assert judged(rules, 2.1, 1.0)[0] == ON and judged(rules, 2.3, 1.0)[0] == SMALL
    assert judged(rules, 2.3, 1.0, 2.5, (-1.5, 1.0, 1.0))[0] == SIGN
    assert judged(rules, 2.3, 1.0, count=1.0)[0] == ON


def test_steps_shorter_than_gaps_are_believed(rules: Any) -> None:
    """Whether the sign changes in them, or the Jacobian does by more than is allowed."""
    for change in ((-1.5, 1.0, 1.0), (3.5, 1.0, 1.0)):
        assert judged(rules, 2.9e-6, 2.9e-6, 2.5, change)[0] == ON
    assert judged(rules, 3.1e-6, 3.1e-6, 2.5, (-1.5, 1.0, 1.0))[0] == SIGN and judged(rules, 3.1e-6, 3.1e-6, 2.5, (3.5, 1.0, 1.0))[0] == SMALL
    assert judged(rules, 1.0, 1.0, 0.69, (1.69, 1.0, 1.0))[0] == ON and judged(rules, 1.0, 1.0, 0.71, (1.71, 1.0, 1.0))[0] == SMALL


def test_a_singular_place_ahead_is_leapt_over(rules: Any) -> None:
    """[J; t] that halves in a step vanishes a step ahead: 1.8 of that, unless it is longer than steps may be; far off the run goes on as it would."""
    assert judged(rules, 1.0, 1.0, 0.5, (0.5, 1.0, 1.0))[1] == pytest.approx(1.8)
    assert judged(rules, 1.0, 1.0, 0.5, (0.5, 1.0, 1.0), step_max=1.7)[1] == pytest.approx(0.7)
    assert judged(rules, 1.0, 1.0, 0.25, (0.75, 1.0, 1.0))[1] == pytest.approx(5.4) and judged(rules, 1.0, 1.0, 0.21, (0.9, 1.0, 1.0))[1] == pytest.approx(2.0)


JACOBIAN = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -1.0]])
ALONG = np.array([0.0, 1.0, 1.0]) / np.sqrt(2)


def desk_of_a_line() -> tuple[Any, Desk]:
    """The address of a desk, and the desk, where the straight line is followed."""
    memory = np.zeros(max(end for _, end, _ in WHOLE.values()))
    desk = Desk(memory, WHOLE)
    said = {"scale": 1.0, "tolerance": 1e-12, "rough": 1e-12, "most_steps": 10.0, "tol": 1e-12, "trust": 1e-8, "most_corrections": 7.0}
    for name, value in said.items():
        desk[name].fill(value)
    desk["before_tangent"][:] = desk["normal"][:] = ALONG
    return ctypes.c_void_p(memory.ctypes.data), desk


def test_a_guess_at_which_the_jacobian_has_changed_too_far_is_left_at_once(rules: Any) -> None:
    """A tenth more than is allowed; where the sign has changed, or all is allowed, Newton goes on."""
    def asked(before: np.ndarray, allowed: float) -> tuple[int, int]:
        at, desk = desk_of_a_line()
        desk["guess"][:] = 0.31, 1.0, 1.0
        desk["before_jacobian"][:] = before
        return rules.corrected(at, ctypes.c_double(allowed)), int(desk["evaluations"])

    assert asked(JACOBIAN / 1.76, 0.7)[0] == 1
    assert asked(JACOBIAN / 1.78, 0.7) == (0, 1)
    assert asked(JACOBIAN / 1.78, 0.0)[0] == 1 and asked(np.diag([-1, 1]) @ JACOBIAN / 1.78, 0.7)[0] == 1


@pytest.mark.parametrize(("place", "taken", "is_end"), [(0.3, 2, False), (0.7, 2, True), (0.7, 0, True), (0.3, 0, False)])
def test_a_zero_beside_all_tries_is_told_by_the_nearer_end(rules: Any, place: float, taken: int, is_end: bool) -> None:
    """Whose row is of this run: its first step begins at one that is not. Nothing but that row says anything here."""
    at, desk = desk_of_a_line()
    ends = np.array([0.3, 1.0, 1.0]) + np.outer([0.0, 1.0], ALONG)
    values = ends[:, 1] - (1 + place * ALONG[1])
    desk["count"].fill(2)
    desk["seen"].fill(2)
    desk["watched"].fill(2)
    desk["taken"].fill(taken)
    desk["at"][:2], desk["sigmas"][:2], desk["known"][:2, 0], desk["known"][:2, 1] = (0, 1), 1, ends, ALONG
    desk["watch"][0], desk["watch"][1], desk["values"][:2, 1] = (4, 0, 0, 0, 0), (1, 1, 1 + place * ALONG[1], 0, 0), values
    desk["rows"].fill(np.nan)
    row, event = offsets(row_fields(2, 2)), offsets(event_fields(2, 2))
    if is_end or taken:
        nearer = desk["rows"][taken if is_end else taken - 1]
        nearer[row["arclength"][0]], nearer[row["values"][0] + 1], nearer[row["orbit"][0] :] = float(is_end), values[int(is_end)], 0
    is_told = is_end or taken > 0
    assert rules.located(at, 1) == is_told and desk["met"] == is_told
    if is_told:
        told = desk["events"][0]
        assert [told[event[name][0]] for name in ("before", "which", "arclength", "left")] == pytest.approx([taken, 1, place, 0], abs=1e-14)
        begin, end, _ = event["y"]
        assert told[begin:end] == pytest.approx(ends[0] + place * ALONG, abs=1e-14)


Function = Callable[[np.ndarray], np.ndarray]


def may_dip(rules: Any, places: np.ndarray, f: Function, slope: Function, component: bool) -> bool:
    """Whether something may lie in the last step but one of a run along y = (x, f(x), 0): of the tangent's second component, or of f itself as a function of the arclength x."""
    memory = np.zeros(max(end for _, end, _ in WHOLE.values()))
    desk, count = Desk(memory, WHOLE), len(places)
    along = np.stack([np.ones(count), slope(places), np.zeros(count)], axis=1)
    lengths = np.linalg.norm(along, axis=1)
    fine = np.linspace(places[0], places[-1], 20001)
    speed = np.hypot(1, slope(fine))
    arc = np.interp(places, fine, np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(fine))]))
    desk["known"][:count, 0] = np.stack([places, f(places), np.zeros(count)], axis=1)
    desk["known"][:count, 1] = along / lengths[:, None]
    desk["count"].fill(count)
    desk["seen"].fill(count)
    desk["at"][:count], desk["values"][:count, 0] = (arc, slope(places) / lengths) if component else (places, f(places))
    desk["watch"][0] = (0, 1, 0, 2, 1) if component else (5, 0, 0, 1, 1)
    return bool(rules.may_dip(ctypes.c_void_p(memory.ctypes.data), 0))


@pytest.mark.long
@pytest.mark.parametrize("component", [True, False])
def test_no_pair_of_zeros_is_passed_over_and_few_steps_are_looked_at_in_vain(rules: Any, component: bool) -> None:
    """Random waves, steps of up to a fifth of one: every pair within the last step but one has somebody look, though signs at its ends are one."""
    rng, missed, pairs, clear, looked = np.random.default_rng(11), 0, 0, 0, 0
    for _ in range(6000):
        level, phase, slow = rng.choice([-1, 1]) * rng.uniform(0.7, 1.3), rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.6)
        places = np.cumsum(rng.uniform(0.5, 1.2, 5))

        def wave(x: np.ndarray, level: float = level, phase: float = phase, slow: float = slow) -> np.ndarray:
            return 0.5 * (np.sin(x + phase) - level + 0.3 * np.cos(slow * x))

        def integral(x: np.ndarray, level: float = level, phase: float = phase, slow: float = slow) -> np.ndarray:
            return 0.5 * (-np.cos(x + phase) - level * x + 0.3 * np.sin(slow * x) / slow)

        def change(x: np.ndarray, phase: float = phase, slow: float = slow) -> np.ndarray:
            return 0.5 * (np.cos(x + phase) - 0.3 * slow * np.sin(slow * x))

        inside = wave(np.linspace(places[-3], places[-2], 400))
        if inside[0] * inside[-1] <= 0:
            continue
        f, slope = (integral, wave) if component else (wave, change)
        is_told = may_dip(rules, places, f, slope, component)
        has_pair = bool(np.any(inside * inside[0] < 0))
        pairs, missed = pairs + has_pair, missed + (has_pair and not is_told)
        clear, looked = clear + (not has_pair), looked + (is_told and not has_pair)
    assert (missed, pairs > 30) == (0, True), (missed, pairs, looked, clear)
    assert looked < 0.1 * clear
