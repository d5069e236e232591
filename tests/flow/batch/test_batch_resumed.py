"""Batch flows over whole turns, runs in pieces against the whole, and single precision against double."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.scene import Scene
from tests.flow.batch.batches import flow, states
from tests.flow.flows import compiled, planar, scene
from tests.flow.test_extremes import PENDULUM, G, time_between


def test_whole_turns_are_summed_with_compensation() -> None:
    """Against elliptic functions: 3e4 rad later, the time at which each is where it is."""
    n = 2
    rates = np.linspace(1e4, 1.2e4, n)
    found = flow(PENDULUM)(np.full((n, 1), 0.4), rates[:, None], 0.0, 3.0, 1e-16)
    assert np.min(found.q) > 2.9e4
    for k in range(n):
        with mpmath.workdps(40):
            q = mpmath.mpf(found.q[k, 0]) + mpmath.mpf(found.lost[k, 1])
            late = float(time_between(0.4, float(rates[k]), q) - 3)
            exact = mpmath.sqrt(
                mpmath.mpf(rates[k]) ** 2 + 2 * G * (mpmath.cos(q) - mpmath.cos(mpmath.mpf(0.4)))
            )
            assert abs(found.v[k, 0] / exact - 1) < 1e-15
        assert abs(late) < 2e-15


@pytest.mark.parametrize("turns", [1, -3, 159155])
def test_whole_turns_change_nothing_but_the_angle(turns: int) -> None:
    with mpmath.workdps(40):
        far = float(0.4 + 2 * mpmath.pi * turns)
        near = float(mpmath.mpf(far) - 2 * mpmath.pi * turns)
    found = flow(PENDULUM)([[far], [near], [far]], [[0.3], [0.3], [0.3]], 0.0, 20.0, 1e-16)
    assert abs(found.v[0, 0] - found.v[1, 0]) < 5e-14 and found.v[0, 0] == found.v[2, 0]
    with mpmath.workdps(40):
        apart = abs(mpmath.mpf(found.q[0, 0]) - 2 * mpmath.pi * turns - mpmath.mpf(found.q[1, 0]))
    assert apart < 0.51 * float(np.spacing(abs(far))) + 5e-14


WOUND = planar(2)
SPHERES = scene("spheres", "spatial", "cart", links=2, mass=0.3, length=0.4, cart_mass=1)


def begun(chain: Scene, n: int) -> tuple[NDArray[Any], NDArray[Any]]:
    q, v, *_ = states(chain, n)
    if chain.is_planar:
        q += 1000.0 * np.arange(n)[:, None]
        v += 40.0
    return q, v


@pytest.mark.parametrize("chain", [WOUND, SPHERES], ids=["wound", "spheres"])
def test_a_batch_in_pieces_is_the_batch(chain: Scene) -> None:
    """Handing a state out and taking it in again rounds it: what that takes is in `lost`, and what stays is round-off."""
    go, (q, v) = flow(chain), begun(chain, 9)
    whole = go(q, v, 0.0, 1.0, 1e-13)
    t = np.zeros(9)
    more: dict[str, Any] = {}
    while not np.all(t == 1.0):
        part = go(q, v, t, 1.0, 1e-13, max_steps=5, **more)
        q, v, t, more = part.q, part.v, part.t, {"lost": part.lost}
    room = 4e-16 * (1 + np.abs(whole.q)) + 3e-13
    assert np.all(np.abs(q - whole.q) <= room) and np.max(np.abs(v - whole.v)) < 1e-10
    if not chain.is_planar:
        assert np.max(np.abs(np.linalg.norm(q[:, 2:].reshape(9, -1, 3), axis=2) - 1)) < 3e-16


@pytest.mark.parametrize("chain", [WOUND, SPHERES], ids=["wound", "spheres"])
def test_one_in_pieces_is_the_one(chain: Scene) -> None:
    go, (q, v) = compiled(chain), (x[3] for x in begun(chain, 4))
    whole = go(q, v, 0.0, 1.0, 1e-13)
    t, lost = 0.0, None
    while t < 1.0:
        part = go(q, v, t, 1.0, 1e-13, max_steps=5, lost=lost)
        q, v, t, lost = part.q, part.v, part.t, part.lost
    assert np.all(np.abs(q - whole.q) <= 4e-16 * (1 + np.abs(whole.q)) + 3e-13)
    assert np.max(np.abs(v - whole.v)) < 1e-10


# --- single precision --------------------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("links", [1, 4, 16])
def test_float_refuses_nothing_and_keeps_the_tolerance(links: int) -> None:
    """Random states, against the double flow. Beside the tolerance stands what rounding the start to float does to its end."""
    n, random = 24, np.random.default_rng(links)
    q, v = random.uniform(-np.pi, np.pi, (n, links)), random.normal(size=(n, links))
    single, double = flow(planar(links, f"single{links}", target={"real": "float"})), flow(planar(links))
    given = [x.astype(np.float32) for x in (q, v)]
    exact = double(*(x.astype(float) for x in given), 0.0, 0.1, 1e-13)
    near = double(
        *(x * (1 + 2.0**-24 * random.uniform(-1, 1, x.shape)) for x in map(np.float64, given)),
        0.0,
        0.1,
        1e-13,
    )
    moved = np.maximum(np.max(np.abs(near.q - exact.q), axis=1), 1e-7)
    for tol in (1e-3, 1e-4, 1e-5, 1e-6):
        found = single(*given, 0.0, 0.1, tol)
        assert set(found.outcome) == {"done"}
        assert np.all(np.max(np.abs(found.q - exact.q), axis=1) < tol + 16 * moved)
