"""Controllers as folders of C: their self-tests and mutants of them, CasADi, the float law in closed loop, and the command."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import subprocess
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from phichain import build, generate_controller
from phichain.control import errors, lqr, regulators
from phichain.emit.law.controller import controller_files
from phichain.errors import ArrayError, EmissionError, OutputError, SceneError
from phichain.ir import evaluate
from phichain.laws import StateFeedback
from phichain.lowering.laws import controller
from phichain.scene import Scene
from tests.handmade import paper_b, planar, spatial
from tests.one_program import STRICT

CHAINS = {
    "cart": lambda: planar([0.3, 0.2], [0.4, 0.3], cart_mass=0.7, actuated="cart"),
    "all": lambda: planar([0.3, 0.2], [0.4, 0.3], cart_mass=0.7, actuated="all", angles="absolute"),
    "fixed": lambda: planar([0.3, 0.2], [0.4, 0.3], actuated="all"),
    "space": lambda: spatial([0.2, 0.1], [0.3, 0.4], cart_mass=0.5),
}
COMPILE = ("cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", "-Wconversion", "-Wdouble-promotion")


def law_of(kind: str, **more: object) -> StateFeedback:
    system = CHAINS[kind]()
    return lqr(system, sample=0.01).law([0.125] * system.cart_size, **more)  # type: ignore[arg-type]


def result_of(folder: Path) -> int:
    """The result of the folder's self-test."""
    sources = [str(path) for path in folder.glob("*.c")]
    made = subprocess.run([*COMPILE, *sources, "-lm", "-o", str(folder / "t")], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("kind", CHAINS)
def test_the_folder_passes_its_own_test(kind: str, real: str, tmp_path: Path) -> None:
    folder = generate_controller(law_of(kind, limit=20), tmp_path, real)
    name = law_of(kind).name
    assert folder.name == f"{name}_controller"
    assert result_of(folder) == 0
    source = (folder / f"{name}_controller.c").read_text()
    assert ("double" in source) is False and ("malloc" in source) is False
    record = json.loads((folder / "manifest.json").read_text())
    assert record["kind"] == "controller" and record["sample"] == 0.01 and record["real"] == real
    assert generate_controller(law_of(kind), tmp_path, real) == folder


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("+ 0.5F", "+ 0.4F"),
        ("- 3.1415927F", "- 3.1415F"),
        ("- 0.125F", "- 0.12F"),
        ("? 20.0F", "? 20.5F"),
        ("* x_meas[4]", "* x_meas[5]"),
        ("9.886865F", "9.886F"),
    ],
)
def test_mutants_of_the_law_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    folder = generate_controller(law_of("cart", limit=20), tmp_path, "float")
    source = folder / "handmade_controller.c"
    text = source.read_text()
    assert right in text
    source.write_text(text.replace(right, wrong, 1))
    assert result_of(folder) > 0


@pytest.mark.parametrize("kind", CHAINS)
def test_casadi_has_the_same_law(kind: str, tmp_path: Path) -> None:
    law = law_of(kind, limit=20)
    folder = generate_controller(law, tmp_path)
    name = folder.name
    spec = importlib.util.spec_from_file_location(name, folder / f"{name}_casadi.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    function, program, draw = getattr(module, name)(), controller(law), np.random.default_rng(1)
    for _ in range(20):
        x = np.array(law.target) + 3 * draw.normal(size=len(law.target))
        expected = evaluate(program, {"x_meas": x.tolist()})["u"]
        assert np.array(function(x)).ravel() == pytest.approx(expected, rel=1e-12, abs=1e-12)


def float_law(law: StateFeedback, folder: Path) -> ctypes._FuncPointer:  # type: ignore[name-defined]
    """The law's C in single precision, compiled."""
    for name, text in controller_files(law, "float").items():
        (folder / name).write_text(text)
    name = f"{law.name}_controller"
    library = folder / f"{name}_{abs(hash(law))}.so"
    done = subprocess.run(["cc", *STRICT, str(folder / f"{name}.c"), "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    function = ctypes.CDLL(str(library))[name]
    function.restype = None
    return function


@pytest.mark.long
def test_every_equilibrium_of_paper_b_is_held_at_1_khz_by_the_float_law(tmp_path: Path) -> None:
    """All 32: the nonlinear chain by its own flow from sample to sample, its state rounded to single precision, the input held."""
    reference, seconds, period = paper_b(), 0.4, 1e-3
    scene = Scene("paper_b", 5, "spatial", "cart", mass=0.1, length=0.1, cart_mass=0.5, want=("linearization", "forward_dynamics", "propagate"))
    system = build(scene)
    gains = regulators(reference, product((1, -1), repeat=5), sample=period)
    for one in gains:
        law, folder = float_law(one.law(), tmp_path), tmp_path
        assert folder.exists()
        q, v = np.array(one.equilibrium), np.zeros(system.nv)
        q[:2] = (1e-4, -1e-4)
        start = np.concatenate([q, v])
        measured, push = (ctypes.c_float * system.nx)(), (ctypes.c_float * 2)()
        for _ in range(round(seconds / period)):
            measured[:] = np.concatenate([q, v])
            law(measured, push)
            flown = system.propagate(q, v, 0.0, period, 1e-9, u=np.array(push, dtype=float))
            q, v = flown.q, flown.v
        off, _ = errors(system, one, np.stack([start, np.concatenate([q, v])]))
        # Left alone, the slowest of what falls grows a thousandfold in this time.
        assert np.hypot(*q[:2]) < 2 * np.hypot(1e-4, 1e-4), one.s
        assert off[1] < 2e-3, one.s


def test_what_no_law_can_be_made_of_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="is not one of the choices"):
        generate_controller(law_of("cart"), tmp_path, "half")
    with pytest.raises(ArrayError, match="limit: is not positive"):
        law_of("cart", limit=-1)
    (tmp_path / "handmade_controller").mkdir()
    (tmp_path / "handmade_controller" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError):
        generate_controller(law_of("cart"), tmp_path)
    assert [path.name for path in (tmp_path / "handmade_controller").iterdir()] == ["mine.txt"]


def test_a_gain_that_no_float_holds_is_refused(tmp_path: Path) -> None:
    law = law_of("cart")
    large = StateFeedback(**{**vars(law), "gains": ((1e300, *law.gains[0][1:]),)})
    with pytest.raises(EmissionError):
        generate_controller(large, tmp_path, "float")
    assert not list(tmp_path.iterdir())
