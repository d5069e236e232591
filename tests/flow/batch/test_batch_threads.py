"""Batches on several threads: no bit depends on how many; what cannot be is said before anything is computed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.native.flows import forward_dynamics_batch
from phichain.native.glue.interrupts import Interruptible
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.system import System

WANT = ("forward_dynamics", "propagate", "propagate_batch", "forward_dynamics_batch")


@pytest.fixture(scope="module")
def system() -> System:
    return build(Scene("owned", 2, mass=1.0, length=1.0, want=WANT))


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The symbols of C that are called."""
    found: list[str] = []
    plain = Interruptible.__call__

    def counted(self: Interruptible, *arguments: Any) -> Any:
        found.append(self._plain.__name__)
        return plain(self, *arguments)

    monkeypatch.setattr(Interruptible, "__call__", counted)
    return found


@pytest.mark.parametrize("workers", [2, 3, 16])
def test_no_bit_depends_on_the_number_of_threads(system: System, workers: int) -> None:
    q, v = np.random.default_rng(5).normal(size=(2, 777, 2))
    given = (q, v, 0.0, np.linspace(-1.0, 1.0, 777), 1e-10)
    one, many = (system.propagate_batch(*given, workers=count, max_steps=40) for count in (1, workers))
    for name in ("outcome", "t", "q", "v", "q_at", "tol", "order", "steps", "written", "lost"):
        assert np.array_equal(getattr(one, name), getattr(many, name)), name
    timed = [system.propagate_batch(q, v, 0.0, 0.5, 1e-10, times=[0.1, 0.3], workers=count) for count in (1, workers)]
    assert timed[0].q_at.tobytes() == timed[1].q_at.tobytes() and timed[0].v_at.tobytes() == timed[1].v_at.tobytes()


def test_small_batches_stay_on_one_thread_and_large_ones_do_not(system: System, calls: list[str]) -> None:
    q, v = np.zeros((2, 1000, 2))
    for n, expected in ((1, 1), (63, 1), (64, 2), (1000, 8)):
        del calls[:]
        system.propagate_batch(q[:n], v[:n], 0.0, 0.01, 1e-6, workers=2)
        assert calls == ["owned_propagate_batch"] * expected


@pytest.mark.parametrize("workers", [0, -1, 1.5])
def test_workers_that_are_none_are_refused(system: System, workers: Any) -> None:
    with pytest.raises(ArrayError, match=r"^workers: must be at least 1 .*leave it out to use every core"):
        system.propagate_batch(np.zeros((3, 2)), np.zeros((3, 2)), 0.0, 1.0, 1e-9, workers=workers)


def test_the_environment_says_how_many(system: System, calls: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    q = np.zeros((256, 2))
    for given, expected in (("1", 1), ("2", 8)):
        del calls[:]
        monkeypatch.setenv("PHICHAIN_WORKERS", given)
        system.propagate_batch(q, q, 0.0, 0.01, 1e-6)
        assert len(calls) == expected
    monkeypatch.setenv("PHICHAIN_WORKERS", "many")
    with pytest.raises(ArrayError, match=r"^PHICHAIN_WORKERS: must be at least 1 \(got 'many'\)"):
        system.propagate_batch(q, q, 0.0, 0.01, 1e-6)


def test_what_no_memory_holds_and_what_is_nothing_is_refused_before_it_is_computed(system: System, calls: list[str]) -> None:
    endless, none = np.broadcast_to(np.zeros(2), (10**11, 2)), np.zeros((0, 2))
    with pytest.raises(ArrayError, match=r"^propagate_batch\.q: asks for .* GiB at once, and this machine has .*; give it in pieces"):
        system.propagate_batch(endless, endless, 0.0, 1.0, 1e-9)
    with pytest.raises(ArrayError, match=r"^propagate_batch\.q: asks for .* GiB"):
        system.propagate_batch(np.zeros((9, 2)), np.zeros((9, 2)), 0.0, 1.0, 1e-9, times=np.broadcast_to(0.5, 10**10))
    with pytest.raises(ArrayError, match=r"^propagate\.times: asks for .* GiB"):
        system.propagate(np.zeros(2), np.zeros(2), 0.0, 1.0, 1e-9, times=np.broadcast_to(0.5, 10**10))
    with pytest.raises(ArrayError, match=r"^forward_dynamics: asks for .* GiB"):
        system.forward_dynamics(endless, endless)
    with pytest.raises(ArrayError, match=r"^propagate_batch\.q: has no row per trajectory"):
        system.propagate_batch(none, none, 0.0, 1.0, 1e-9)
    assert not calls


@pytest.mark.parametrize("workers", [2, 5])
def test_accelerations_do_not_depend_on_threads(system: System, workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forward_dynamics_batch, "_LEAST", 64)
    q, v = np.random.default_rng(6).normal(size=(2, 1001, 2))
    one, many = (system.forward_dynamics_batch(q, v, workers=count) for count in (1, workers))
    assert one.tobytes() == many.tobytes()
    with pytest.raises(ArrayError, match=r"^forward_dynamics_batch\.q: has no row"):
        system.forward_dynamics_batch(q[:0], v[:0])
