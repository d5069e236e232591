"""Laws of measurements as compiled C with a memory and as CasADi: their own tests, mutants, coarse encoders, silent sensors."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from phichain import generate_controller
from phichain.emit.law import law_files
from tests.control.closed_loop import after
from tests.control.output.made_laws import CHAINS, PERIOD, law_of
from tests.one_program import STRICT


def result_of(folder: Path) -> int:
    """The result of the folder's self-test."""
    sources = [str(path) for path in folder.glob("*.c")]
    command = ["cc", *STRICT[:-2], "-O0", *sources, "-lm", "-o", str(folder / "t")]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(folder / "t")], check=False).returncode


@pytest.mark.parametrize(
    ("chain", "kind", "integrals", "real"),
    [("plane", "kalman", True, "double"), ("space", "reduced", False, "float"), ("plane", None, True, "float")],
)
def test_the_folder_passes_its_own_test(chain: str, kind: str | None, integrals: bool, real: str, tmp_path: Path) -> None:
    law = law_of(chain, kind, integrals, limit=20)
    folder = generate_controller(law, tmp_path, real)
    assert result_of(folder) == 0
    record = json.loads((folder / "manifest.json").read_text())
    assert record["state_bytes"] == (8 if real == "double" else 4) * sum(law.memory.values())
    assert (record["observer"] is None) == (kind is None) and len(record["integrated"]) == (1 if integrals else 0)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("state->expected[1] = theta_1_next;", "state->expected[1] = 2.0F * theta_1_next;"),
        ("state->integral[0]\n        + (", "state->integral[0]\n        - ("),
        ("< 0.0F ? 0.0F :", "> 0.0F ? 0.0F :"),
        ("u_0_held", "u_0_wanted"),
        ("- 3.1415927F", "- 3.1415F"),
        ("state->expected[3] = 0.0F;", "state->expected[3] = 0.5F;"),
    ],
)
def test_mutants_of_the_c_fail_it(right: str, wrong: str, tmp_path: Path) -> None:
    for name, text in mutated().items():
        (tmp_path / name).write_text(text)
    source = tmp_path / "handmade_controller.c"
    text = source.read_text()
    assert right in text
    head, *rest = text.split(right)
    # The last place: of a name that is defined and used, a use.
    source.write_text(right.join([head, *rest[:-1]]) + wrong + rest[-1])
    assert result_of(tmp_path) > 0


@cache
def mutated() -> dict[str, str]:
    """The law of which the test above takes mutants."""
    return law_files(law_of("plane", "kalman", True, limit=20), "float")


@pytest.fixture(scope="module")
def in_c(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """A float law with observer and integral as a shared object."""
    folder = generate_controller(law_of("plane", "kalman", True, limit=20), tmp_path_factory.mktemp("c"), "float")
    library = folder / "law.so"
    source = str(folder / "handmade_controller.c")
    done = subprocess.run(["cc", *STRICT, source, "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


class InC:
    """The law in C with its memory, for one run."""

    def __init__(self, library: ctypes.CDLL, ny: int, kept: int, nu: int) -> None:
        self.library, self.state = library, (ctypes.c_float * kept)()
        self.y, self.u = (ctypes.c_float * ny)(), (ctypes.c_float * nu)()

    def reset(self, y: np.ndarray) -> None:
        self.y[:] = y
        self.library.handmade_controller_reset(self.state, self.y)

    def __call__(self, y: np.ndarray) -> np.ndarray:
        self.y[:] = y
        self.library.handmade_controller(self.state, self.y, self.u)
        return np.array(self.u)


def test_the_float_c_holds_the_chain_from_coarse_encoders(in_c: ctypes.CDLL) -> None:
    """A thousand counts a turn, half a millimetre, every two milliseconds: upright from 0.05 rad, as the record in double does."""
    law = law_of("plane", "kalman", True, limit=20)
    steps = np.array([5e-4, 2 * np.pi / 1000, 2 * np.pi / 1000])

    def seen(x: np.ndarray) -> np.ndarray:
        return np.round(x[:3] / steps) * steps

    start = np.array([0.0, np.pi + 0.05, -0.02, 0, 0, 0])
    emitted = InC(in_c, 3, sum(law.memory.values()), 1)
    emitted.reset(seen(start))
    ends = []
    for call in (lambda t, x: emitted(seen(x)), law.running(lambda y: np.round(y / steps) * steps)):
        x = start
        for k in range(1500):
            x = after(CHAINS["plane"], x, call(k * PERIOD, x), PERIOD)
        ends.append(x)
    assert np.max(np.abs(np.array(ends)[:, :3] - [0.125, np.pi, 0])) < 0.12
    assert np.allclose(*np.array(ends)[:, :3], atol=0.02)


def test_a_silent_sensor_leaves_the_estimate_to_its_model(in_c: ctypes.CDLL) -> None:
    law = law_of("plane", "kalman", True, limit=20)
    emitted, y = InC(in_c, 3, sum(law.memory.values()), 1), np.array(law.offsets) + [0.01, 0.02, -0.01]
    emitted.reset(y)
    memory = law.reset(y)
    for silent in ([np.nan, y[1], y[2]], [np.inf, np.nan, -np.inf], y):
        u, memory = law.step(memory, np.array(silent))
        assert np.all(np.isfinite(u)) and emitted(np.array(silent)) == pytest.approx(u, rel=2e-4)
    assert np.all(np.isfinite(list(emitted.state)))


@pytest.mark.parametrize(("chain", "kind", "integrals"), [("plane", "kalman", True), ("space", "reduced", True)])
def test_casadi_has_the_same_law(chain: str, kind: str, integrals: bool, tmp_path: Path) -> None:
    law = law_of(chain, kind, integrals, limit=20)
    folder = generate_controller(law, tmp_path)
    spec = importlib.util.spec_from_file_location(folder.name, folder / f"{folder.name}_casadi.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    function, start = (getattr(module, name)() for name in (folder.name, f"{folder.name}_reset"))
    draw = np.random.default_rng(1)
    for _ in range(5):
        y = np.array(law.offsets) + draw.normal(size=len(law.offsets))
        memory = {name: draw.normal(size=size) for name, size in law.memory.items()}
        u, following = law.step(memory, y)
        *kept, inputs = (np.array(part).ravel() for part in function(*memory.values(), y))
        assert inputs == pytest.approx(u, rel=1e-9)
        for name, part in zip(memory, kept, strict=True):
            assert part == pytest.approx(following[name], rel=1e-9, abs=1e-9)
        assert np.array(start(y)[0]).ravel() == pytest.approx(law.reset(y)["expected"], rel=1e-12, abs=1e-14)
