"""The law along a trajectory: record, Program at 50 digits, C with its self-test and mutants of it, what ends it, file."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import math
import subprocess
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from phichain import generate_swingup
from phichain.emit.stencil import stencils_folder
from phichain.errors import ArrayError, EmissionError, OutputError, SceneError
from phichain.ir import evaluate_exactly
from phichain.laws import Learning, ObserverAlong, StateFeedback, TrajectoryLaw
from phichain.lowering.trajectory import beginning, tracking
from tests.emit.test_stencil import COMPILERS, STRICT

COMPILE = ("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", "-Wconversion", "-Wdouble-promotion")


def law_of(nu: int = 1, rail: float = 1.0, **more: Any) -> TrajectoryLaw:
    """Numbers without any meaning, for a pole on a cart, perhaps with a torque at its joint too."""
    draw = np.random.default_rng(3)
    names, knots = ("x", "theta_1", "x_dot", "theta_dot_1"), 9
    gains = draw.normal(size=(knots, nu, 4))
    states = np.cumsum(draw.normal(size=(knots, 4)), axis=0) / 10
    states[-1], inputs = (0.25, np.pi, 0.0, 0.0), draw.normal(size=(knots, nu))
    inputs[-1] = 0
    catch = StateFeedback(
        "pole", "d" * 64, names, ("m", "rad", "m/s", "rad/s"), ("force", "torque_1")[:nu], ("N", "N m")[:nu], tuple(states[-1]),
        tuple(inputs[-1]), tuple(map(tuple, gains[-1])), (False, True, False, False), (-2.0,) * nu, (2.0,) * nu, 1e-3,
    )  # fmt: skip
    return TrajectoryLaw(catch, 0.03, states, inputs, gains, rail=rail, **more)


def observed(law: TrajectoryLaw) -> TrajectoryLaw:
    """The same reading two positions, through an observer without any meaning."""
    draw, (knots, nx), nu = np.random.default_rng(5), law.states.shape, law.inputs.shape[1]
    flows, drives = 0.1 * draw.normal(size=(knots, nx // 2, nx)), 0.1 * draw.normal(size=(knots, nx // 2, nu))
    return replace(law, observer=ObserverAlong(draw.normal(size=(knots, nx, nx // 2)), flows, drives))


def learning(law: TrajectoryLaw) -> TrajectoryLaw:
    """The same that estimates three parameters, and holds by what it has found."""
    draw, (knots, nx), nu = np.random.default_rng(6), law.states.shape, law.inputs.shape[1]
    learned, pushes, bends = draw.normal(size=(knots, 3, nx // 2)), 0.1 * draw.normal(size=(knots, nx // 2, 3)), 0.3 * draw.normal(size=(3, nx // 2, nx + nu))
    made = Learning(learned, pushes, bends, np.array([0.01, 0.04]), 0.3 * draw.normal(size=(nx, nx // 2)), draw.normal(size=(nx, nx // 2)), np.array([0.3, 0.4, 0.25]))
    seen = observed(law)
    assert seen.observer
    return replace(seen, observer=replace(seen.observer, learning=made))


def by_hermite(law: TrajectoryLaw, t: float, x: np.ndarray) -> list[Any]:
    """The law in mpmath, the cubic through divided differences; call within workdps."""
    h, catch = mp.mpf(law.interval), law.catch
    place = min(max(mp.mpf(t) / h, 0), len(law.states) - 1)
    j = min(int(place), len(law.states) - 2)
    s, half = (place - j) * h, law.states.shape[1] // 2
    wanted = [mp.mpf(0)] * (2 * half)
    for i in range(half):
        a, va, b, vb = (mp.mpf(float(law.states[k, c])) for k in (j, j + 1) for c in (i, half + i))
        slope = (b - a) / h
        second, third = (slope - va) / h, (vb - 2 * slope + va) / h**2
        wanted[i] = a + va * s + second * s**2 + third * s**2 * (s - h)
        wanted[half + i] = va + 2 * second * s + third * (3 * s**2 - 2 * h * s)
    found, f = [], place - j
    for k in range(len(catch.low)):
        u = (1 - f) * mp.mpf(float(law.inputs[j, k])) + f * mp.mpf(float(law.inputs[j + 1, k]))
        for i, at in enumerate(wanted):
            away = mp.mpf(float(x[i])) - at
            away -= 2 * mp.pi * mp.nint(away / (2 * mp.pi)) if catch.wraps[i] else 0
            u -= ((1 - f) * mp.mpf(float(law.gains[j, k, i])) + f * mp.mpf(float(law.gains[j + 1, k, i]))) * away
        found.append(min(max(u, mp.mpf(catch.low[k])), mp.mpf(catch.high[k])))
    return found


@pytest.mark.parametrize("nu", [1, 2])
def test_record_and_program_are_the_formula(nu: int) -> None:
    law, draw = law_of(nu), np.random.default_rng(1)
    program, limited = tracking(law), 0
    for t in (0.0, 0.011, 0.1, 0.2399):
        j, f = int(t / law.interval), Fraction(t) / Fraction(law.interval) - int(t / law.interval)
        rows = [[*law.states[k], *law.inputs[k], *law.gains[k].ravel()] for k in (j, j + 1)]
        for size in (0.01, 0.3, 3.0):
            x = law.reference(t)[0] + size * draw.normal(size=4) + np.array([0, 4 * np.pi, 0, 0])
            with mp.workdps(60):
                expected = by_hermite(law, t, x)
                share = [mp.mpf(f.numerator) / f.denominator]
                found = evaluate_exactly(program, {"x_meas": x, "here": rows[0], "next": rows[1], "f": share}, digits=60)["u"]
                assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < mp.mpf(10) ** -40
            if abs(x[0]) < 1 and size < 1:
                assert np.allclose(law(t, x), [float(u) for u in expected], rtol=0, atol=1e-12)
            limited += sum(abs(u) == 2 for u in expected)
    assert limited
    assert np.array_equal(law(9.0, law.states[-1]), law.catch.rest)


def result_of(folder: Path) -> int:
    sources = [str(path) for path in folder.glob("*.c")]
    made = subprocess.run([*COMPILE, *sources, "-lm", "-o", str(folder / "t")], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.parametrize(("real", "nu", "rail"), [("float", 1, 1.0), ("double", 2, math.inf)])
def test_the_folder_passes_its_own_test_and_says_what_it_takes(real: str, nu: int, rail: float, tmp_path: Path) -> None:
    law = law_of(nu, rail, note="Of 9 runs 8 hold.")
    folder = generate_swingup(law, tmp_path, real)
    assert folder.name == "pole_swingup" and result_of(folder) == 0
    record, header = json.loads((folder / "manifest.json").read_text()), (folder / "pole_swingup.h").read_text()
    size = 9 * (4 + nu + 4 * nu) * (4 if real == "float" else 8)
    assert record["kind"] == "swingup" and record["table_bytes"] == size and record["digest"] == "d" * 64
    assert f"_BYTES    {size} " in header and " * Of 9 runs 8 hold.\n" in header
    assert ("double" in (folder / "pole_swingup.c").read_text()) is False
    assert generate_swingup(law, tmp_path, real) == folder


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("- (pole_swingup_real)knot", "- 0"),
        ("at < last ? at : last", "at"),
        ("state->phase = at < last", "state->phase = at > last"),
        ("const pole_swingup_real x_step = next[0] - here[0]", "const pole_swingup_real x_step = next[0]"),
        ("3.0F * x_speeds", "2.0F * x_speeds"),
        ("(next[4] - here[4])", "(next[4])"),
        ("? knot + 1 : knot", "? knot : knot"),
        ("(here[8] + f * (next[8] - here[8]))", "here[8]"),
        ("floorf(", "("),
        ("? 2.0F", "? 2.5F"),
    ],
)
def test_mutants_of_the_c_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    folder = generate_swingup(law_of(), tmp_path)
    source = folder / "pole_swingup.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1))
    assert result_of(folder) > 0


def test_what_is_too_far_off_is_given_up_until_reset(tmp_path: Path) -> None:
    law = law_of()
    folder = generate_swingup(law, tmp_path, "double")
    library = folder / "law.so"
    subprocess.run(["cc", "-std=c99", "-shared", "-fPIC", str(folder / "pole_swingup.c"), "-lm", "-o", str(library)], check=True)
    loaded = ctypes.CDLL(str(library))
    call, state, u = loaded.pole_swingup, ctypes.c_int(7), (ctypes.c_double * 1)()

    def phase(t: float, x: np.ndarray) -> int:
        return int(call(ctypes.byref(state), ctypes.c_double(t), (ctypes.c_double * 4)(*x), u))

    swinging, holding, lost = 0, 1, 2
    near = law.reference(0.1)[0]
    bad = [(0.1, near + [0, 1.1, 0, 0]), (0.1, [1.01, *near[1:]]), (0.1, [-1.01, *near[1:]]), (math.nan, near)]
    bad += [(0.1, np.where(np.arange(4) == i, math.nan, near)) for i in range(4)]
    for t, x in bad:
        loaded.pole_swingup_reset(ctypes.byref(state))
        assert phase(0.1, near) == swinging and u[0] == pytest.approx(law(0.1, near)[0])
        assert phase(t, x) == lost and u[0] == 0.0
        assert phase(0.1, near) == lost and u[0] == 0.0
    loaded.pole_swingup_reset(ctypes.byref(state))
    assert phase(-5.0, law.states[0]) == swinging and u[0] == pytest.approx(law(-5.0, law.states[0])[0])
    assert phase(law.duration + 1e-9, law.states[-1]) == holding and phase(1e300, law.states[-1]) == holding
    assert law(0.1, near + [0, 1.1, 0, 0]) == 0.0 and law(0.1, [1.01, *near[1:]]) == 0.0


def test_a_law_on_file_is_the_same_record(tmp_path: Path) -> None:
    for law in (law_of(2, note="text"), law_of(1, math.inf), observed(law_of(2)), learning(law_of(2))):
        again = TrajectoryLaw.from_npz(law.to_npz(tmp_path / "law.npz"))
        assert again.catch == law.catch and again.rail == law.rail and again.note == law.note
        assert all(np.array_equal(getattr(again, name), getattr(law, name)) for name in ("states", "inputs", "gains"))
        assert (again.observer is None) == (law.observer is None)
        if law.observer:
            for kept, read in ((law.observer, again.observer), (law.observer.learning, again.observer.learning)):
                assert (kept is None) == (read is None)
                for name, value in vars(kept or {}).items() if kept else ():
                    assert isinstance(value, Learning | None) or np.array_equal(getattr(read, name), value)
    with pytest.raises(OutputError, match="no TrajectoryLaw can be read there"):
        TrajectoryLaw.from_npz(tmp_path / "none.npz")


def test_what_is_no_law_is_refused(tmp_path: Path) -> None:
    law = law_of()
    with pytest.raises(ArrayError, match="two knots or more"):
        replace(law, inputs=law.inputs[:-1])
    with pytest.raises(ArrayError, match="interval: is not positive"):
        replace(law, interval=0.0)
    with pytest.raises(ArrayError, match="does not end in the target"):
        replace(law, states=law.states[::-1])
    with pytest.raises(SceneError, match="is not one of the choices"):
        generate_swingup(law, tmp_path, "half")
    large = law.gains.copy()
    large[2, 0, 0] = 1e300
    with pytest.raises(EmissionError):
        generate_swingup(replace(law, gains=large), tmp_path, "float")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_stencils_compile_alone(compiler: str, tmp_path: Path) -> None:
    for name, feature in (("trajectory", "WITH_RAIL"), ("loop", "WITH_PARAMS")):
        for wanted, observed, learned in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1)):
            words = [f"-D{feature}={wanted}", f"-DWITH_OBSERVER={observed}", f"-DWITH_LEARNING={learned}", f"-DWITH_STEP={observed}", f"-I{stencils_folder()}", str(stencils_folder() / "laws" / f"{name}_alone.c")]
            done = subprocess.run([compiler, *STRICT, "-c", *words, "-o", str(tmp_path / "a.o")], capture_output=True, text=True, check=False)
            assert done.returncode == 0 and not done.stderr, done.stderr


@pytest.mark.parametrize("nu", [1, 2])
def test_an_observer_is_the_record_and_the_formula(nu: int) -> None:
    """The record's step, written with matrices; the Program in 60 digits; both over several calls, the memory handed on."""
    law, draw = observed(law_of(nu)), np.random.default_rng(2)
    assert law.observer is not None
    program, start = tracking(law), beginning(law)
    rows = [np.concatenate([part[k].ravel() for part in (law.states, law.inputs, law.gains, law.observer.corrections, law.observer.flows, law.observer.drives)]) for k in range(9)]
    y = law.states[0, :2] + [0.02, 4 * np.pi - 0.03]
    memory = law.reset(y)
    assert np.allclose(memory, [0.02, -0.03, 0, 0], atol=1e-12)
    begun = evaluate_exactly(start, {"y_meas": y, "here": rows[0]}, digits=60)["following"]
    assert np.allclose([float(value) for value in begun], memory, atol=1e-12)
    for t in (0.0, 0.011, 0.1, 0.2399, 0.3):
        y = law.reference(t)[0][:2] + 0.05 * draw.normal(size=2) + [0, 2 * np.pi]
        j = min(int(t / law.interval), 8)
        f = Fraction(min(t / law.interval, 8.0)) - j
        given = {"y_meas": y, "expected": memory, "here": rows[j], "next": rows[min(j + 1, 8)], "f": [float(f)]}
        found = evaluate_exactly(program, given, digits=60)
        # By matrices, from the definition.
        (x_r, u_r, K), mix = law.reference(t), lambda table: table[j] + float(f) * (table[min(j + 1, 8)] - table[j])  # noqa: B023
        z = memory + mix(law.observer.corrections) @ (np.remainder(y - x_r[:2] - memory[:2] + np.pi, 2 * np.pi) - np.pi)
        u = np.clip(u_r - K @ z, -2, 2)
        v = z[2:] + mix(law.observer.flows) @ z + mix(law.observer.drives) @ (u - u_r)
        wanted = np.concatenate([z[:2] + law.catch.sample / 2 * (z[2:] + v), v])
        pushed, memory = law.step(memory, t, y)
        for by in ((pushed, memory), tuple(np.array([float(value) for value in found[name]]) for name in ("u", "following"))):
            assert np.allclose(by[0], u, atol=1e-9) and np.allclose(by[1], wanted, atol=1e-9)
    assert law.step(memory, 0.1, [1.01, 0.0])[0] == pytest.approx(0)
    run = law.running(lambda y: np.round(y, 3))
    assert run(0.0, law.states[0]) == pytest.approx(law.step(law.reset(np.round(law.states[0, :2], 3)), 0.0, np.round(law.states[0, :2], 3))[0])


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("", ""),
        ("theta_1_away - expected[1]", "theta_1_away + expected[1]"),
        ("0.0005F * (x_dot_off + x_dot_next)", "0.001F * (x_dot_off + x_dot_next)"),
        ("force_held - t5", "force_held"),
        ("state->expected[i] = following[i]", "state->expected[i] = 0"),
    ],
)
def test_the_folder_of_an_observer_and_its_mutants(right: str, wrong: str, tmp_path: Path) -> None:
    folder = generate_swingup(observed(law_of()), tmp_path)
    source = folder / "pole_swingup.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1) if right else text)
    assert (result_of(folder) > 0) is bool(right)
    assert json.loads((folder / "manifest.json").read_text())["state_bytes"] == 4 + 4 * 4


@pytest.mark.parametrize("made", [law_of, lambda nu: observed(law_of(nu)), lambda nu: learning(law_of(nu))], ids=["state", "observer", "learning"])
def test_casadi_has_the_same_law(made: Callable[[int], TrajectoryLaw], tmp_path: Path) -> None:
    law, draw = made(2), np.random.default_rng(4)
    seen = law.observer is not None
    folder = generate_swingup(law, tmp_path, "double")
    spec = importlib.util.spec_from_file_location("pole_swingup_casadi", folder / "pole_swingup_casadi.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    given, before = module.pole_swingup(), np.zeros(law.remembered)
    for t in (-1.0, 0.0, 0.1, 0.2399, 0.24, 5.0):
        x = law.reference(t)[0] + 0.05 * draw.normal(size=4)
        if seen:
            found, off, following = given(t, x[:2], before)
            u, before = law.step(before, t, x[:2])
            assert np.allclose(np.array(following).ravel(), before, atol=1e-10)
        else:
            u = law(t, x)
            found, off = given(t, x)
        assert np.allclose(np.array(found).ravel(), u, atol=1e-10) and float(off) == pytest.approx((x - law.reference(t)[0])[1] ** 2)
    if seen:
        assert np.allclose(np.array(module.pole_swingup_reset()(x[:2])).ravel(), law.reset(x[:2]), atol=1e-12)
