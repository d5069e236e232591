"""An FMU is valid, and moves as `simulate` does: its derivatives are the functions', its steps the flow's."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from phichain import Scene, build, simulate
from phichain.errors import OutputError
from phichain.exchange import write_fmu
from phichain.scene.load import with_functions

RUNTIME = Scene("runt", 2, mass="runtime", length=1.0, gravity=9.81, actuated=[1], want=("forward_dynamics", "energy"))
BALL = Scene("ball", 1, "spatial", "cart", mass=1.0, length=0.5, cart_mass=2.0, damping=0.1, want=("forward_dynamics",))
RUBBED = Scene("rubbed", 1, mass=1.0, length=1.0, friction=0.1, friction_speed=0.1, want=("forward_dynamics",))
CASES = (
    (RUNTIME, {"theta_1": 1.0, "theta_2": 0.5, "mass[1]": 0.7, "torque_1": 0.3}, {"mass": np.array([0.7, 1.0])}, 1e-10),
    (
        BALL,
        {"q_1_1": 0.48, "q_1_2": 0.6, "q_1_3": 0.64, "omega_1_1": 0.9072, "omega_1_2": -0.096, "omega_1_3": -0.5904, "x_dot_1": 0.2, "force_2": 0.4},
        None, 1e-10,
    ),
    (RUBBED, {"theta_1": 0.8}, None, 1e-10),
)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmu")
    return {scene.name: write_fmu(scene, folder / f"{scene.name}.fmu") for scene, *_ in CASES}


def start(scene: Scene, given: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    from phichain.emit.fmu.variables import start as hanging

    q, v = np.array(hanging(scene)), np.zeros(scene.nv)
    for names, values in ((scene.q_names, q), (scene.v_names, v)):
        for k, name in enumerate(names):
            values[k] = given.get(name, values[k])
    return q, v, np.array([given.get(name, 0.0) for name in scene.u_names]) if scene.nu else None


@pytest.mark.long
@pytest.mark.parametrize(("scene", "given", "p", "most"), CASES, ids=lambda value: getattr(value, "name", ""))
def test_co_simulation_ends_where_simulate_does(written: dict[str, Path], scene: Scene, given: dict[str, float], p: Any, most: float) -> None:
    path = str(written[scene.name])
    assert validate_fmu(path) == []
    inputs = {name: value for name, value in given.items() if name in scene.u_names}
    signals = np.array([(0.0, *inputs.values())], dtype=[("time", float), *((name, float) for name in inputs)]) if inputs else None
    starts = {name: value for name, value in given.items() if name not in inputs}
    result = fmpy.simulate_fmu(path, stop_time=2.0, output_interval=0.25, fmi_type="CoSimulation", start_values=starts, input=signals, relative_tolerance=1e-12)
    q, v, u = start(scene, given)
    flow = "propagate" if scene.friction is None else "propagate_stiff"
    motion = simulate(build(with_functions(scene, (flow,))), (q, v), np.linspace(0, 2, 9), tol=1e-12, u=u, p=p)
    for name, column in zip((*scene.q_names, *scene.v_names), motion.x.T, strict=True):
        assert np.max(np.abs(result[name] - column)) < most, name
    if "energy" in scene.want:
        assert np.allclose(result["kinetic_energy"] + result["potential_energy"], motion.energy, rtol=0, atol=1e-10)


@pytest.mark.parametrize(("scene", "given", "p", "most"), CASES[:2], ids=lambda value: getattr(value, "name", ""))
def test_model_exchange_has_the_derivatives_of_the_functions(written: dict[str, Path], scene: Scene, given: dict[str, float], p: Any, most: float, tmp_path: Path) -> None:
    from fmpy.fmi3 import FMU3Model

    description = fmpy.read_model_description(str(written[scene.name]))
    refs = {variable.name: variable.valueReference for variable in description.modelVariables}
    model = FMU3Model(
        guid=description.guid, unzipDirectory=fmpy.extract(str(written[scene.name]), str(tmp_path)), instanceName="one",
        modelIdentifier=description.modelExchange.modelIdentifier,
    )  # fmt: skip
    model.instantiate()
    for name, value in given.items():
        if name not in scene.q_names and name not in scene.v_names:
            model.setFloat64([refs[name]], [value])
    q, v, u = start(scene, given)
    model.enterInitializationMode()
    model.exitInitializationMode()
    states = np.concatenate([q, v])
    array = (ctypes.c_double * len(states))(*states)
    model.setContinuousStates(array, len(states))
    back = (ctypes.c_double * len(states))()
    model.getContinuousStates(back, len(states))
    assert np.array_equal(back, states)
    model.getContinuousStateDerivatives(back, len(states))
    assert np.array_equal(model.getFloat64([refs[name] for name in (*scene.q_names, *scene.v_names)]), states)
    given_rates = np.array(model.getFloat64([refs[f"der({name})"] for name in (*scene.q_names, *scene.v_names)]))
    a = build(scene).forward_dynamics(q, v, *([] if u is None else [u]), **({"p": p} if p else {}))
    cart = 2 if scene.has_cart else 0
    q_dot = v if scene.is_planar else np.concatenate([v[:cart], np.cross(v[cart:].reshape(-1, 3), q[cart:].reshape(-1, 3)).ravel()])
    assert np.max(np.abs(given_rates - np.concatenate([q_dot, a]))) < 1e-13 and np.array_equal(given_rates, back)
    model.terminate()
    model.freeInstance()


def test_an_fmu_is_the_same_bytes_and_carries_strict_sources(written: dict[str, Path], tmp_path: Path) -> None:
    again = write_fmu(RUNTIME, tmp_path / "again.fmu")
    assert again.read_bytes() == written["runt"].read_bytes()
    for name, path in written.items():
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / name)
        compiler = shutil.which("cc") or shutil.which("gcc")
        assert compiler
        words = [compiler, "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O1", "-fsyntax-only", "fmu.c"]
        done = subprocess.run(words, cwd=tmp_path / name / "sources", capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_a_file_of_another_name_is_refused() -> None:
    with pytest.raises(OutputError, match=r"name it .fmu"):
        write_fmu(RUNTIME, "runt.zip")
