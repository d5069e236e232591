"""NAME_casadi.c: what casadi.external computes from it, its Jacobians, and the symbols it defines."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.contract.functions import FLOWS
from phichain.emit.casadi.external import casadi_external
from phichain.emit.casadi.tangent import make_tangent
from phichain.emit.printed import print_scene
from phichain.ir.evaluate import evaluate, evaluate_exactly
from phichain.ir.nodes import Program
from phichain.lowering.lower import lower
from phichain.mechanics import derive
from tests.emit.casadi_scenes import make_scene, random_arguments, random_batch, relative_error, stacked
from tests.emit.external_scenes import KINDS, STRICT, Built, run

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")

STATES = 3


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


@pytest.mark.long
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


def symbols(folder: Path, file: str, kinds: str) -> set[str]:
    """Names in an object file whose letter nm prints among `kinds`."""
    lines = (line.split() for line in run(folder, "nm", file).splitlines())
    return {words[-1] for words in lines if words[-2] in kinds}


@pytest.mark.long
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
