"""Batch forms lane by lane: forward dynamics to the last bit, flows to round-off, whatever is left over."""

from __future__ import annotations

import ctypes
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.errors import ArrayError, ToleranceError
from phichain.mechanics import derive
from phichain.pipeline import build
from phichain.scene import Scene, scene_from_dict
from phichain.system.propagation import Stop
from tests.flow.batches import EXACT, WRITERS, dynamics, flow, parameters, unit
from tests.flow.flows import compiled, planar, scene

STRICT = (
    "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wfloat-conversion", "-Wshadow", "-Wcast-qual", "-Wundef", "-Wvla", "-Wfloat-equal", "-Wunreachable-code", "-Werror",
)  # fmt: skip
RUNTIME = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}
CHAINS = {
    "unrolled": planar(
        3, "arms3", joints={"actuated": "all", "angles": "absolute", "stiffness": [1.0, 0, 2]}
    ),
    "loops": planar(64, "chain64", joints={"actuated": [1, 64]}),
    "cart": scene("carted", "planar", "cart", links=2, mass=1, length=[0.5, 1], cart_mass=0.7),
    "spatial": scene("sphere3", "spatial", "cart", links=3, mass=0.1, length=0.1, cart_mass=0.5),
    "half": scene("halfway", "spatial", "fixed", links=2, mass=0.1, length=0.1, com=0.06),
    "runtime": scene("given", "planar", "fixed", links=2, **RUNTIME),
    "single": planar(2, "single", target={"real": "float"}),
}
GIVEN = {"mass": [1.0, 0.5], "length": [1.0, 0.7], "com": [0.5, 0.3], "gravity": 9.81}


def states(chain: Scene, n: int, seed: int = 1) -> list[NDArray[np.float64]]:
    """Random q, v and, where there is one, u."""
    random = np.random.default_rng(seed)
    q, v = random.normal(size=(n, chain.nq)), random.normal(size=(n, chain.nv))
    if not chain.is_planar:
        cart = 2 if chain.has_cart else 0
        for row, rate in zip(q, v, strict=True):
            units, spins = row[cart:].reshape(-1, 3), rate[cart:].reshape(-1, 3)
            units /= np.linalg.norm(units, axis=1)[:, None]
            spins -= np.sum(spins * units, axis=1)[:, None] * units
    kind = np.float32 if chain.real == "float" else np.float64
    return [x.astype(kind) for x in (q, v, *([random.normal(size=(n, chain.nu))] if chain.nu else []))]


def given(chain: Scene) -> dict[str, Any]:
    return {"p": {k: np.array(v) for k, v in GIVEN.items()}} if chain.runtime else {}


def one_by_one(chain: Scene, scalar: Any, inputs: list[NDArray[Any]]) -> NDArray[Any]:
    """The scalar C function, row by row."""
    head = []
    if chain.runtime:
        fields = (np.ravel(GIVEN[array.name]) for array in parameters(chain))
        head = [np.concatenate(list(fields))]
    out = np.empty((len(inputs[0]), chain.nv), inputs[0].dtype)
    for k, row in enumerate(out):
        arrays = [*head, *(np.ascontiguousarray(x[k]) for x in inputs), row]
        scalar(*(ctypes.c_void_p(array.ctypes.data) for array in arrays))
    return out


# --- forward dynamics -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("portable", [False, True], ids=["vectors", "portable"])
def test_accelerations_are_the_scalar_ones_to_the_last_bit(name: str, portable: bool) -> None:
    chain = CHAINS[name]
    batch, scalar = dynamics(chain, EXACT, portable)
    for n in (1, 7, 8, 9, 33):
        inputs = states(chain, n, seed=n)
        assert np.array_equal(batch(*inputs, **given(chain)), one_by_one(chain, scalar, inputs))


@pytest.mark.parametrize("name", ["unrolled", "spatial"])
def test_contraction_moves_the_last_digits_alone(name: str) -> None:
    chain = CHAINS[name]
    batch, scalar = dynamics(
        chain, ("-std=c99", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno")
    )
    inputs = states(chain, 100)
    expected = one_by_one(chain, scalar, inputs)
    scale = np.max(np.abs(expected), axis=1)
    assert np.max(np.max(np.abs(batch(*inputs) - expected), axis=1) / scale) < 2e-14


def test_angles_beyond_the_kernel_go_to_the_library() -> None:
    """In one lane alone: the others are not disturbed, NaN stays where it is."""
    chain = CHAINS["cart"]
    batch, scalar = dynamics(chain, EXACT)
    inputs = states(chain, 40)
    inputs[0][3, 1], inputs[0][9, 2], inputs[0][35, 1] = 1e9, -4.1e5, np.nan
    found, expected = batch(*inputs), one_by_one(chain, scalar, inputs)
    assert np.array_equal(found, expected, equal_nan=True)
    assert np.isnan(found[35]).any() and not np.isnan(np.delete(found, 35, axis=0)).any()


def test_a_system_has_the_batch_form_beside_the_scalar_one() -> None:
    table: dict[str, Any] = {
        "links": 2,
        "space": "planar",
        "base": "fixed",
        "mass": 1,
        "length": 1,
        "gravity": "runtime",
    }
    want = ["forward_dynamics", "forward_dynamics_batch", "propagate", "propagate_batch"]
    system = build(scene_from_dict({"name": "both", "chain": table, "functions": {"want": want}}))
    q, v = (np.random.default_rng(3).normal(size=(20, 2)) for _ in range(2))
    p = {"gravity": 9.81}
    assert np.allclose(
        system.forward_dynamics_batch(q, v, p=p), system.forward_dynamics(q, v, p=p), rtol=1e-13
    )
    found = system.propagate_batch(q, v, 0, 1, 1e-12, p=p)
    for k in (0, 19):
        assert np.max(np.abs(found[k].q - system.propagate(q[k], v[k], 0, 1, 1e-12, p=p).q)) < 1e-11


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ([np.zeros((2, 2))], "forward_dynamics_batch"),
        ([np.zeros((2, 2)), np.zeros((3, 2))], "v"),
        ([np.zeros(2)] * 2, "q"),
    ],
)
def test_bad_states_are_refused(values: list[Any], field: str) -> None:
    batch, _ = dynamics(planar(2))
    with pytest.raises(ArrayError, match=field):
        batch(*values)


# --- flows ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 7, 8, 9, 33])
def test_every_trajectory_is_that_of_the_scalar_flow(n: int) -> None:
    chain = planar(2)
    q, v = states(chain, n)
    q *= 0.3
    found = flow(chain)(q, v, 0.0, 3.0, 1e-13)
    assert set(found.outcome) == {"done"} and np.all(found.t == 3.0)
    for k in range(n):
        alone = compiled(chain)(q[k], v[k], 0.0, 3.0, 1e-13)
        assert np.max(np.abs(found.q[k] - alone.q)) < 1e-12
        assert abs(int(found.steps[k]) - alone.steps) <= 2


@pytest.mark.parametrize("name", [*CHAINS, "portable"])
def test_every_kind_of_chain(name: str) -> None:
    chain = CHAINS["unrolled" if name == "portable" else name]
    q, v, *u = states(chain, 9)
    q[:] = q if not chain.is_planar else 0.2 * q
    single, inputs = chain.real == "float", {"u": 0.1 * u[0]} if u else {}
    t_end, tol = (0.005 if chain.links > 9 else 0.3), 1e-5 if single else 1e-13
    found = flow(chain, portable=name == "portable")(q, v, 0.0, t_end, tol, **inputs, **given(chain))
    for k in range(9):
        own = {name: value[k] for name, value in inputs.items()}
        alone = compiled(chain)(q[k], v[k], 0.0, t_end, tol, **own, **given(chain))
        assert found.outcome[k] == alone.outcome == "done"
        assert np.max(np.abs(found.q[k] - alone.q)) < (1e-4 if single else 1e-11)


def test_equal_trajectories_end_equal_wherever_they_run() -> None:
    found = flow(planar(2))(np.tile([0.4, 0.0], (21, 1)), np.zeros((21, 2)), 0.0, 5.0, 1e-12)
    assert len(set(map(tuple, found.q))) == 1 and len(set(found.steps)) == 1


def test_times_on_the_way_and_times_of_ones_own() -> None:
    """Starts and ends differ, one goes backwards; what a trajectory does not reach stays NaN."""
    chain = planar(2)
    q, v = states(chain, 11)
    end = np.linspace(1.0, 2.0, 11)
    times = [0.25, 0.5, 1.0]
    found = flow(chain)(q, v, 0.0, end, 1e-13, times=times)
    assert found.q_at.shape == (11, 3, 2) and np.all(found.written == 3)
    alone = compiled(chain)(q[4], v[4], 0.0, float(end[4]), 1e-13, times=times)
    assert np.max(np.abs(found[4].q_at - alone.q_at)) < 1e-11
    back = flow(chain)(found.q, found.v, end, 0.0, 1e-13, lost=found.lost)
    assert np.max(np.abs(back.q - q)) < 1e-9
    short = flow(chain)(q, v, 0.0, 2.0, 1e-13, times=times, max_steps=3)
    assert (
        set(short.outcome) == {"step budget"}
        and np.all(short.steps == 3)
        and np.isnan(short.q_at[:, 2]).all()
    )


def test_pieces_are_the_whole_to_the_last_bit() -> None:
    chain, go = planar(2), flow(planar(2))
    q, v = states(chain, 10)
    whole = go(q, v, 0.0, 2.0, 1e-12)
    t, lost, steps = np.zeros(10), None, np.zeros(10, int)
    while not np.all(t == 2.0):
        part = go(q, v, t, 2.0, 1e-12, max_steps=7, lost=lost)
        q, v, t, lost, steps = part.q, part.v, part.t, part.lost, steps + part.steps
    assert np.array_equal(q, whole.q) and np.array_equal(v, whole.v) and np.array_equal(steps, whole.steps)


@pytest.mark.parametrize("stop", [Stop("q", 0), Stop("v", 1, direction=-1), Stop("depth", 1, value=0.6)])
def test_each_trajectory_stops_where_it_meets_the_event(stop: Stop) -> None:
    chain = planar(2)
    q = np.column_stack([np.linspace(0.3, 1.0, 10), np.zeros(10)])
    found = flow(chain)(q, np.zeros_like(q), 0.0, 1.5, 1e-14, stop=stop)
    assert "event" in found.outcome
    for k in range(10):
        alone = compiled(chain)(q[k], np.zeros(2), 0.0, 1.5, 1e-14, stop=stop)
        assert found.outcome[k] == alone.outcome and abs(found.t[k] - alone.t) < 1e-12


def test_one_that_overflows_does_not_disturb_the_others() -> None:
    chain = planar(2)
    q, v = states(chain, 12)
    clean = flow(chain)(q, v, 0.0, 1.0, 1e-12)
    v[5] = [1e200, -1e200]
    found = flow(chain)(q, v, 0.0, 1.0, 1e-12)
    assert found.outcome[5] == "not finite" and found.t[5] == 0.0 and found.v[5, 0] == 1e200
    rest = np.arange(12) != 5
    assert np.array_equal(found.q[rest], clean.q[rest])


@pytest.mark.parametrize(
    ("change", "error", "field"),
    [
        ({"q": [0.1, 0.2]}, ArrayError, "q"),
        ({"v": [[0.0, np.nan]]}, ArrayError, "v"),
        ({"t_end": [1.0, 2.0]}, ArrayError, "t_end"),
        ({"t": np.inf}, ArrayError, "propagate_batch.t"),
        ({"times": [0.5, 0.2]}, ArrayError, "times"),
        ({"tol": -1.0}, ToleranceError, "tol"),
        ({"stop": Stop("v", 2)}, ArrayError, "stop.index"),
        ({"lost": np.zeros((1, 4))}, ArrayError, "lost"),
    ],
)
def test_bad_input_is_refused(change: dict[str, Any], error: type[Exception], field: str) -> None:
    arguments: dict[str, Any] = {"q": [[0.1, 0.2]], "v": [[0, 0]], "t": 0.0, "t_end": 1.0, "tol": 1e-9}
    with pytest.raises(error, match=field):
        flow(planar(2))(**(arguments | change))


# --- the text -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("name", CHAINS)
def test_strict_compilers_have_nothing_to_say(name: str, form: str, tmp_path: Path) -> None:
    for portable in (False, True) if name in ("runtime", "single") else (False,):
        (tmp_path / "batch.c").write_text(unit(CHAINS[name], form, portable))
        command = ["cc", *STRICT, "-O1", "-c", "batch.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and not done.stderr, done.stderr[:3000]


MAIN = """
#include <stdlib.h>
int main(void)
{
    for (size_t n = 1; n < 40; n += 1 + n / 4) {
        /* Exactly as long as promised, on the heap, where a sanitizer guards both ends. */
        NAME_real *q = calloc(NQ * n, sizeof *q), *v = calloc(NV * n, sizeof *v), *a = calloc(NV * n, sizeof *a);
        for (size_t i = 0; i < NQ * n; ++i) q[i] = (NAME_real)0.01 * (NAME_real)(i % 17);
        CALL
        free(q); free(v); free(a);
    }
    return 0;
}
"""
CALLS = {
    "forward_dynamics_batch": "NAME_forward_dynamics_batch(n, q, v, a);",
    "propagate_batch": """
        NAME_real *t = calloc(n, sizeof *t), *end = calloc(n, sizeof *end), *lost = calloc((1 + NQ + NV) * n, sizeof *lost);
        NAME_real *work = malloc(UPPER_BATCH_WORK * sizeof *work), times[1] = {0.01};
        unsigned long *steps = calloc(2 * n, sizeof *steps);
        int *result = calloc(n, sizeof *result);
        NAME_flow_batch flow = {(NAME_real)1e-12, 0, t, lost, steps, steps + n, result};
        for (size_t k = 0; k < n; ++k) end[k] = (NAME_real)0.01 * (NAME_real)(1 + k % 3);
        if (NAME_propagate_batch(n, &flow, end, 1000, q, v, NULL, 1, times, a, a, work) != n) return 1;
        free(t); free(end); free(lost); free(work); free(steps); free(result);""",
}


@pytest.mark.parametrize("form", WRITERS)
def test_nothing_beyond_the_arrays_is_touched(form: str, tmp_path: Path) -> None:
    chain = planar(1)
    main = MAIN.replace("CALL", CALLS[form]).replace("NAME", chain.name).replace("UPPER", chain.name.upper())
    main = re.sub(r"\bN[QV]\b", "1", main)
    (tmp_path / "batch.c").write_text(unit(chain, form) + main)
    command = [
        "cc",
        "-std=c99",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "batch.c",
        "-lm",
    ]
    built = subprocess.run(
        [*command, "-o", "guarded"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    if built.returncode != 0 and "sanitize" in built.stderr:
        pytest.skip("the compiler has no sanitizers")
    assert built.returncode == 0, built.stderr[:2000]
    ran = subprocess.run(["./guarded"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[:3000]


@pytest.mark.parametrize("form", WRITERS)
def test_lines_are_short_and_names_have_the_prefix(form: str) -> None:
    chain = CHAINS["cart"]
    made = WRITERS[form](derive(chain))
    text = made.declarations + made.definitions
    assert max(map(len, text.splitlines())) <= 120
    for line in text.splitlines():
        if line.startswith(("static ", "void ", "size_t ", "#define ")):
            assert chain.name in line or chain.name.upper() in line, line
