"""Tables of gains: their ellipsoids, the supervisor in Python and in C, in closed loop, and what is refused."""

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

from phichain import generate_controller
from phichain.control import gain_table, lqr, regulators
from phichain.emit.law import law_files
from phichain.errors import ArrayError, ControlError, OutputError
from phichain.ir import evaluate
from phichain.laws import GainTable
from phichain.lowering.laws import table_programs
from tests.control.closed_loop import after
from tests.handmade import paper_b, planar, spatial
from tests.one_program import STRICT

PERIOD = 0.002
CHAINS = {
    "plane": planar([0.1, 0.1], [0.3, 0.2], cart_mass=0.5, actuated="cart"),
    "space": spatial([0.2], [0.4], cart_mass=0.5),
}


def table_of(chain: str, limit: float | None = 10.0, **more: float) -> GainTable:
    system = CHAINS[chain]
    return gain_table(regulators(system, product((1, -1), repeat=system.links), sample=PERIOD), limit=limit, **more)


TABLES = {chain: table_of(chain) for chain in CHAINS}


def on_level(table: GainTable, which: int, level: float, seed: int = 0) -> np.ndarray:
    """A state on a level of one equilibrium; in space on the sphere."""
    shape = np.array(table.shapes[which])
    part = np.random.default_rng(seed).normal(size=len(shape))
    away = np.linalg.lstsq(shape, part / np.linalg.norm(part) * np.sqrt(level), rcond=None)[0]
    x = np.array(table.targets[which]) + away
    if len(x) == 10:  # one link in space
        x[4] = table.targets[which][4] * np.sqrt(1 - x[2] ** 2 - x[3] ** 2)
    return x


@pytest.mark.parametrize("chain", CHAINS)
def test_within_a_level_of_one_no_input_and_no_angle_is_large(chain: str) -> None:
    """The largest c^T d over |W d| <= 1 is |W^-T c|: of all inputs and angles one is at its bound, none beyond."""
    table = TABLES[chain]
    for which in range(len(table.signs)):
        shape = np.array(table.shapes[which])[: 6 if chain == "plane" else 8]
        free = np.flatnonzero(np.any(shape != 0, axis=0))
        rows = [(np.array(row)[free], 10.0) for row in table.gains[which]]
        rows += [(np.eye(len(free))[list(free).index(k)], 0.1) for k in table.compared if k in free]
        largest = [np.linalg.norm(np.linalg.solve(shape[:, free].T, row)) / bound for row, bound in rows]
        assert max(largest) == pytest.approx(1, rel=1e-9), which


@pytest.mark.parametrize("chain", CHAINS)
def test_a_state_within_is_taken_up_led_home_and_never_let_go(chain: str) -> None:
    system, table = CHAINS[chain], TABLES[chain]
    for which in range(len(table.signs)):
        x, held, levels = on_level(table, which, 0.95, which), -1, []
        for _ in range(300):
            held, level = table.supervise(held, x)
            levels.append(level)
            x = after(system, x, table.inputs(held, x), PERIOD)
            assert held == which
        assert max(levels) <= 1.0 and levels[-1] < 0.8 * levels[0]


@pytest.mark.parametrize("chain", CHAINS)
def test_the_supervisor_has_hysteresis(chain: str) -> None:
    table = TABLES[chain]
    for which in range(len(table.signs)):
        inside, between, outside = (on_level(table, which, level, 5) for level in (0.8, 2.5, 6.0))
        assert table.supervise(-1, inside)[0] == which
        assert table.supervise(which, between)[0] == which
        assert table.supervise(-1, between)[0] == -1
        assert table.supervise(which, outside)[0] == -1
        # From one equilibrium to another in a single call.
        assert table.supervise((which + 1) % len(table.signs), inside)[0] == which
    assert np.all(table.inputs(-1, inside) == 0)


@pytest.mark.parametrize("chain", CHAINS)
def test_the_programs_are_the_record(chain: str) -> None:
    table = TABLES[chain]
    programs, draw = table_programs(table), np.random.default_rng(2)
    for which in range(len(table.signs)):
        row = programs.row(table, which)
        for _ in range(5):
            x = np.array(table.targets[which]) + 3 * draw.normal(size=len(table.targets[which]))
            given = {"x_meas": x, **row}
            level = evaluate(programs.level, {a.name: given[a.name] for a in programs.level.inputs})["level"]
            assert level == pytest.approx(table.level(which, x), rel=1e-12)
            u = evaluate(programs.law, {a.name: given[a.name] for a in programs.law.inputs})["u"]
            assert u == pytest.approx(table.inputs(which, x), rel=1e-9, abs=1e-12)
            apart = evaluate(programs.apart, {a.name: given[a.name] for a in programs.apart.inputs})["apart"]
            at = list(table.compared)
            assert apart == pytest.approx(np.sum(table._away(which, x)[at] ** 2), rel=1e-12)


def compiled(folder: Path) -> tuple[int, str]:
    sources = [str(path) for path in folder.glob("*.c")]
    made = subprocess.run(["cc", *STRICT[:-2], "-O0", *sources, "-lm", "-o", str(folder / "t")], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode, made.stderr


@pytest.mark.parametrize(("chain", "real"), [("plane", "float"), ("space", "double")])
def test_the_folder_passes_its_own_test(chain: str, real: str, tmp_path: Path) -> None:
    folder = generate_controller(TABLES[chain], tmp_path, real)
    assert compiled(folder)[0] == 0
    record = json.loads((folder / "manifest.json").read_text())
    assert record["kind"] == "gain table" and len(record["equilibria"]) == len(TABLES[chain].signs)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("state->level <= 4.0F", "state->level <= 2.0F"),
        ("<= 1.0F ? near", "<= 3.0F ? near"),
        ("? near : -1", "? 0 : -1"),
        ("? 2.0F", "? 3.0F"),
        ("gains[2] * theta_2_away", "gains[1] * theta_2_away"),
        ("shape[7]", "shape[8]"),
        ("table[near].target, table[near].shape", "table[near].target, table[0].shape"),
    ],
)
def test_mutants_of_the_c_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    for name, text in mutated().items():
        (tmp_path / name).write_text(text)
    source = tmp_path / "handmade_controller.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1))
    assert compiled(tmp_path)[0] > 0


@cache
def mutated() -> dict[str, str]:
    """The table of which the test above takes mutants."""
    return law_files(table_of("plane", 2.0), "float")


class _State(ctypes.Structure):
    _fields_ = [("level", ctypes.c_float), ("held", ctypes.c_int)]


def test_the_float_c_decides_as_the_record_does(tmp_path: Path) -> None:
    """Two equilibria of paper B in one module: whole sequences of states, entering, leaving, NaN."""
    every = [(1, -1, 1, -1, 1), (-1, -1, -1, 1, 1)]
    table = gain_table(regulators(paper_b(), every, sample=1e-3), limit=30.0)
    folder = generate_controller(table, tmp_path, "float")
    library = folder / "table.so"
    source = str(folder / "handmade_spatial_controller.c")
    done = subprocess.run(["cc", *STRICT, source, "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    law = ctypes.CDLL(str(library)).handmade_spatial_controller
    state, measured, u = _State(0.0, -1), (ctypes.c_float * 34)(), (ctypes.c_float * 2)()
    held = -1
    for number in range(6):
        which, level = number // 3, (0.6, 2.0, 9.0)[number % 3]
        shape = np.array(table.shapes[which])
        part = np.random.default_rng(number).normal(size=len(shape))
        x = np.array(table.targets[which]) + np.linalg.lstsq(shape, part / np.linalg.norm(part) * np.sqrt(level), rcond=None)[0]
        measured[:] = x
        held, found = table.supervise(held, np.array(measured, dtype=float))
        assert law(ctypes.byref(state), measured, u) == held == state.held
        assert state.level == pytest.approx(found, rel=2e-3)
        assert np.allclose(u, table.inputs(held, np.array(measured, dtype=float)), rtol=1e-2, atol=2e-2)
    measured[3] = np.nan
    state.held = 1
    assert law(ctypes.byref(state), measured, u) == -1 and list(u) == [0.0, 0.0]


def test_casadi_has_the_same_table(tmp_path: Path) -> None:
    table = TABLES["plane"]
    folder = generate_controller(table, tmp_path)
    spec = importlib.util.spec_from_file_location(folder.name, folder / f"{folder.name}_casadi.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    x = on_level(table, 2, 0.5)
    levels = np.array(getattr(module, f"{folder.name}_levels")()(x)).ravel()
    assert levels == pytest.approx([float(table.level(k, x)) for k in range(4)], rel=1e-9)
    assert int(np.argmin(np.array(getattr(module, f"{folder.name}_apart")()(x)))) == table.closest(x) == 2
    assert np.array(getattr(module, folder.name)(2)(x)).ravel() == pytest.approx(table.inputs(2, x), rel=1e-9)


def test_a_table_on_file_is_the_same_record(tmp_path: Path) -> None:
    for table in TABLES.values():
        assert GainTable.from_npz(table.to_npz(tmp_path / "table.npz")) == table
    assert "gains of 4 equilibria" in str(TABLES["plane"])
    law = lqr(CHAINS["plane"]).law()
    with pytest.raises(OutputError, match="holds a StateFeedback, not a GainTable"):
        GainTable.from_npz(law.to_npz(tmp_path / "law.npz"))


def test_tables_that_do_not_fit_are_refused() -> None:
    one, table = lqr(CHAINS["plane"], sample=PERIOD), TABLES["plane"]
    for call, error, words in (
        (lambda: gain_table([]), ControlError, "table: holds no regulator"),
        (lambda: gain_table([one, lqr(CHAINS["plane"])]), ControlError, "mixes regulators of different chains or periods"),
        (lambda: gain_table([one, one]), ArrayError, "hold no equilibrium, or one twice"),
        (lambda: gain_table([one], reach=2.0), ControlError, "reach: is no angle between 0 and a quarter turn"),
        (lambda: gain_table([one], leave=0.5), ArrayError, "leave: would let go before it takes up"),
        (lambda: gain_table([one], limit=-1.0), ArrayError, "limit: is not positive"),
        (lambda: replace(table, leave=0.0), ArrayError, "table.leave: lets go before"),
        (lambda: replace(table, gains=()), ArrayError, "table.gains: must hold finite numbers"),
        (lambda: replace(table, low=(11.0,)), ArrayError, "leave nothing for u_0"),
        (lambda: replace(table, compared=(99,)), ArrayError, "do not fit the state"),
    ):
        with pytest.raises(error, match=words):
            call()
