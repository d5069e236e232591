"""Oracle, C and CasADi compute the same, on a thousand random states of every kind of scene.

The oracle runs the Programs with loops, in NumPy. Where the C is straight-line code, agreement therefore also says that
unrolling, sharing and folding changed nothing.
"""

from __future__ import annotations

import runpy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.emit import library_files
from phichain.files import write_folder
from phichain.ir import Program, evaluate, evaluate_exactly
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native import Cache, CompilerOptions, build_folder
from phichain.scene import Scene
from phichain.system import System
from tests.agreement.scenes import FLOAT_SCENES, SCENES, Arguments, random_states

STATES = 1000
FEWER = 50
QUICK = CompilerOptions(flags=("-std=c99", "-O1", "-ffp-contract=fast", "-fPIC", "-shared"))


@dataclass(frozen=True)
class Case:
    """A scene, its generated folder, its Programs with loops, its compiled functions, and states for them."""

    scene: Scene
    folder: Path
    programs: Mapping[str, Program]
    system: System
    states: Arguments

    def inputs(self, name: str) -> list[NDArray[np.float64]]:
        """The arguments of a function in the order of the C, the states first."""
        return [self.states[array.name] for array in self.programs[name].inputs]

    def params(self) -> dict[str, NDArray[np.float64]]:
        """The runtime parameters by name."""
        return {array.name: self.states[array.name] for array in next(iter(self.programs.values())).params}

    def oracle(self, name: str) -> dict[str, NDArray[np.float64]]:
        """What the Program says; parameters are repeated for every state."""
        program = self.programs[name]
        given = {array.name: self.states[array.name] for array in program.inputs}
        repeated = {k: np.broadcast_to(v, (STATES, *v.shape)) for k, v in self.params().items()}
        return evaluate(program, {**given, **repeated})


@pytest.fixture(scope="module")
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    """Everything about one scene, made once for all tests of it."""
    scene: Scene = request.param
    scratch = tmp_path_factory.mktemp(scene.name)
    programs = dict(lower(derive(replace(scene, code="loops"))).wanted)
    folder = write_folder(scratch / scene.name, library_files(scene, lower(derive(scene))))
    system = build_folder(folder, QUICK, Cache(scratch / "cache"))
    states = random_states(scene, programs, STATES, seed=sum(map(ord, scene.name)))
    return Case(scene, folder, programs, system, states)


def over(*scenes: Scene) -> Callable[[Any], Any]:
    return pytest.mark.parametrize("case", scenes, indirect=True, ids=lambda scene: scene.name)


def judged(outputs: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Outputs as (states, entries): each array by itself, scalars as one vector (an energy may well be zero)."""
    rows = {name: np.asarray(values, dtype=float).reshape(STATES, -1) for name, values in outputs.items()}
    scalars = [name for name, values in outputs.items() if np.size(values) == STATES]
    joined = {"scalars": np.concatenate([rows.pop(name) for name in scalars], axis=1)} if scalars else {}
    return rows | joined


def errors(found: Mapping[str, Any], expected: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Max norm of the difference over max norm of what is expected, by output and state."""
    actual, wanted = judged(found), judged(expected)
    scale = {name: np.max(np.abs(values), axis=1) for name, values in wanted.items()}
    # What rounding leaves of a residual, which is one of unit lengths, has no digits of its own.
    if "residual" in expected:
        scale["scalars"] = np.ones(STATES)
    # An error estimate is far below the state that it belongs to and that it is formed from.
    scale |= {name: scale["v_next"] for name in scale if name.endswith("_error")}
    return {
        name: np.max(np.abs(actual[name] - values), axis=1) / np.where(scale[name] > 0.0, scale[name], 1.0)
        for name, values in wanted.items()
    }


def results(case: Case, name: str) -> dict[str, NDArray[np.float64]]:
    """What the C says, by output."""
    found = getattr(case.system, name)(*case.inputs(name), p=case.params() or None)
    outputs = case.programs[name].outputs
    return dict(zip((a.name for a in outputs), found if len(outputs) > 1 else [found], strict=True))


@pytest.mark.long
@over(*SCENES)
def test_c_is_the_oracle(case: Case) -> None:
    assert set(case.programs) == set(case.scene.want)
    for name in case.programs:
        found, expected = results(case, name), case.oracle(name)
        assert {k: v.shape for k, v in found.items()} == {k: v.shape for k, v in expected.items()}
        for output, error in errors(found, expected).items():
            assert np.max(error) <= 1e-12, (name, output)


@pytest.mark.long
@over(*FLOAT_SCENES)
def test_c_in_single_precision_is_the_oracle_rounded(case: Case) -> None:
    """Rounding errors grow with the condition of a state: judged by their median, the worst one loosely."""
    for name in case.programs:
        found = results(case, name)
        assert {values.dtype for values in found.values()} == {np.dtype(np.float32)}
        for output, error in errors(found, case.oracle(name)).items():
            assert np.median(error) <= 1e-6, (name, output)
            assert np.max(error) <= 1e-3, (name, output)


@over(*SCENES)
def test_state_jacobian_is_the_complex_step_of_the_oracle(case: Case) -> None:
    found = results(case, "state_jacobian")
    arguments = [array.name for array in case.programs["forward_dynamics"].inputs]
    assert list(found) == [f"dad{name}" for name in arguments]
    for name in arguments:
        expected = complex_step(case, case.programs["forward_dynamics"], name)
        error = np.max(np.abs(found[f"dad{name}"][:FEWER] - expected), axis=(1, 2))
        assert np.all(error <= 1e-12 * np.max(np.abs(expected), axis=(1, 2))), name


def complex_step(case: Case, program: Program, argument: str) -> NDArray[np.float64]:
    """Derivative of the function's one output by an input array: (states, rows, columns)."""
    given = {array.name: case.states[array.name][:FEWER] for array in program.inputs} | case.params()
    columns = []
    for column in range(given[argument].shape[1]):
        moved = given[argument].astype(complex)
        moved[:, column] += 1e-40j
        (result,) = evaluate(program, {**given, argument: moved}).values()
        columns.append(result.imag / 1e-40)
    return np.stack(columns, axis=-1)


@over(*(scene for scene in SCENES if "phi_jacobian" in scene.want))
def test_phi_jacobian_is_the_difference_quotient_of_the_oracle_in_50_digits(case: Case) -> None:
    """SciPy's Bessel functions lose an imaginary part of 1e-40, mpmath's digits do not run out."""
    found = results(case, "phi_jacobian")["out"]
    for state in range(2):
        given = {name: list(np.ravel(values)) for name, values in case.params().items()}
        given |= {name: list(np.ravel(case.states[name][state])) for name in ("amplitude", "omega")}
        entries = [*(("amplitude", k) for k in range(case.scene.nv)), ("omega", 0)]
        columns = [difference_quotient(case.programs["phi"], given, *entry) for entry in entries]
        expected = np.stack(columns, axis=1)
        assert np.max(np.abs(found[state] - expected)) <= 1e-13 * np.max(np.abs(expected))


def difference_quotient(
    program: Program, given: dict[str, list[Any]], name: str, entry: int
) -> NDArray[np.float64]:
    """Derivative of `out` by one entry of an input, its error about 1e-28."""
    step = mpmath.mpf("1e-14")
    sides = []
    with mpmath.workdps(50):
        for side in (step, -step):
            moved = [mpmath.mpf(value) + (side if k == entry else 0) for k, value in enumerate(given[name])]
            sides.append(evaluate_exactly(program, {**given, name: moved})["out"])
        return np.array([float((a - b) / (2 * step)) for a, b in zip(*sides, strict=True)])


@pytest.mark.long
@over(*SCENES, *FLOAT_SCENES)
def test_casadi_is_the_oracle(case: Case) -> None:
    """CasADi computes in double precision whatever the scene says."""
    pytest.importorskip("casadi")
    module = runpy.run_path(str(case.folder / f"{case.scene.name}_casadi.py"))
    stacked = [np.concatenate([np.ravel(value) for value in case.params().values()])] if case.params() else []
    for name, program in case.programs.items():
        given = [np.tile(p[:, None], STATES) for p in stacked]
        given += [np.reshape(values, (STATES, -1)).T for values in case.inputs(name)]
        columns = module[name]().map(STATES).call(given)
        found = {a.name: as_rows(np.array(c), a.shape) for a, c in zip(program.outputs, columns, strict=True)}
        for output, error in errors(found, case.oracle(name)).items():
            assert np.max(error) <= 1e-12, (name, output)


def as_rows(columns: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """CasADi's results side by side -> (states, *shape)."""
    if len(shape) < 2:
        return columns.T
    return columns.reshape(shape[0], STATES, shape[1]).swapaxes(0, 1)


def test_the_scenes_cover_every_kind() -> None:
    """A change of the list shall not lose a kind of scene without notice."""
    kinds: dict[str, set[Any]] = {
        "base and masses": {(s.space, s.base, s.tip_masses) for s in SCENES},
        "code": {(s.space, s.code) for s in SCENES},
        "runtime": {(s.space, bool(s.runtime)) for s in SCENES},
        "springs": {(s.space, s.stiffness is not None) for s in SCENES},
        "dampers": {(s.space, s.damping is not None) for s in SCENES},
        "angles": {s.angles for s in SCENES},
        "actuated": {"list" if isinstance(s.actuated, tuple) else s.actuated for s in SCENES},
    }
    counts = {kind: len(found) for kind, found in kinds.items()}
    assert counts == {**dict.fromkeys(kinds, 4), "base and masses": 10}
