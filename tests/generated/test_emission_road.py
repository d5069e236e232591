"""Nothing on the way to a generated file goes through NumPy's or libm's floating point: read off the modules themselves.

The road is what `pipeline.generate` names and everything that those modules import. On it numbers are integers, fractions, mpf or
Python floats under +, -, *, / and square roots, all of which IEEE 754 or the library fixes to the last bit.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import phichain

ROOT = Path(phichain.__file__).parents[1]

#: Functions of `math` whose results are exact or correctly rounded everywhere.
EXACT = {
    "ceil", "comb", "copysign", "factorial", "floor", "frexp", "gcd", "inf", "isfinite", "isinf", "isnan", "isqrt", "lcm",
    "ldexp", "nan", "perm", "pi", "prod", "sqrt", "trunc",
}  # fmt: skip
FLOATING = {"numpy", "scipy", "cmath", "statistics"}
#: Modules that may use floating point, and why.
ALLOWED = {
    "phichain.ir.evaluate": "the oracle of tests and System, which `phichain.ir` offers; the road calls none of it",
    "phichain.laws.state_feedback": "a law called in a simulation computes; as a Program it is read field by field, no scene holds one",
    **dict.fromkeys(
        (
            "phichain.laws.family", "phichain.laws.gain_table", "phichain.laws.learning", "phichain.laws.numbers", "phichain.laws.observer",
            "phichain.laws.observer_along",
            "phichain.laws.output_feedback", "phichain.laws.output_table", "phichain.laws.table_memory", "phichain.laws.trajectory",
        ),
        "likewise",
    ),
    "phichain.archive.reader": "reads what a law was saved to",
    "phichain.archive.possible": "says what numbers of such a file can be",
    "phichain.archive.schema": "says what such a file holds",
    "phichain.records": "writes what a law is saved to",
    "phichain.held": "arrays of records are copies that nobody writes to",
    "phichain.origin": "what a file was made with, as JSON: arrays of numbers become lists",
}
#: Packages in which ** is no float's, and what it is of; elsewhere only powers of literal integers pass.
POWERS = {
    "phichain.reference": "mpf", "phichain.emit.selftest": "mpf and fractions", "phichain.mechanics": "SymPy expressions",
    "phichain.harmonic": "SymPy expressions", "phichain.lowering": "operations of a Program, fractions and mpf",
    "phichain.ir.rounded": "mpf", "phichain.emit.bessel": "integers and fractions", "phichain.proof": "integers modulo a prime",
}  # fmt: skip


def path_of(module: str) -> Path:
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def tree_of(module: str) -> ast.Module:
    return ast.parse(path_of(module).read_text())


def imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """What is imported, anywhere in the text: the name it gets, and the module that it is or comes from."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.asname or alias.name.split(".")[0], alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                is_module = whole.startswith("phichain.") and path_of(whole).exists()
                yield alias.asname or alias.name, whole if is_module else node.module


def registered(tree: ast.AST) -> Iterator[str]:
    """The modules that a registry of this text imports when it is first asked: all of its package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).split("[")[0] == "Registry":
            package = ast.literal_eval(node.args[0])
            for path in path_of(package).parent.rglob("*.py"):
                yield ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def first_modules() -> set[str]:
    """The modules of which `generate` and the functions of its own file that it calls name something."""
    tree = tree_of("phichain.pipeline")
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    named, waiting = set[str](), ["generate"]
    while waiting:
        used = {node.id for node in ast.walk(functions[waiting.pop()]) if isinstance(node, ast.Name)}
        waiting += [name for name in used & set(functions) if name not in named]
        named |= used
    return {module for name, module in imported(tree) if name in named and module.startswith("phichain.")}


@cache
def road() -> tuple[str, ...]:
    """Every module of the package on the way, packages that hold them too."""
    found, waiting = set[str](), first_modules()
    while waiting:
        module = waiting.pop()
        parts = module.split(".")
        news = {name for _, name in imported(tree_of(module)) if name.startswith("phichain.")}
        news |= set(registered(tree_of(module))) | {".".join(parts[:i]) for i in range(2, len(parts))}
        found.add(module)
        waiting |= news - found
    return tuple(sorted(found))


def faults(module: str, tree: ast.Module) -> list[str]:
    """What of a module depends on the processor or the C library, with its line."""
    found: list[str] = []
    if module in ALLOWED:
        return found
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
            if node.module == "math":
                found += [f"{node.lineno}: math.{a.name}" for a in node.names if a.name not in EXACT]
        found += [f"{node.lineno}: {name}" for name in names if name.split(".")[0] in FLOATING]
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "math":
            found += [f"{node.lineno}: math.{node.attr}"] if node.attr not in EXACT else []
        if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
            found.append(f"{node.lineno}: @")
        if is_power(node) and not any(module == p or module.startswith(f"{p}.") for p in POWERS):
            found.append(f"{node.lineno}: {ast.unparse(node)}")
        if has_float_literal_power(node):
            found.append(f"{node.lineno}: {ast.unparse(node)}")
    return found


def is_power(node: ast.AST) -> bool:
    """A power of something else than literal integers."""
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id == "pow"
    if not (isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow)):
        return False
    ends = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.target, node.value)
    return not all(isinstance(end, ast.Constant) and isinstance(end.value, int) for end in ends)


def has_float_literal_power(node: ast.AST) -> bool:
    """2.0**x, x**0.5: a float's power wherever it stands."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and any(
        isinstance(end, ast.Constant) and isinstance(end.value, float) for end in (node.left, node.right)
    )  # fmt: skip


@pytest.mark.long
def test_the_road_is_the_whole_one() -> None:
    assert {
        "phichain.scene.scene", "phichain.mechanics.lagrange", "phichain.lowering.rates", "phichain.reference.masses",
        "phichain.emit.selftest.cases", "phichain.emit.c.layout", "phichain.emit.flow.propagate", "phichain.ir.rounded",
        "phichain.lowering.steps.lie4", "phichain.reference.steps", "phichain.emit.casadi.external", "phichain.lowering.series.planar",
    } <= set(road())  # fmt: skip
    assert not [module for module in road() if module.startswith(("phichain.native", "phichain.system"))]


def test_no_module_of_the_road_uses_floating_point_of_numpy_or_libm() -> None:
    assert {module: found for module in road() if (found := faults(module, tree_of(module)))} == {}


def test_what_is_allowed_is_needed_and_stays_unused() -> None:
    assert set(ALLOWED) <= set(road())
    users = {m: name for m in road() if m not in ALLOWED for _, name in imported(tree_of(m)) if name in ALLOWED}
    assert users == {
        "phichain.ir": "phichain.ir.evaluate", "phichain.archive": "phichain.archive.schema", "phichain.laws": "phichain.laws.trajectory", "phichain.lowering.climb": "phichain.laws.family",
    }  # fmt: skip
    evaluators = {"evaluate", "evaluate_exactly"}
    assert not [m for m in road() for name, source in imported(tree_of(m)) if name in evaluators and source == "phichain.ir"]


@pytest.mark.parametrize(
    "line",
    [
        "import numpy as np", "from numpy.linalg import eigvalsh", "import scipy.linalg", "from math import sin, pi",
        "import math\nx = math.exp(1.0)", "y = a @ b", "y = x ** 2", "y = 10.0 ** k", "y = pow(x, 3)", "x **= 2", "import cmath",
    ],
)  # fmt: skip
def test_each_of_these_would_be_found(line: str) -> None:
    assert faults("phichain.emit.folder", ast.parse(line))


def test_a_power_of_a_float_is_found_even_where_powers_are_allowed() -> None:
    assert faults("phichain.lowering.rates", ast.parse("y = x ** 0.5")) == ["1: x ** 0.5"]
