"""Ctrl-C leaves long C at once, changes nothing else, and nothing where it means something else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from phichain.contract.functions import ROWS
from phichain.emit import library_files
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native.flows.prepare import prepared_signature
from phichain.native.glue.source import glue_source
from phichain.native.signature import manifest_of
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

CHECKOUT = Path(__file__).parents[3]
WANT = ("forward_dynamics", "state_jacobian", "propagate", "propagate_batch", "propagate_stiff", "forward_dynamics_batch")
SCENE = Scene("endless", 2, mass=1.0, length=1.0, want=WANT)

RUNS = {
    "simulate": "simulate(s, ([1.0, 2.0], [0.0, 0.0]), [0, 1e12, 1e13], max_steps=10**15)",
    "simulate at its own steps": "simulate(s, ([1.0, 2.0], [0.0, 0.0]), [0, 1e13], max_steps=10**15)",
    "propagate": "s.propagate([1.0, 2.0], [0.0, 0.0], 0.0, 1e13, 1e-12, max_steps=10**15)",
    "propagate_stiff": "s.propagate_stiff([1.0, 2.0], [0.0, 0.0], 0.0, 1e13, 1e-8, max_steps=10**15)",
    "propagate_batch": "s.propagate_batch([[1.0, 2.0]] * 5, [[0.0, 0.0]] * 5, 0.0, 1e13, 1e-12, max_steps=10**15)",
}

SCRIPT = """
import os, signal, sys, threading
from phichain import Scene, build, simulate
from tests.native.hostile.test_interrupts import SCENE
s = build(SCENE)
right = s.propagate([1.0, 2.0], [0.0, 0.0], 0.0, 5.0, 1e-12).q.tobytes()
before = signal.getsignal(signal.SIGINT)
threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    RUN
except KeyboardInterrupt:
    assert signal.getsignal(signal.SIGINT) is before
    assert s.propagate([1.0, 2.0], [0.0, 0.0], 0.0, 5.0, 1e-12).q.tobytes() == right
    print("interrupted")
"""


@pytest.mark.long
@pytest.mark.parametrize("run", RUNS)
def test_runs_that_would_last_for_years_end(run: str) -> None:
    """In a process that is ended if it does not end itself: without the twins each of these runs for years."""
    paths = os.pathsep.join([str(CHECKOUT / "codegen"), str(CHECKOUT)])
    script = SCRIPT.replace("RUN", RUNS[run])
    done = subprocess.run([sys.executable, "-c", script], check=False, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, timeout=100, text=True)
    assert (done.stdout, done.returncode) == ("interrupted\n", 0), done.stderr


@pytest.fixture(scope="module")
def system() -> System:
    return build(SCENE)


def all_bits(system: System) -> bytes:
    """Every bit that flows and row loops give."""
    state = ([1.0, 7.0], [0.3, -9.0])
    rows = np.linspace(-9.0, 9.0, 4000).reshape(-1, 2)
    one = system.propagate(*state, 0.0, 5.0, 1e-12, times=np.linspace(0.0, 5.0, 50))
    stiff = system.propagate_stiff(*state, 0.0, 1.0, 1e-8)
    many = system.propagate_batch([state[0]] * 3, [state[1]] * 3, 0.0, 5.0, 1e-12)
    arrays = (one.q, one.q_at, one.v_at, one.lost, stiff.q, stiff.v, many.q, many.v, many.lost, *system.state_jacobian(rows, rows))
    return b"".join(array.tobytes() for array in (*arrays, system.forward_dynamics_batch(rows, rows)))


def test_a_twin_gives_the_bits_of_its_function(system: System) -> None:
    """Another thread calls the functions themselves."""
    found: list[bytes] = []
    thread = threading.Thread(target=lambda: found.append(all_bits(system)))
    thread.start()
    thread.join()
    assert found == [all_bits(system)]


def test_a_handler_of_the_caller_s_is_left_alone(system: System) -> None:
    """Who handles SIGINT himself gets the whole result, his handler called once."""
    caught: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: caught.append(number))
    try:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
        found = system.propagate([1.0, 2.0], [0.0, 0.0], 0.0, 1e9, 1e-12, max_steps=30_000)
        assert found.steps == 30_000
        for _ in range(1000):
            if caught:
                break
            signal.sigtimedwait([], 0.01)
        assert caught == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


def test_threads_run_on_while_the_main_thread_is_interrupted(system: System) -> None:
    steps: list[int] = []
    state = ([1.0, 2.0], [0.0, 0.0])
    worker = threading.Thread(target=lambda: steps.append(system.propagate(*state, 0.0, 1e9, 1e-12, max_steps=30_000).steps))
    worker.start()
    threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        system.propagate(*state, 0.0, 1e13, 1e-12, max_steps=10**15)
    worker.join()
    assert steps == [30_000]


def test_every_flow_of_the_contract_and_every_row_loop_has_a_twin() -> None:
    chain = Scene("endless", 2, mass="runtime", length=1.0, want=(*WANT, "prepare"))
    files = library_files(chain, lower(derive(chain)))
    manifest = manifest_of({name: text.encode() for name, text in files.items()})
    source = glue_source(manifest, chain, prepared_signature(chain, manifest.parameters))
    assert " endless_rows_forward_dynamics_prepared_until_interrupted(int *stopped, " in source
    for name in chain.want:
        symbol = f"endless_{name}" if ROWS[name].flow else f"endless_rows_{name}"
        assert f" {symbol}_until_interrupted(int *stopped, " in source
    assert "interrupted" not in files["endless.c"] + files["endless.h"]
    flows = {name for name, row in ROWS.items() if row.flow}
    assert flows <= set(chain.want)
