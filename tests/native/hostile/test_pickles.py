"""What phichain hands out crosses process boundaries: pickles, copies, spawned and forked workers, threads."""

from __future__ import annotations

import copy
import dataclasses
import multiprocessing
import os
import pickle
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from phichain import build, derive, lower, lqr, simulate, trace
from phichain.errors import PhichainError, SceneError
from phichain.native import CompilerOptions, build_files
from phichain.scene import Scene
from phichain.system import System

WANT = ("forward_dynamics", "energy", "linearization", "state_jacobian", "phi", "phi_jacobian", "propagate", "mass_matrix")
SCENE = Scene("travelling", 2, mass="runtime", length=[0.5, 0.25], actuated="all", want=WANT)
P = {"mass": np.array([1.0, 0.5])}
STATE = ([1.0, -0.4], [0.3, 0.2])


@pytest.fixture(scope="module")
def system() -> System:
    return build(SCENE)


def bits(system: System) -> bytes:
    """What a system computes, to the last bit."""
    q, v = STATE
    one = system.propagate(q, v, 0.0, 3.0, 1e-12, p=P)
    arrays = [one.q, one.v, *system.energy(q, v, p=P), *system.state_jacobian(q, v, [0.1, 0.2], p=P)]
    return b"".join(np.asarray(array).tobytes() for array in (*arrays, system.forward_dynamics(q, v, [0.0, 0.0], p=P)))


def ends(system: System) -> bytes:
    return simulate(system, STATE, np.linspace(0.0, 1.0, 5), p=P).x.tobytes()


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_a_system_comes_back_to_the_last_bit(system: System, protocol: int) -> None:
    back = pickle.loads(pickle.dumps(system, protocol))
    assert (back.digest, back.scene, back.name, back.u_names, str(back)) == (system.digest, system.scene, system.name, system.u_names, str(system))
    assert bits(back) == bits(system)
    again = pickle.loads(pickle.dumps(back))
    assert bits(again) == bits(system)


def test_what_a_caller_changed_travels_along(system: System) -> None:
    from dataclasses import replace

    given = replace(system, params=P, functions={"forward_dynamics": system.forward_dynamics, "phi": np.sin})
    back = pickle.loads(pickle.dumps(given))
    np.testing.assert_array_equal(back.params["mass"], P["mass"])
    assert list(back.functions) == ["forward_dynamics", "phi"] and back.phi is np.sin
    again = back.forward_dynamics(*STATE, [0.0, 0.0], p=P)
    assert again.tobytes() == system.forward_dynamics(*STATE, [0.0, 0.0], p=P).tobytes()


def test_a_system_compiled_otherwise_is_compiled_so_again(tmp_path: Any) -> None:
    from phichain.emit import library_files

    scene = Scene("plainly", 1, mass=1.0, length=1.0)
    options = CompilerOptions(flags=tuple("-O0" if flag == "-O3" else flag for flag in CompilerOptions().flags))
    system = build_files(library_files(scene, lower(derive(scene))), options)
    assert pickle.loads(pickle.dumps(system)).forward_dynamics.made_by.origin.options == options


def test_copies_of_a_system_are_the_system(system: System) -> None:
    assert copy.copy(system) is system and copy.deepcopy({"s": [system]})["s"][0] is system


@pytest.mark.long
@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_workers_find_the_same(system: System, method: str) -> None:
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(bits, [system] * 4) == [bits(system)] * 4
        assert pool.map(ends, [system] * 2) == [ends(system)] * 2


def test_a_fork_in_the_midst_of_a_call_finds_the_same(system: System) -> None:
    """Another thread is inside C while this one forks."""
    going = threading.Event()

    def busy() -> None:
        while not going.is_set():
            bits(system)

    thread = threading.Thread(target=busy)
    thread.start()
    expected = bits(system)
    try:
        for _ in range(5):
            child = os.fork()
            if child == 0:
                os._exit(0 if bits(system) == expected else 1)
            assert os.waitpid(child, 0)[1] == 0
    finally:
        going.set()
        thread.join()


def test_threads_find_the_same(system: System) -> None:
    expected, found = bits(system), []
    threads = [threading.Thread(target=lambda: found.append(bits(system))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 8


def same(a: Any, b: Any) -> bool:
    """Equality of records by what they hold."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if dataclasses.is_dataclass(a) and not callable(a):
        return all(same(getattr(a, field.name), getattr(b, field.name)) for field in dataclasses.fields(a))
    if hasattr(a, "__dict__") and not callable(a):
        return same(tuple(vars(a).values()), tuple(vars(b).values()))
    return bool(a == b)


RECORDS: dict[str, Callable[[System], Any]] = {
    "Scene": lambda system: SCENE,
    "Trajectory on a grid": lambda system: simulate(system, STATE, [0.0, 0.1, 0.2], p=P),
    "Gains": lambda system: lqr(system, p=P),
    "Branch": lambda system: trace(system, 1, 0.5, p=P),
}


@pytest.mark.parametrize("name", RECORDS)
def test_records_come_back(system: System, name: str) -> None:
    record = RECORDS[name](system)
    for back in (pickle.loads(pickle.dumps(record)), copy.deepcopy(record), copy.copy(record)):
        assert type(back) is type(record) and same(back, record)


def test_a_trajectory_at_its_own_steps_comes_back_without_its_interpolant(system: System) -> None:
    motion = simulate(system, STATE, [0.0, 0.5], p=P)
    back = pickle.loads(pickle.dumps(motion))
    assert motion.refine is not None and back.refine is None
    assert back.x.tobytes() == motion.x.tobytes()
    np.testing.assert_allclose(back.resample(20).q, motion.resample(20).q, atol=1e-6)
    assert copy.deepcopy(motion).refine is motion.refine and copy.deepcopy(motion).q is not motion.q


def test_a_model_comes_back() -> None:
    model = derive(Scene("small", 1, mass=1.0, length=1.0))
    assert pickle.loads(pickle.dumps(model)) == model


def test_errors_come_back() -> None:
    with pytest.raises(SceneError) as caught:
        Scene("a b", 1, mass=1.0, length=1.0)
    back = pickle.loads(pickle.dumps(caught.value))
    assert isinstance(back, PhichainError) and str(back) == str(caught.value)
