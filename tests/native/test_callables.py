"""Callables of compiled functions: values, shapes, types, batches, threads."""

from __future__ import annotations

import inspect
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from phichain.errors import ArrayError
from phichain.native import Cache, build_folder
from phichain.system import System
from tests.native.evaluation import Q, U, V, assert_close, evaluated
from tests.native.generated_folder import FUNCTIONS, PARAMETERS, SOURCE, expected, write


def test_system_carries_the_scene(system: System) -> None:
    assert (system.name, system.space, system.base, system.links) == ("duo", "planar", "fixed", 2)
    assert (system.nq, system.nv, system.nu, system.real) == (2, 2, 2, "double")
    assert system.q_names == ("theta_1", "theta_2")
    assert system.params is None
    assert set(FUNCTIONS) <= set(system.functions)


def test_single_state(system: System) -> None:
    assert_close(evaluated(system, Q, V, U, 0.125), expected(Q, V, U, 0.125))


def test_function_without_parameters(system: System) -> None:
    for keywords in ({}, {"p": PARAMETERS}, {"p": None}):
        mass, gravity, _ = system.linearization([1, -1], **keywords)
        np.testing.assert_array_equal(mass, np.diag([1.0, -1.0]))
        np.testing.assert_array_equal(gravity, np.diag([2.0, -2.0]))


def test_results_are_the_caller_s_own(system: System) -> None:
    first = system.forward_dynamics(Q, V, U, p=PARAMETERS)
    kept = first.copy()
    system.forward_dynamics(2 * Q, V, U, p=PARAMETERS)
    np.testing.assert_array_equal(first, kept)
    kinetic, _ = system.energy(Q, V, p=PARAMETERS)
    system.energy(Q, 2 * V, p=PARAMETERS)
    assert kinetic == system.energy(Q, V, p=PARAMETERS)[0]


@pytest.mark.parametrize(
    "convert",
    [
        list,
        tuple,
        lambda a: a.astype(">f8"),
        lambda a: a.astype(np.float32),
        lambda a: a.astype(np.longdouble),
        lambda a: np.repeat(a, 3)[::3],
        lambda a: np.frombuffer(b"\0" + a.tobytes(), dtype=np.uint8)[1:].view(np.float64),
    ],
    ids=["list", "tuple", "big-endian", "float32", "long double", "strided", "unaligned"],
)
def test_whatever_converts_within_its_kind_is_taken(system: System, convert: Any) -> None:
    q, v, u = np.array([0.5, -0.25]), np.array([1.5, 2.0]), np.array([-3.0, 0.125])
    assert_close(evaluated(system, convert(q), convert(v), convert(u), 0.5), expected(q, v, u, 0.5))


def test_integers_are_numbers(system: System) -> None:
    q, v, u = np.array([1, 2]), [3, 4], np.array([5, 6], dtype=np.uint8)
    assert_close(evaluated(system, q, v, u, 1), expected(q, np.array(v), u, 1))


def test_float_scene_computes_in_float(float_system: System) -> None:
    got = evaluated(float_system, Q, V.astype(np.float32), U, 0.125)
    assert_close(got, expected(Q, V, U, 0.125), rtol=1e-6)
    results = [got["forward_dynamics"], got["mass_matrix"], *got["energy"], *got["step"]]
    assert {result.dtype for result in results} == {np.dtype(np.float32)}
    rows = float_system.forward_dynamics(np.tile(Q, (3, 1)), V, U, p=PARAMETERS)
    assert rows.dtype == np.float32
    np.testing.assert_array_equal(rows, np.tile(got["forward_dynamics"], (3, 1)))


def test_parameters_come_by_name_not_by_order(system: System) -> None:
    turned = {"gravity": np.float64(9.0), "mass": np.array([2.0, 4.0])}
    np.testing.assert_array_equal(
        system.forward_dynamics(Q, V, U, p=turned), system.forward_dynamics(Q, V, U, p=PARAMETERS)
    )


@pytest.mark.parametrize(
    "state", [np.full(2, np.nan), np.array([np.inf, 1.0]), np.full((3, 2), np.nan)], ids=str
)
def test_nan_in_nan_out(system: System, state: np.ndarray) -> None:
    result = system.forward_dynamics(state, V, U, p=PARAMETERS)
    assert not np.isfinite(result[..., 0]).any()
    assert np.isnan(system.energy(state, np.full(2, np.nan), p=PARAMETERS)[0]).all()


numbers = st.floats(-1e3, 1e3, allow_subnormal=False)


def laid_out(values: np.ndarray, layout: str) -> np.ndarray:
    """The same numbers, lying otherwise in memory."""
    if layout == "columns of a wider array":
        return np.concatenate([values, values], axis=-1)[..., : values.shape[-1]]
    if layout == "fortran":
        return np.asfortranarray(values)
    if layout == "backwards":
        return values[::-1].copy()[::-1]
    if layout == "every other":
        return np.repeat(values, 2, axis=0)[::2]
    return values


@settings(deadline=None, max_examples=60)
@given(data=st.data(), rows=st.integers(0, 4))
def test_batch_equals_loop(system: System, data: st.DataObject, rows: int) -> None:
    layouts = st.sampled_from(["plain", "columns of a wider array", "fortran", "backwards", "every other"])
    given_arrays, full = [], []
    shared = data.draw(st.lists(st.booleans(), min_size=3, max_size=3).filter(lambda flags: not all(flags)))
    for is_shared in shared:
        values = data.draw(arrays(np.float64, (2,) if is_shared else (rows, 2), elements=numbers))
        given_arrays.append(laid_out(values, data.draw(layouts)))
        full.append(np.broadcast_to(values, (rows, 2)))
    h = data.draw(st.one_of(numbers, arrays(np.float64, (rows,), elements=numbers)))
    steps = np.broadcast_to(h, (rows,))
    q, v, u = given_arrays
    accelerations = system.forward_dynamics(q, v, u, p=PARAMETERS)
    stepped = system.step(h, q, v, u, p=PARAMETERS)
    assert accelerations.shape == stepped[0].shape == (rows, 2)
    for row, (step, *state) in enumerate(zip(steps, *full, strict=True)):
        np.testing.assert_array_equal(accelerations[row], system.forward_dynamics(*state, p=PARAMETERS))
        np.testing.assert_array_equal(
            [part[row] for part in stepped], system.step(step, *state, p=PARAMETERS)
        )


@settings(deadline=None, max_examples=60)
@given(rows=st.integers(0, 5), data=st.data())
def test_batch_against_numpy(system: System, rows: int, data: st.DataObject) -> None:
    q, v, u = (data.draw(arrays(np.float64, (rows, 2), elements=numbers)) for _ in range(3))
    assert_close(evaluated(system, q, v, u, 0.25), expected(q, v, u, 0.25), rtol=1e-12)


def test_columns_of_a_trajectory_are_not_copied(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    states = np.random.default_rng(0).normal(size=(5, 4))
    monkeypatch.setattr("phichain.native.memory.arrays._packed", None)
    q, v = states[:, :2], states[:, 2:]
    np.testing.assert_array_equal(
        system.forward_dynamics(q, v, np.zeros((5, 2)), p=PARAMETERS)[3],
        system.forward_dynamics(q[3], v[3], np.zeros(2), p=PARAMETERS),
    )


def test_help_shows_the_signature(system: System) -> None:
    assert str(inspect.signature(system.step)) == "(h, q, v, u, /, *, p=None)"
    assert system.step.__name__ == "step"
    assert "step(h, q, v, u, p=) -> q_next, v_next, compiled from duo_step." in str(system.step.__doc__)


def test_threads_do_not_share_buffers(system: System) -> None:
    def sums(seed: int) -> bool:
        states = np.random.default_rng(seed).normal(size=(300, 3, 2))
        wanted = expected(*np.moveaxis(states, 1, 0))["forward_dynamics"]
        got = [system.forward_dynamics(*state, p=PARAMETERS) for state in states]
        return np.allclose(got, wanted, rtol=1e-12)

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(sums, range(16)))


# C that says "I run" by writing to v, then waits, for a bounded while, until somebody else writes to q.
MEETING = """
    volatile const duo_real *q_seen = q;
    long patience = 2000000000L;
    *(volatile duo_real *)v = 1;
    while (q_seen[0] == 0 && patience > 0) {
        patience--;
    }
    a[0] = q_seen[0];
    a[1] = (duo_real)(u[0] + p->gravity);
"""


def test_other_threads_run_during_a_call(tmp_path: Path, cache: Cache) -> None:
    start = SOURCE.index("    a[0] = u[0]")
    source = SOURCE[:start] + MEETING + SOURCE[SOURCE.index("}", start) :]
    system = build_folder(write(tmp_path, source=source), cache=cache)
    q, v, results = np.zeros((1, 2)), np.zeros((1, 2)), []
    call = threading.Thread(target=lambda: results.append(system.forward_dynamics(q, v, U, p=PARAMETERS)))
    call.start()
    while v[0, 0] == 0.0 and call.is_alive():
        time.sleep(0.001)
    q[0, 0] = 1.0
    call.join()
    assert results[0][0, 0] == 1.0, "the interpreter stood still while C ran"


def test_every_parameter_reaches_its_field_of_the_struct(system: System) -> None:
    p = {"mass": [7.0, 8.0], "gravity": 9.0}
    np.testing.assert_array_equal(np.diag(system.mass_matrix(Q, p=p)), [7.0, 8.0])
    assert system.energy([1.0, 0.0], V, p=p)[1] == 9.0


SHORT = {
    "arrays": np.asarray,
    "lists": list,
    "tuples": tuple,
    "NumPy numbers": lambda values: list(np.asarray(values)),
    "single precision": lambda values: np.asarray(values, np.float32),
    "whole numbers": lambda values: np.asarray(np.round(values), np.int16),
    "Python's whole numbers": lambda values: [round(value) for value in values],
    "every other entry": lambda values: np.repeat(values, 2)[::2],
    "another byte order": lambda values: np.asarray(values, ">f8"),
}


@pytest.mark.parametrize("form", SHORT.values(), ids=SHORT)
def test_a_single_state_is_copied_without_a_detour(system: System, monkeypatch: pytest.MonkeyPatch, form: Any) -> None:
    given = [form([0.25, -1.5]), form([1.125, 2.0]), form([3.0, -0.5])]
    expected_bits = system.forward_dynamics(*(np.asarray(values, float) for values in given), p=PARAMETERS).tobytes()
    monkeypatch.setattr("phichain.native.callables.rows_of", None)
    monkeypatch.setattr("phichain.native.memory.parameters.parameter_values", None)
    assert system.forward_dynamics(*given, p=PARAMETERS).tobytes() == expected_bits
    step = system.step(0.125, *given, p=PARAMETERS)
    assert [part.tobytes() for part in step] == [part.tobytes() for part in system.step(np.float64(0.125), *given, p=PARAMETERS)]


def test_rows_that_lie_ready_are_stepped_through(system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    states = np.random.default_rng(1).normal(size=(5, 6))
    states.setflags(write=False)
    q, v, u = states[:, :2], states[:, 2:4], states[:, 4:]
    single = [system.forward_dynamics(*np.split(row, 3), p=PARAMETERS) for row in states]
    monkeypatch.setattr("phichain.native.callables.rows_of", None)
    assert np.array_equal(system.forward_dynamics(q, v, u, p=PARAMETERS), single)
    shared = system.forward_dynamics(q, v[0].copy(), np.ascontiguousarray(u)[::-1][::-1], p=PARAMETERS)
    assert np.array_equal(shared[0], single[0])


@pytest.mark.parametrize("value", [[10**400, 0], [True, None], ["1", "2"], [1.0], [[1.0], [2.0]], [1j, 0], (1.0, 2.0, 3.0)])
def test_lists_that_are_no_state_are_refused_as_ever(system: System, value: Any) -> None:
    with pytest.raises(ArrayError, match=r"^forward_dynamics\.v: "):
        system.forward_dynamics(Q, value, U, p=PARAMETERS)
