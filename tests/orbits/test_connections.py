"""Connections between upright equilibria: the separatrix of one link in closed form, two links against another integrator and equations."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phichain.errors import ArrayError, ControlError, OutputError, UnsupportedError
from phichain.orbits.connections import Connection, connections
from phichain.orbits.connections.connect import NEEDED
from phichain.pipeline import build
from phichain.scene import scene_from_dict
from phichain.system import System
from tests import tables

G = 9.81


@cache
def chain(links: int, base: str = "fixed", angles: str = "relative", **more: Any) -> System:
    numbers = {"links": links, "mass": 0.1, "length": 0.2, "base": base} | ({"cart_mass": 0.5} if base == "cart" else {})
    joints = {"angles": angles, "actuated": "none", **{name: more.pop(name) for name in ("stiffness", "damping") if name in more}}
    tables = {"name": f"connected_{links}", "chain": numbers | more, "joints": joints}
    return build(scene_from_dict(tables | {"functions": {"want": list(NEEDED)}, "flow": {"variational": True}}))


@cache
def pair(base: str = "fixed") -> tuple[Connection, ...]:
    return connections(chain(2, base, "absolute"), (1, 1))


def test_one_link_is_on_its_separatrix() -> None:
    """phi = 4 atan(e^(w t)) - pi, w = sqrt(g / l)."""
    (found,) = connections(chain(1))
    right = 4 * np.arctan(np.exp(np.sqrt(G / 0.2) * found.t)) - np.pi
    assert np.max(np.abs(found.q[:, 0] - right)) < 1e-12 and found.residual < 1e-14
    assert found.error < 1e-10 and found.energy < 1e-14 and np.isnan(found.transversality)
    assert found.turns == (1,) and found.s == (-1,) and found.rates == pytest.approx([np.sqrt(G / 0.2)], rel=1e-14)


@pytest.mark.long
def test_one_link_on_a_cart_has_the_energy_s_rate_half_way() -> None:
    """Hanging half way, with no momentum: m l^2 (1 - m / (m_0 + m)) phi'^2 / 2 = 2 m g l."""
    (found,) = connections(chain(1, "cart"))
    middle = len(found.t) // 2
    rate = np.sqrt(4 * G / 0.2 / (1 - 0.1 / 0.6))
    assert found.t[middle] == 0 and abs(found.v[middle, 1] - rate) < 1e-11 * rate
    assert abs(0.6 * found.v[middle, 0] + 0.1 * 0.2 * rate) < 1e-13


def dense(t: float, x: np.ndarray) -> np.ndarray:
    """Two point masses 0.1 kg at 0.2 m each: M phi'' = -C - G in absolute angles, section 1.2 of the design."""
    (a, b), (u, w) = x[:2], x[2:]
    m = 0.1 * 0.2**2
    inertia = m * np.array([[2, np.cos(a - b)], [np.cos(a - b), 1]])
    force = -m * np.sin(a - b) * np.array([w**2, -(u**2)]) - 0.1 * G * 0.2 * np.array([2 * np.sin(a), np.sin(b)])
    return np.concatenate([x[2:], np.linalg.solve(inertia, force)])


@pytest.mark.long
def test_two_links_arrive_by_other_equations_as_well() -> None:
    """From half way the dense equations lead close to upright: to about (3e-14)^(l_2 / (l_1 + l_2)), where their own errors have grown."""
    found = pair()
    assert len(found) >= 5 and all(a.t[-1] < b.t[-1] for a, b in pairwise(found))
    for connection in found:
        assert connection.residual < 1e-10 and connection.error < 1e-9 and connection.energy < 1e-13
        middle = len(connection.t) // 2
        assert np.max(np.abs(connection.q[middle])) < 1e-13
        start = np.concatenate([connection.q[middle], connection.v[middle]])
        run = solve_ivp(dense, (0.0, connection.t[-1]), start, "DOP853", rtol=3e-14, atol=1e-16)
        off = np.abs(run.y - np.array([np.pi, np.pi, 0.0, 0.0])[:, None])
        assert np.min(np.max(off / np.array([1, 1, *connection.rates])[:, None], axis=0)) < 1e-2
        # The first half is the second, reflected and backwards.
        assert np.max(np.abs(connection.q + connection.q[::-1])) < 1e-13


@pytest.mark.long
def test_manifolds_cross_where_a_connection_is_isolated() -> None:
    """Across the motion the manifolds' angle says by how much half way is missed beside it: finite, and no two connections are one."""
    for base in ("fixed", "cart"):
        angles = [connection.transversality for connection in pair(base)]
        assert min(angles) > 0.02 and max(angles) <= np.pi / 2 + 1e-12
        middles = np.array([connection.v[len(connection.t) // 2] for connection in pair(base)])
        gaps = np.linalg.norm(middles[:, None] - middles[None], axis=2) + 9 * np.eye(len(middles))
        assert gaps.min() > 0.01


@pytest.mark.parametrize("turns", [(1, 0), (0, 1)])
def test_one_link_alone_goes_round(turns: tuple[int, int]) -> None:
    (found, *_) = connections(chain(2, angles="absolute"), turns)
    assert np.max(np.abs(found.q[-1] - found.q[0] - 2 * np.pi * np.array(turns))) < 1e-4
    assert found.residual < 1e-10 and f"link {turns.index(1) + 1} +1 turn" in str(found)


def test_a_file_holds_all_of_it(tmp_path: Path) -> None:
    found = pair()[0]
    again = Connection.from_npz(found.to_npz(tmp_path / "c.npz"))
    assert again.turns == found.turns and np.array_equal(again.q, found.q) and again.error == found.error
    table = tables.table(found.to_csv(tmp_path / "c.csv"))
    assert np.array_equal(table["t"], found.t)
    (tmp_path / "x.npz").write_bytes(b"no")
    with pytest.raises(OutputError):
        Connection.from_npz(tmp_path / "x.npz")


@pytest.mark.long
def test_what_has_no_connections_is_said() -> None:
    with pytest.raises(ControlError, match=r"has 1 unstable direction\(s\) and 2 links"):
        connections(chain(2, angles="absolute"), s=[1, -1])
    with pytest.raises(ArrayError, match="does not say how far every link turns"):
        connections(chain(2, angles="absolute"), (0, 0))
    with pytest.raises(UnsupportedError, match="loses energy"):
        connections(chain(2, damping=0.1))
    with pytest.raises(UnsupportedError, match="searched for one and two links"):
        connections(chain(3))
    assert connections(chain(2, angles="absolute"), (1, 1), longest=0.5) == ()
