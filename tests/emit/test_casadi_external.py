"""NAME_casadi.c: what casadi.external computes from it, its Jacobians, and what it leaves alone."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.contract.functions import FLOWS
from phichain.emit.c.text import header, source
from phichain.emit.casadi.external import casadi_external
from phichain.emit.casadi.tangent import make_tangent
from phichain.emit.printed import print_scene
from phichain.errors import UnsupportedError
from phichain.ir.evaluate import evaluate, evaluate_exactly
from phichain.ir.nodes import Program
from phichain.lowering.lower import Lowered, lower
from phichain.mechanics import derive
from phichain.scene import Scene, standard_scene
from tests.emit.casadi_scenes import (
    SCENES,
    make_scene,
    random_arguments,
    random_batch,
    relative_error,
    stacked,
)
from tests.offered import DERIVATIVES

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")

STRICT = [
    "-std=c99",
    "-pedantic-errors",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wdouble-promotion",
    "-Wfloat-conversion",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Wmissing-prototypes",
    "-Wcast-qual",
    "-Wundef",
    "-Wvla",
    "-Werror",
]

STATES = 3
KINDS = {
    "planar": standard_scene(2),
    "planar_cart": make_scene(
        "hoist",
        2,
        base="cart",
        com="runtime",
        mass="runtime",
        cart_mass="runtime",
        gravity="runtime",
        stiffness="runtime",
        damping="runtime",
        actuated="all",
    ),
    "spatial_loops": make_scene("rope", 2, "spatial", "cart", code="loops", stiffness=2.0),
    "planar_loops": make_scene("swing", 3, code="loops", angles="absolute", actuated="all", length="runtime"),
    "one_link": make_scene("pendulum", 1, want=("forward_dynamics", "mass_matrix", "positions")),
}


@dataclass(frozen=True)
class Built:
    """A compiled scene."""

    scene: Scene
    lowered: Lowered
    folder: Path

    @property
    def library(self) -> Path:
        return self.folder / f"{self.scene.name}.so"

    @property
    def differentiable(self) -> dict[str, Program]:
        """The functions that come with Jacobians: those that are no derivatives themselves."""
        return {
            name: program for name, program in self.lowered.wanted.items() if name not in DERIVATIVES
        }

    def external(self, function: str) -> Any:
        return casadi.external(f"{self.scene.name}_casadi_{function}", str(self.library))


def write(scene: Scene, lowered: Lowered, folder: Path) -> list[str]:
    """Write a scene's C files; returns the names of those to compile."""
    printed = print_scene(scene, lowered)
    texts = {
        f"{scene.name}.h": header(printed, {}),
        f"{scene.name}.c": source(printed),
        f"{scene.name}_casadi.c": casadi_external(printed),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return [name for name in texts if name.endswith(".c")]


def run(folder: Path, *command: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return done.stdout


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Built]:
    """Compiles the scene of a kind, once, with the strict flags."""
    made: dict[str, Built] = {}

    def build_kind(kind: str) -> Built:
        if kind not in made:
            scene, folder = KINDS[kind], tmp_path_factory.mktemp(kind)
            lowered = lower(derive(scene))
            files = write(scene, lowered, folder)
            run(folder, "cc", *STRICT, "-O1", "-fPIC", "-shared", *files, "-o", f"{scene.name}.so", "-lm")
            made[kind] = Built(scene, lowered, folder)
        return made[kind]

    return build_kind


def derivative(program: Program, arguments: dict[str, Any], argument: str) -> dict[str, NDArray[np.float64]]:
    """d(output)/d(argument) by complex steps: exact to rounding. Bessel functions take theirs at 50 digits."""
    value = np.asarray(arguments[argument])
    if program.name.startswith("phi"):
        columns = [_exact_column(program, arguments, argument, i) for i in range(value.size)]
        return {
            array.name: np.array([column[array.name] for column in columns]).T for array in program.outputs
        }
    step = 1e-100
    moved = value + 1j * step * np.eye(value.size).reshape(value.size, *value.shape)
    results = evaluate(program, {**arguments, argument: moved})
    return {
        array.name: np.moveaxis(results[array.name].imag / step, 0, -1).reshape(array.size, -1)
        for array in program.outputs
    }


def _exact_column(
    program: Program, arguments: dict[str, Any], argument: str, column: int
) -> dict[str, list[float]]:
    step = mpmath.mpf(10) ** -30
    moved: dict[str, list[Any]] = {name: [*np.ravel(value).tolist()] for name, value in arguments.items()}
    moved[argument][column] = mpmath.mpc(moved[argument][column], step)
    results = evaluate_exactly(program, moved)
    return {name: [float(mpmath.im(value) / step) for value in values] for name, values in results.items()}


def as_casadi_counts(array: Any, jacobian: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of a Jacobian in the order in which CasADi stacks a matrix: column by column."""
    rows, columns = (*array.shape, 1, 1)[:2]
    return jacobian[np.arange(array.size).reshape(rows, columns).ravel(order="F")]


@pytest.mark.parametrize("kind", KINDS)
def test_values_are_those_of_the_programs(kind: str, build: Callable[[str], Built]) -> None:
    built = build(kind)
    for name, program in built.lowered.wanted.items():
        function = built.external(name)
        assert function.name_in()[-len(program.inputs) :] == [array.name for array in program.inputs]
        assert function.name_out() == [array.name for array in program.outputs]
        single, batch = random_batch(program, STATES, built.scene.space)
        expected = evaluate(program, batch)
        for state, arguments in enumerate(single):
            actual = function.call([casadi.DM(value) for value in stacked(program, arguments)])
            for array, value in zip(program.outputs, actual, strict=True):
                assert value.shape == (*array.shape, 1, 1)[:2]
                error = relative_error(value.full().reshape(array.shape), expected[array.name][state])
                assert error < 1e-12, (name, array.name)


@pytest.mark.parametrize("kind", KINDS)
def test_jacobians_are_the_complex_step_derivatives(kind: str, build: Callable[[str], Built]) -> None:
    built = build(kind)
    for name, program in built.differentiable.items():
        function = built.external(name)
        jacobian = function.jacobian()
        assert jacobian.is_a("External")  # not CasADi's finite differences
        arguments = random_arguments(program, np.random.default_rng(5), built.scene.space)
        given = [casadi.DM(value) for value in stacked(program, arguments)]
        blocks = dict(zip(jacobian.name_out(), jacobian.call([*given, *[0] * function.n_out()]), strict=True))
        for argument in (array.name for array in program.inputs):
            exact = derivative(program, arguments, argument)
            for array in program.outputs:
                block = blocks[f"jac_{array.name}_{argument}"]
                assert relative_error(block.full(), as_casadi_counts(array, exact[array.name])) < 1e-12, (
                    name,
                    argument,
                )
        if program.params:
            _check_parameter_columns(program, arguments, blocks)


def _check_parameter_columns(program: Program, arguments: dict[str, Any], blocks: dict[str, Any]) -> None:
    by_parameter = [derivative(program, arguments, array.name) for array in program.params]
    for array in program.outputs:
        exact = np.concatenate([one[array.name] for one in by_parameter], axis=1)
        error = relative_error(blocks[f"jac_{array.name}_p"].full(), as_casadi_counts(array, exact))
        assert error < 1e-12, (program.name, array.name)


@pytest.mark.parametrize("kind", ["planar", "planar_cart", "spatial_loops"])
def test_patterns_hold_every_nonzero_and_leave_out_structural_zeros(
    kind: str, build: Callable[[str], Built]
) -> None:
    built = build(kind)
    left_out = 0
    for name, program in built.differentiable.items():
        jacobian = built.external(name).jacobian()
        arguments = random_arguments(program, np.random.default_rng(6), built.scene.space)
        for argument in (array.name for array in program.inputs):
            exact = derivative(program, arguments, argument)
            for array in program.outputs:
                pattern = jacobian.sparsity_out(jacobian.index_out(f"jac_{array.name}_{argument}"))
                full = casadi.DM(pattern, 1.0).full() != 0
                assert not np.any((as_casadi_counts(array, exact[array.name]) != 0) & ~full), (name, argument)
                left_out += pattern.numel() - pattern.nnz()
    assert left_out > 0


def test_the_pattern_of_positions_is_lower_triangular(build: Callable[[str], Built]) -> None:
    """In relative angles the position of mass i depends on the angles up to i."""
    jacobian = build("planar").external("positions").jacobian()
    pattern = casadi.DM(jacobian.sparsity_out(0), 1.0).full()
    # rows: horizontal of masses 1 and 2, then depth of masses 1 and 2
    assert pattern.tolist() == [[1, 0], [1, 1], [1, 0], [1, 1]]


def test_constant_results_have_empty_jacobians(build: Callable[[str], Built]) -> None:
    jacobian = build("one_link").external("mass_matrix").jacobian()
    assert jacobian.nnz_out(0) == 0
    assert make_tangent(derive(KINDS["one_link"]), "mass_matrix").program is None


def test_derivatives_come_without_jacobians_and_the_file_says_so(build: Callable[[str], Built]) -> None:
    built = build("planar")
    text = (built.folder / "planar2_casadi.c").read_text()
    assert "Without a Jacobian, being derivatives themselves: state_jacobian, phi_jacobian." in text
    with pytest.raises(RuntimeError, match="Derivatives cannot be calculated"):
        built.external("phi_jacobian").jacobian()
    scene = make_scene("plain", 2, want=("energy",))
    assert "Without a Jacobian" not in casadi_external(print_scene(scene, lower(derive(scene))))


def test_functions_work_inside_mx_expressions(build: Callable[[str], Built]) -> None:
    """The gradient of a cost over three steps, by CasADi's reverse mode through our Jacobians."""
    built = build("planar")
    step, energy = built.external("step"), built.external("energy")
    u, start = casadi.MX.sym("u", 6), [0.4, -0.2]
    q, v = casadi.MX(start), casadi.MX.zeros(2)
    for k in range(3):
        q, v = step(0.05, q, v, u[2 * k : 2 * k + 2])
    kinetic, potential = energy(q, v)
    cost = kinetic + potential + 1e-3 * casadi.sumsqr(u)
    gradient = casadi.Function("gradient", [u], [casadi.gradient(cost, u)])
    at = np.linspace(-0.5, 0.7, 6)
    assert relative_error(gradient(at).full().ravel(), _rollout_gradient(built.lowered, at)) < 1e-12


def _rollout_gradient(lowered: Lowered, at: NDArray[np.float64]) -> NDArray[np.float64]:
    u = at + 1e-100j * np.eye(6)
    state: dict[str, Any] = {"q_next": np.array([0.4, -0.2]), "v_next": np.zeros(2)}
    for k in range(3):
        arguments = {"h": 0.05, "q": state["q_next"], "v": state["v_next"], "u": u[:, 2 * k : 2 * k + 2]}
        state = evaluate(lowered.wanted["step"], arguments)
    energy = evaluate(lowered.wanted["energy"], {"q": state["q_next"], "v": state["v_next"]})
    cost = energy["kinetic"] + energy["potential"] + 1e-3 * np.sum(u**2, axis=-1)
    return np.asarray(cost.imag / 1e-100)


def test_an_optimiser_finds_the_torques_that_hold_a_pose(build: Callable[[str], Built]) -> None:
    """A nonlinear program with forward_dynamics as constraint; the answer is the gravity torque."""
    built = build("planar")
    u, pose = casadi.MX.sym("u", 2), [0.7, -1.1]
    acceleration = built.external("forward_dynamics")(pose, [0.0, 0.0], u)
    problem = {"x": u, "f": casadi.sumsqr(u), "g": acceleration}
    quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-12}
    solver = casadi.nlpsol(
        "hold", "ipopt", problem, {**quiet, "ipopt.hessian_approximation": "limited-memory"}
    )
    found = solver(x0=[0.0, 0.0], lbg=0.0, ubg=0.0)["x"].full().ravel()
    assert solver.stats()["success"]
    expected = evaluate(built.lowered.wanted["gravity_torque"], {"q": np.array(pose)})["out"]
    assert relative_error(found, expected) < 1e-9


def test_null_arguments_are_zeros_and_null_results_are_not_written(build: Callable[[str], Built]) -> None:
    built = build("planar")
    library = ctypes.CDLL(str(built.library))
    pointers, real = ctypes.POINTER(ctypes.c_double), ctypes.c_double
    work = (real * 200)()
    for symbol, results in (("planar2_casadi_energy", 2), ("jac_planar2_casadi_energy", 4)):
        function = getattr(library, symbol)
        nothing = (pointers * 4)()
        assert function(nothing, (pointers * results)(), None, work, 0) == 0
    kinetic, potential = real(9.0), real(9.0)
    wanted = (pointers * 2)(None, ctypes.pointer(potential))
    assert library.planar2_casadi_energy((pointers * 2)(), wanted, None, work, 0) == 0
    expected = evaluate(built.lowered.wanted["energy"], {"q": np.zeros(2), "v": np.zeros(2)})
    assert potential.value == pytest.approx(float(expected["potential"]), rel=1e-15)
    assert kinetic.value == 9.0


def symbols(folder: Path, file: str, kinds: str) -> set[str]:
    """Names in an object file whose letter nm prints among `kinds`."""
    lines = (line.split() for line in run(folder, "nm", file).splitlines())
    return {words[-1] for words in lines if words[-2] in kinds}


@pytest.mark.parametrize("kind", ["planar", "spatial_loops"])
def test_symbols_carry_the_scene_s_name_and_no_state(kind: str, build: Callable[[str], Built]) -> None:
    built = build(kind)
    name, folder = built.scene.name, built.folder
    run(folder, "cc", *STRICT, "-O1", "-fno-pie", "-c", f"{name}.c", f"{name}_casadi.c")
    plain, ours = symbols(folder, f"{name}.o", "T"), symbols(folder, f"{name}_casadi.o", "TDBRC")
    assert plain == {f"{name}_{function}" for function in built.scene.want}
    assert not plain & ours
    companions = ("", "_n_in", "_n_out", "_name_in", "_name_out", "_sparsity_in", "_sparsity_out", "_work")
    assert ours == {
        f"{function}{companion}"
        for function in (
            *(f"{name}_casadi_{function}" for function in built.scene.want if function not in FLOWS),
            *(f"jac_{name}_casadi_{function}" for function in built.differentiable),
        )
        for companion in companions
    }
    assert not symbols(folder, f"{name}_casadi.o", "dDbBC")  # nothing that could be written to
    called = symbols(folder, f"{name}_casadi.o", "U")
    assert called <= plain | {"sin", "cos", "sqrt", "sincos", "memcpy", "memset", "__stack_chk_fail"}


def test_several_scenes_share_one_shared_object(tmp_path: Path) -> None:
    scenes = [make_scene(name, 2, want=("forward_dynamics", "energy")) for name in ("left", "right")]
    files = [file for scene in scenes for file in write(scene, lower(derive(scene)), tmp_path)]
    run(tmp_path, "cc", *STRICT, "-O0", "-fPIC", "-shared", *files, "-o", "both.so", "-lm")
    both = [casadi.external(f"{s.name}_casadi_forward_dynamics", str(tmp_path / "both.so")) for s in scenes]
    assert relative_error(both[0]([0.1, 0.2], [0, 0]).full(), both[1]([0.1, 0.2], [0, 0]).full()) == 0


def test_each_kind_of_scene_compiles(tmp_path: Path) -> None:
    for scene in SCENES[::5]:
        small = replace(scene, want=("mass_matrix", "linearization"))
        files = write(small, lower(derive(small)), tmp_path)
        run(tmp_path, "cc", *STRICT, "-O0", "-c", *files)


def test_single_precision_is_refused() -> None:
    scene = replace(standard_scene(2), real="float")
    with pytest.raises(UnsupportedError) as caught:
        casadi_external(print_scene(scene, lower(derive(scene))))
    assert str(caught.value) == (
        "real: CasADi calls functions in double precision (got 'float'); "
        'set target.real = "double", or use planar2_casadi.py'
    )


def test_the_same_scene_gives_the_same_text() -> None:
    scene = make_scene("again", 2, want=("forward_dynamics", "mass_matrix"), gravity="runtime")
    first = casadi_external(print_scene(scene, lower(derive(scene))))
    assert first == casadi_external(print_scene(scene, lower(derive(scene))))
    assert all(line == line.rstrip() for line in first.splitlines())
    assert first.endswith("}\n")
    assert not re.search(r"\b(malloc|calloc|alloca|free)\b", first)
