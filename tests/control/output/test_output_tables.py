"""Tables with observers and integrals: what their ellipsoids say, the record in closed loop, as Programs, as compiled float C, and refusals."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import subprocess
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from phichain import generate_controller
from phichain.control import (
    Sensors,
    estimator,
    gain_table,
    lqr,
    output_table,
    place,
    regulators,
    with_integrals,
)
from phichain.emit.law import law_files
from phichain.errors import ArrayError, ControlError, OutputError
from phichain.ir import evaluate
from phichain.laws import OutputTable, TableMemory
from phichain.lowering.laws import output_table_programs
from tests.control.closed_loop import after
from tests.handmade import planar, spatial
from tests.one_program import STRICT

PERIOD = 0.002
CHAINS = {
    "plane": planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart"),
    "space": spatial([0.2], [0.4], cart_mass=0.5),
}
INTEGRALS = {"plane": {"x": 2.0}, "space": {"x_1": 1.0, "x_2": 0.5}}
KINDS = [(chain, kind, integrals) for chain in CHAINS for kind in ("kalman", "reduced", None) for integrals in (False, True) if kind or integrals]


@cache
def table_of(chain: str, kind: str | None = "kalman", integrals: bool = True, limit: float | None = 10.0) -> OutputTable:
    every = regulators(CHAINS[chain], product((1, -1), repeat=CHAINS[chain].links), sample=PERIOD)
    return output_table(every, kind, None, INTEGRALS[chain] if integrals else None, [0.125] * CHAINS[chain].cart_size, limit=limit)


def test_the_level_is_the_least_cost_over_all_integrals_and_no_input_is_large_within() -> None:
    """Minimised by SciPy instead of by a Schur complement; the largest input on V <= rho by Lagrange's multiplier."""
    gains = lqr(CHAINS["plane"], sample=PERIOD)
    joined, table = with_integrals(gains, INTEGRALS["plane"]), table_of("plane")
    z = np.array([0.02, 0.01, -0.015, 0.03, 0.05, -0.02])
    which = table.signs.index((-1, -1))

    def cost(integral: np.ndarray) -> float:
        whole = np.concatenate([z, integral])
        return float(whole @ joined.S @ whole)

    least = minimize(cost, [0.0], method="BFGS", options={"gtol": 1e-12})
    assert np.array(table.begins[which]) @ z == pytest.approx(least.x, rel=1e-5)
    inverse = np.linalg.inv(joined.S)
    row = np.hstack([joined.K, joined.K_i])[0]
    rho = min(100 / (row @ inverse @ row), *(0.01 / inverse[i, i] for i in (1, 2)))
    assert table.level(which, z) == pytest.approx(least.fun / rho, rel=1e-6)


def test_an_observer_has_settled_when_no_error_is_more_than_a_tenth() -> None:
    table = table_of("plane")
    for which, settle in enumerate(table.settle):
        observer, W = table.laws[which].observer, np.array(table.shapes[which])
        assert observer is not None
        moves = (np.eye(6) - np.array(observer.correction) @ np.array(observer.seen)) @ np.array(observer.advance)
        sizes = [np.linalg.norm(W @ np.linalg.matrix_power(moves, k) @ np.linalg.inv(W), 2) for k in range(settle + 1)]
        assert sizes[-1] <= 0.1 < min(sizes[:-1])
    assert set(table_of("plane", None).settle) == {0}


def test_placed_integrals_have_a_table_too() -> None:
    """Its cost falls along the placed loop: V(k + 1) - V(k) is minus a sum of squares."""
    poles = [-2, -3, -3.5, -4, -5, -6, -7]
    every = [place(CHAINS["plane"], s, poles[1:], sample=PERIOD) for s in ((1, 1), (-1, -1))]
    table = output_table(every, "kalman", None, {"x": 1.0}, poles=poles, limit=20.0)
    joined = with_integrals(every[1], {"x": 1.0}, poles)
    assert np.array(table.laws[1].gains) == pytest.approx(joined.K) and np.all(np.linalg.eigvalsh(joined.S) > 0)
    x = np.array([0.0, np.pi + 0.002, 0.001, 0, 0, 0])
    memory, levels = replace(table.reset(), near=1), []
    for _ in range(1500):
        u, memory = table.step(memory, x[:3])
        levels.append(memory.level)
        x = after(CHAINS["plane"], x, u, PERIOD)
    assert memory.held == 1 and levels[-1] < 1e-3 * max(levels) and np.max(np.abs(x[:3] - [0, np.pi, 0])) < 1e-3


@pytest.mark.long
@pytest.mark.parametrize(("chain", "kind", "integrals"), KINDS)
def test_the_programs_are_the_record(chain: str, kind: str | None, integrals: bool) -> None:
    table = table_of(chain, kind, integrals)
    parts, draw = output_table_programs(table), np.random.default_rng(2)
    law = table.laws[0]
    n, nu, ni = len(law.deviation_names), len(law.input_names), len(law.integrated)
    for which in range(len(table.signs)):
        row, one = parts.row(which), table.laws[which]
        for scale in (0.05, 3.0):
            y = np.array(one.offsets) + scale * draw.normal(size=len(one.offsets))
            memory = TableMemory(which, which, 1, 0.0, scale * draw.normal(size=n), scale * draw.normal(size=ni))
            u = draw.normal(size=nu)
            looked = table._estimated(memory, which, y)
            followed = table.follow(replace(looked, integral=memory.integral), y, u)
            given = {**row, "y_meas": y, "expected": memory.deviation, "integral": memory.integral, "u": u, "z": looked.deviation}
            expected = {
                "apart": np.sum(table._off(which, y)[list(table.compared)] ** 2), "start": table._started(memory, which, y).deviation,
                "estimate": looked.deviation, "level": looked.level, "begin": np.array(table.begins[which]).reshape(ni, n) @ looked.deviation,
                "law": table.inputs(looked), "expect": followed.deviation, "grow": followed.integral,
            }  # fmt: skip
            for name, program in parts.parts.items():
                (found,) = evaluate(program, {array.name: given[array.name] for array in program.inputs}).values()
                assert np.allclose(found, expected[name], rtol=1e-9, atol=1e-9 * scale), name


def result_of(folder: Path) -> int:
    """The result of the folder's self-test."""
    sources = [str(path) for path in folder.glob("*.c")]
    made = subprocess.run(["cc", *STRICT[:-2], "-O0", *sources, "-lm", "-o", str(folder / "t")], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.parametrize(
    ("chain", "kind", "integrals", "real"),
    [("plane", "kalman", True, "double"), ("space", "reduced", True, "float"), ("plane", None, True, "float"), ("space", "kalman", False, "float")],
)
def test_the_folder_passes_its_own_test(chain: str, kind: str | None, integrals: bool, real: str, tmp_path: Path) -> None:
    table = table_of(chain, kind, integrals)
    folder = generate_controller(table, tmp_path, real)
    assert result_of(folder) == 0
    record = json.loads((folder / "manifest.json").read_text())
    assert record["kind"] == "output table" and [one["settle"] for one in record["equilibria"]] == list(table.settle)


@pytest.mark.long
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("state->level <= table[state->held].leave", "state->level <= table[state->held].take"),
        ("state->level <= table[near].take", "state->level <= table[near].leave"),
        ("++state->calls > table[near].settle", "++state->calls > table[near].settle + 1"),
        ("state->held = near", "state->held = 0"),
        ("table[near].begin, state->integral", "table[0].begin, state->integral"),
        ("state->deviation[i] = expected[i]", "state->deviation[i] = 0.0F"),
        ("state->integral[i] = integral_next[i]", "(void)integral_next"),
        ("? 2.0F : t2", "? 1.5F : t2"),
        ("correction[5]", "correction[4]"),
        ("drive[2]", "drive[1]"),
        ("start(y_meas, table[near].offsets", "start(y_meas, table[0].offsets"),
    ],
)
def test_mutants_of_the_c_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    for name, text in law_files(table_of("plane", limit=2.0), "float").items():
        (tmp_path / name).write_text(text)
    source = tmp_path / "handmade_controller.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1))
    assert result_of(tmp_path) > 0


class _State(ctypes.Structure):
    _fields_ = [
        ("level", ctypes.c_float), ("deviation", ctypes.c_float * 6), ("integral", ctypes.c_float), ("held", ctypes.c_int),
        ("watched", ctypes.c_int), ("calls", ctypes.c_int),
    ]  # fmt: skip


class InC:
    """The float table with its memory, for one run."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self.library, self.state = library, _State()
        self.y, self.u = (ctypes.c_float * 3)(), (ctypes.c_float * 1)()
        library.handmade_controller_reset(ctypes.byref(self.state))

    def __call__(self, y: np.ndarray) -> tuple[int, np.ndarray]:
        self.y[:] = y
        held = self.library.handmade_controller(ctypes.byref(self.state), self.y, self.u)
        return held, np.array(self.u)


@pytest.fixture(scope="module")
def in_c(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = generate_controller(table_of("plane"), tmp_path_factory.mktemp("c"), "float")
    library = folder / "table.so"
    done = subprocess.run(["cc", *STRICT, str(folder / "handmade_controller.c"), "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


def seen(x: np.ndarray) -> np.ndarray:
    """What encoders of 4096 counts and 0.1 mm say."""
    steps = np.array([1e-4, 2 * np.pi / 4096, 2 * np.pi / 4096])
    return np.round(x[:3] / steps) * steps


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_the_float_c_takes_up_holds_and_leads_home_against_a_push(signs: tuple[int, int], in_c: ctypes.CDLL) -> None:
    """From encoders alone, a constant force on the cart beside: taken up once the observer has settled, never let go, the push integrated away."""
    table, emitted = table_of("plane"), InC(in_c)
    which = table.signs.index(signs)
    x = np.array([*table.laws[which].offsets, 0, 0, 0]) + [-0.002, 0.0005, -0.0005, 0, 0, 0]
    which_of: list[int] = []
    for k in range(2500):
        held, u = emitted(seen(x))
        which_of.append(held)
        x = after(CHAINS["plane"], x, u + (0.02 if k > 100 else 0.0), PERIOD)
    taken = which_of.index(which)
    assert table.settle[which] <= taken < 3 * table.settle[which]
    assert set(which_of[taken:]) == {which} and set(which_of[:taken]) == {-1}
    assert abs(x[0] - 0.125) < 0.01 and abs(emitted.state.integral) > 1e-3


def test_the_float_c_lets_go_of_a_chain_that_is_kicked_and_decides_as_the_record(in_c: ctypes.CDLL) -> None:
    table, emitted = table_of("plane"), InC(in_c)
    memory, x = table.reset(), np.array([0.125, np.pi, 0.0, 0, 0, 0])
    decided = []
    for k in range(400):
        if k == 150:
            x[3:] += [0.0, 3.0, -2.0]
        y = np.array([float(np.float32(part)) for part in seen(x)])
        if k in (100, 101):
            y[1] = np.nan
        held, u = emitted(y)
        expected, memory = table.step(memory, y)
        decided.append(held)
        assert held == memory.held and emitted.state.watched == memory.near and u == pytest.approx(expected, rel=2e-2, abs=2e-2)
        x = after(CHAINS["plane"], x, u, PERIOD)
    which = table.signs.index((-1, -1))
    assert decided[140] == which and -1 in decided[150:170] and decided[-1] == -1


def test_casadi_has_the_same_parts(tmp_path: Path) -> None:
    table = table_of("space", "kalman", True)
    folder = generate_controller(table, tmp_path)
    spec = importlib.util.spec_from_file_location(folder.name, folder / f"{folder.name}_casadi.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    part, draw = getattr(module, folder.name), np.random.default_rng(4)
    y = np.array(table.laws[1].offsets) + 0.05 * draw.normal(size=5)
    memory = TableMemory(1, 1, 1, 0.0, 0.05 * draw.normal(size=8), draw.normal(size=2))
    looked = table._estimated(memory, 1, y)
    assert np.array(part("estimate", 1)(memory.deviation, y)).ravel() == pytest.approx(looked.deviation, rel=1e-9)
    assert float(part("level", 1)(looked.deviation)) == pytest.approx(looked.level, rel=1e-9)
    u = np.array(part("law", 1)(looked.deviation, memory.integral)).ravel()
    assert u == pytest.approx(table.inputs(looked), rel=1e-9)
    followed = table.follow(looked, y, u)
    assert np.array(part("expect", 1)(looked.deviation, u)).ravel() == pytest.approx(followed.deviation, rel=1e-9)
    assert np.array(part("grow", 1)(looked.deviation, memory.integral, y)).ravel() == pytest.approx(followed.integral, rel=1e-9)


def test_a_table_on_file_is_the_same_record(tmp_path: Path) -> None:
    for chain, kind, integrals in KINDS:
        table = table_of(chain, kind, integrals)
        assert OutputTable.from_npz(table.to_npz(tmp_path / "table.npz")) == table
    assert "a kalman observer that settles within 20 calls, integrals of x" in str(table_of("plane"))
    plain = gain_table(regulators(CHAINS["plane"], [(1, 1)]))
    with pytest.raises(OutputError, match="holds a GainTable, not a OutputTable"):
        OutputTable.from_npz(plain.to_npz(tmp_path / "plain.npz"))
    with np.load(table_of("plane").to_npz(tmp_path / "table.npz")) as archive:
        held = {name: archive[name] for name in archive.files}
    for name in ("correction", "shapes", "settle"):
        np.savez(tmp_path / "altered.npz", **{key: value for key, value in held.items() if key != name})
        with pytest.raises(OutputError):
            OutputTable.from_npz(tmp_path / "altered.npz")


def test_tables_that_do_not_fit_are_refused() -> None:
    every = regulators(CHAINS["plane"], sample=PERIOD)
    table, plain = table_of("plane"), table_of("plane", None)
    for call, error, words in (
        (lambda: output_table(every), ControlError, "are both left out"),
        (lambda: output_table([], "kalman"), ControlError, "table: holds no regulator"),
        (lambda: output_table(every, "kalman", Sensors(measured=("x", "theta_1"))), ControlError, r"measured: do not tell \[1, 1\] from \[1, -1\]"),
        (lambda: output_table(regulators(CHAINS["plane"]), "kalman"), ControlError, "sample: is what an observer needs"),
        (lambda: output_table(every, None, None, {"theta_1": 1.0}), ControlError, "integral: cannot be held"),
        (lambda: output_table(every, "kalman", leave=0.5), ArrayError, "leave: would let go before it takes up"),
        (lambda: replace(table, laws=(*table.laws[:3], plain.laws[3])), ArrayError, "table.laws: is not the same for all"),
        (lambda: replace(table, laws=()), ArrayError, "hold no equilibrium, or one twice"),
        (lambda: replace(table, shapes=()), ArrayError, "table.shapes: must hold finite numbers"),
        (lambda: replace(table, compared=(9,)), ArrayError, "table.compared: are not all measured"),
        (lambda: replace(table, settle=(1,)), ArrayError, "table.settle: does not say of each"),
        (lambda: replace(table, leave=(0.5,) * 4), ArrayError, "table.leave: lets go before"),
    ):
        with pytest.raises(error, match=words):
            call()
    assert estimator(every[0]).reads == table.laws[0].reads
