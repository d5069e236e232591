"""NAME_casadi.py: what it needs, what it offers, and that CasADi computes from it what the Programs say."""

from __future__ import annotations

import ast
import warnings
from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from phichain.emit.casadi.module import casadi_module
from phichain.ir.evaluate import evaluate
from phichain.ir.nodes import Program
from phichain.ir.passes import unroll
from phichain.lowering.lower import Lowered, lower
from phichain.mechanics import derive
from phichain.scene import Scene, standard_scene
from tests.emit.casadi_scenes import (
    SCENES,
    SINGLE,
    make_scene,
    random_arguments,
    random_batch,
    relative_error,
    stacked,
)

casadi = pytest.importorskip("casadi")

STATES = 8
NAMES = [scene.name for scene in (*SCENES, *SINGLE)]


@cache
def lowered_by_name(name: str) -> tuple[Scene, Lowered]:
    scene = next(scene for scene in (*SCENES, *SINGLE) if scene.name == name)
    return scene, lower(derive(scene))


def load(text: str) -> ModuleType:
    module = ModuleType("generated")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(compile(text, "generated.py", "exec"), module.__dict__)  # noqa: S102
    return module


@cache
def text_by_name(name: str) -> str:
    return casadi_module(*lowered_by_name(name))


@cache
def function_by_name(name: str, function_name: str) -> Any:
    return getattr(load(text_by_name(name)), function_name)()


def operations(function: Any) -> int:
    """How many operations CasADi executes, moving data in and out not counted."""
    moves = (casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST)
    return sum(function.instruction_id(i) not in moves for i in range(function.n_instructions()))


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_functions_agree_with_the_programs_on_random_states(name: str) -> None:
    scene, lowered = lowered_by_name(name)
    for function_name, program in lowered.wanted.items():
        function = function_by_name(name, function_name)
        single, batch = random_batch(program, STATES, scene.space)
        expected = evaluate(program, batch)
        for state, arguments in enumerate(single):
            actual = function.call([casadi.DM(value) for value in stacked(program, arguments)])
            for array, value in zip(program.outputs, actual, strict=True):
                error = relative_error(value.full().reshape(array.shape), expected[array.name][state])
                assert error < 1e-12, (function_name, array.name)


@pytest.mark.parametrize("name", NAMES)
def test_arguments_and_results_have_the_contract_s_names_order_and_shapes(name: str) -> None:
    scene, lowered = lowered_by_name(name)
    for function_name, program in lowered.wanted.items():
        function = function_by_name(name, function_name)
        assert function.name() == function_name
        parameters = ["p"] if scene.runtime else []
        assert function.name_in() == [*parameters, *(array.name for array in program.inputs)]
        assert function.name_out() == [array.name for array in program.outputs]
        for i, array in enumerate(program.outputs):
            assert function.size_out(i) == (*array.shape, 1, 1)[:2]
            assert function.sparsity_out(i).is_dense()
        if scene.runtime:
            assert function.size1_in(0) == sum(array.size for array in program.params)


@pytest.mark.parametrize(
    "name", [scene.name for scene in SCENES if scene.links < 3 or scene.space == "planar"]
)
def test_casadi_s_derivative_of_forward_dynamics_is_state_jacobian(name: str) -> None:
    scene, lowered = lowered_by_name(name)
    function = function_by_name(name, "forward_dynamics")
    program = lowered.wanted["state_jacobian"]
    arguments = random_arguments(program, np.random.default_rng(7), scene.space)
    expected = evaluate(program, arguments)
    values = [casadi.DM(value) for value in stacked(program, arguments)]
    for argument in (array.name for array in program.inputs):
        jacobian = function.factory("jacobian", function.name_in(), [f"jac:a:{argument}"])
        assert relative_error(jacobian.call(values)[0].full(), expected[f"dad{argument}"]) < 1e-12


def test_derivatives_of_phi_are_exact_in_both_regions_of_the_bessel_functions() -> None:
    scene = standard_scene(2)
    lowered = lower(derive(scene))
    module = load(casadi_module(scene, lowered))
    phi = module.phi()
    amplitude, omega = casadi.SX.sym("amplitude", 2), casadi.SX.sym("omega")
    by_casadi = casadi.jacobian(phi(amplitude, omega), casadi.vertcat(amplitude, omega))
    derivative = casadi.Function("derivative", [amplitude, omega], [by_casadi])
    for swing in ([0.3, -0.1], [3.0, 40.0], [-60.0, 20.0], [0.0, 0.0]):
        arguments = {"amplitude": np.array(swing), "omega": np.array(3.7)}
        expected = evaluate(lowered.wanted["phi_jacobian"], arguments)["out"]
        assert relative_error(derivative(swing, 3.7).full(), expected) < 1e-12
        assert relative_error(module.phi_jacobian()(swing, 3.7).full(), expected) < 1e-12


def test_loops_leave_the_expression_graph_of_straight_line_code() -> None:
    for scene in (scene for scene in SCENES if scene.name.endswith("tip_fixed_numbers")):
        straight = replace(scene, code="unrolled")
        unrolled = load(casadi_module(straight, lower(derive(straight))))
        for name in scene.want:
            if name in ("mass_matrix", "gravity_torque") and scene.space == "spatial":
                continue  # a few signs more: CasADi does not pull them into constant factors
            assert operations(function_by_name(scene.name, name)) <= 1.1 * operations(
                getattr(unrolled, name)()
            ), name


def test_straight_line_code_is_printed_where_the_scene_asks_for_it() -> None:
    scene = replace(standard_scene(3), code="unrolled", want=("forward_dynamics", "phi", "step"))
    lowered = lower(derive(scene))
    text = casadi_module(scene, lowered)
    equations = [
        part for part in text.split("\n\n\n") if part.startswith(("def _forward", "def _step", "def _phi"))
    ]
    assert len(equations) == 3
    assert not any(" for " in part for part in equations)
    module = load(text)
    for name, program in lowered.wanted.items():
        arguments = random_arguments(program, np.random.default_rng(3), "planar")
        expected = evaluate(program, arguments)
        actual = getattr(module, name)().call([casadi.DM(value) for value in stacked(program, arguments)])
        for array, value in zip(program.outputs, actual, strict=True):
            assert relative_error(value.full(), expected[array.name]) < 1e-12


def test_length_of_the_text_does_not_grow_with_the_chain() -> None:
    texts = []
    for links in (16, 64):
        scene = replace(
            standard_scene(links), want=("forward_dynamics", "inverse_dynamics", "energy", "step")
        )
        texts.append(casadi_module(scene, lower(derive(scene))))
    equations = [text[text.index("def _forward_dynamics") :] for text in texts]
    assert len(equations[1].splitlines()) == len(equations[0].splitlines())
    assert len(equations[1]) < 1.1 * len(equations[0])


@pytest.mark.parametrize("name", NAMES)
def test_the_module_needs_casadi_alone(name: str) -> None:
    tree = ast.parse(text_by_name(name))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert [ast.unparse(node) for node in imports] == ["import casadi"]


@pytest.mark.parametrize("name", NAMES)
def test_public_names_are_the_wanted_functions(name: str) -> None:
    scene, _ = lowered_by_name(name)
    tree = ast.parse(text_by_name(name))
    defined = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    public = {name for name in defined if not name.startswith("_")}
    assert public - {"bessel"} == set(scene.want)
    assert len(defined) == len(set(defined))


def test_what_a_function_calls_comes_along_without_becoming_public() -> None:
    scene = make_scene("stepping", 2, want=("step",))
    module = load(casadi_module(scene, lower(derive(scene))))
    assert callable(module._forward_dynamics)
    assert not hasattr(module, "forward_dynamics")


def test_helpers_stand_only_where_something_needs_them() -> None:
    scene = make_scene("small", 3, want=("forward_dynamics",))
    text = casadi_module(scene, lower(derive(scene)))
    for absent in ("bessel", "_matrix", "_parameters", "runtime parameters"):
        assert absent not in text
    scene = make_scene("balanced", 3, want=("phi", "mass_matrix"), gravity="runtime")
    text = casadi_module(scene, lower(derive(scene)))
    for present in ("def bessel", "def _matrix", "def _parameters", "runtime parameters: gravity."):
        assert present in text


def test_parameters_are_stacked_in_the_order_of_the_c_struct() -> None:
    scene = make_scene(
        "stacked", 2, base="cart", com="runtime", mass="runtime", gravity="runtime", cart_mass="runtime",
        want=("positions", "gravity_torque"),
    )  # fmt: skip
    module = load(casadi_module(scene, lower(derive(scene))))
    assert "runtime parameters: mass, com, cart_mass, gravity." in module.__doc__
    p = np.array([1.0, 2.0, 0.3, 0.4, 5.0, 9.0])
    tip = module.positions()(p, [0.5, np.pi / 2, 0.0]).full()
    # link 1 (1.1 long) lies along +e_1 and carries link 2, which in relative angles lies along it
    assert tip == pytest.approx(np.array([[0.5 + 0.3, 0.0], [0.5 + 1.1 + 0.4, 0.0]]), abs=1e-15)
    torque = module.gravity_torque()(p, [0.0, np.pi / 2, 0.0]).full().ravel()
    assert torque == pytest.approx([0.0, 9.0 * (1.0 * 0.3 + 2.0 * 1.5), 9.0 * 2.0 * 0.4], rel=1e-14)


def test_the_same_scene_gives_the_same_text() -> None:
    scene = standard_scene(3)
    first, second = (
        casadi_module(scene, lower(derive(scene))),
        casadi_module(standard_scene(3), lower(derive(standard_scene(3)))),
    )
    assert first == second
    assert first.endswith("\n") and not first.endswith("\n\n")
    assert all(line == line.rstrip() for line in first.splitlines())


def program_names(program: Program) -> set[str]:
    return {array.name for array in (*program.inputs, *program.outputs)}


def test_every_argument_and_result_is_explained() -> None:
    for scene in SCENES[:2]:
        lowered = lower(derive(scene))
        module = load(text_by_name(scene.name))
        for name, program in lowered.wanted.items():
            documented = getattr(module, name).__doc__
            words = {
                line.split(":")[0].split("(")[0].strip() for line in documented.splitlines() if ":" in line
            }
            assert program_names(program) <= words


def test_loops_and_straight_line_code_are_the_same_function() -> None:
    """The module prints loops where the folder's C is straight-line: the two lowerings must not drift apart."""
    scene = SCENES[-1]
    loops, auto = lower(derive(replace(scene, code="loops"))).wanted, lower(derive(scene)).wanted
    rng = np.random.default_rng(11)
    for name, program in loops.items():
        arguments = random_arguments(program, rng, scene.space)
        for flat in (unroll(program), auto[name]):
            expected = evaluate(flat, arguments)
            for key, value in evaluate(program, arguments).items():
                assert relative_error(value, expected[key]) < 1e-12
