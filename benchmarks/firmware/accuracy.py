"""Errors in single precision: the very C that targets run, built for the host, on the probe's states."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.firmware.probe import STATES


def states(links: int) -> list[np.ndarray]:
    """q, v and u of the probe's states."""
    seed = 2463534242
    rows = []
    for _ in range(STATES):
        numbers = []
        for reach in [np.float32(3.125)] * links + [np.float32(4.0)] * links + [np.float32(2.0)] * links:
            seed = (seed ^ (seed << 13)) & 0xFFFFFFFF
            seed ^= seed >> 17
            seed = (seed ^ (seed << 5)) & 0xFFFFFFFF
            numbers.append(np.float32((seed >> 9) - 4194304) * (reach / np.float32(4194304)))
        rows.append(numbers)
    found = np.array(rows, np.float32)
    return [found[:, k * links : (k + 1) * links] for k in range(3)]


def exact(q: np.ndarray, v: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Paper A's chain by its closed form in extended precision; masses, lengths 1/N."""
    links = len(q)
    phi, omega = np.cumsum(q.astype(np.longdouble)), np.cumsum(v.astype(np.longdouble))
    one, index = np.longdouble(1) / links, np.arange(links)
    mu = one * one / 2 + one * one * (links - 1 - index)
    inertia = one * mu[np.maximum.outer(index, index)]
    np.fill_diagonal(inertia, one**3 / 4 + one**3 * (links - 1 - index))
    apart = np.subtract.outer(phi, phi)
    torque = u.astype(np.longdouble)
    right = torque - np.append(torque[1:], 0) - np.longdouble("9.81") * mu * np.sin(phi) - (inertia * np.sin(apart)) @ omega**2
    solved = _solved(inertia * np.cos(apart), right)
    return np.diff(solved, prepend=0)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Gauss, and one step of refinement."""
    def once(b: np.ndarray) -> np.ndarray:
        m, b = matrix.copy(), b.copy()
        for k in range(len(b)):
            for i in range(k + 1, len(b)):
                factor = m[i, k] / m[k, k]
                m[i] -= factor * m[k]
                b[i] -= factor * b[k]
        for k in range(len(b) - 1, -1, -1):
            b[k] = (b[k] - m[k, k + 1 :] @ b[k + 1 :]) / m[k, k]
        return b

    first = once(right)
    return first + once(right - matrix @ first)


def _forward_dynamics(folder: Path) -> Any:
    """The C, built for the host."""
    name = next(folder.glob("*.h")).stem
    words = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"{name}.c", "-o", "host.so", "-lm"]
    subprocess.run(words, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "host.so"))[f"{name}_forward_dynamics"]


def worst_error(folder: Path, links: int) -> float:
    """Largest error of the forward dynamics over the states, max norm over max norm."""
    function = _forward_dynamics(folder)
    worst, a = 0.0, np.empty(links, np.float32)
    for row in zip(*states(links), strict=True):
        arrays = [np.ascontiguousarray(part) for part in row]
        function(*(ctypes.c_void_p(array.ctypes.data) for array in (*arrays, a)))
        right = exact(*arrays)
        worst = max(worst, float(np.max(np.abs(a - right)) / np.max(np.abs(right))))
    return worst


#: The spatial chain on a cart whose worst error is stated: m = l = 1/N, masses at the ends.
SPATIAL_CART: Final = 0.5


def spatial_states(links: int) -> list[np.ndarray]:
    """q, v and u of a chain on a cart: directions and rates across them, rounded to single precision."""
    source = np.random.default_rng(13)
    q, v = source.standard_normal((2, STATES, links, 3))
    q /= np.linalg.norm(q, axis=2, keepdims=True)
    v *= 4.0 / np.linalg.norm(v, axis=2, keepdims=True)
    v -= q * np.sum(q * v, axis=2, keepdims=True)
    head, force = source.uniform(-1, 1, (2, STATES, 2)), source.uniform(-2, 2, (STATES, 2))
    rows = [np.hstack([cart, part.reshape(STATES, -1)]) for cart, part in zip(head, (q, v), strict=True)]
    return [np.ascontiguousarray(part, np.float32) for part in (*rows, force)]


def exact_spatial(q: np.ndarray, v: np.ndarray, u: np.ndarray, links: int) -> np.ndarray:
    """(16) of paper B, dense in extended precision, at the state of unit vectors nearest to each."""
    count, one = len(q), np.longdouble(1) / links
    here, omega = (part[:, 2:].astype(np.longdouble).reshape(count, links, 3) for part in (q, v))
    here = here / np.sqrt(np.sum(here**2, axis=2, keepdims=True))
    omega = omega - here * np.sum(here * omega, axis=2, keepdims=True)
    mu = one * one * (links - np.arange(links))
    hat, size = np.zeros((count, links, 3, 3), np.longdouble), 2 + 3 * links
    for (a, b), (axis, sign) in {(0, 1): (2, -1), (0, 2): (1, 1), (1, 0): (2, 1), (1, 2): (0, -1), (2, 0): (1, -1), (2, 1): (0, 1)}.items():
        hat[:, :, a, b] = sign * here[:, :, axis]
    matrix, right = np.zeros((count, size, size), np.longdouble), np.zeros((count, size), np.longdouble)
    matrix[:, 0, 0] = matrix[:, 1, 1] = np.longdouble(SPATIAL_CART) + 1
    right[:, :2] = u.astype(np.longdouble)
    squared = np.sum(omega**2, axis=2)
    for i in range(links):
        at = slice(2 + 3 * i, 5 + 3 * i)
        matrix[:, at, :2], matrix[:, :2, at] = mu[i] * hat[:, i, :, :2], -mu[i] * hat[:, i, :2, :]
        right[:, :2] += mu[i] * squared[:, i, None] * here[:, i, :2]
        right[:, at] = mu[i] * np.longdouble("9.81") * hat[:, i, :, 2]
        for j in range(links):
            inertia = one * mu[max(i, j)]
            if i == j:
                matrix[:, at, at] = inertia * np.eye(3)
                continue
            matrix[:, at, 2 + 3 * j : 5 + 3 * j] = -inertia * np.matmul(hat[:, i], hat[:, j])
            right[:, at] += inertia * squared[:, j, None] * np.cross(here[:, i], here[:, j])
    return _solved_all(matrix, right)


def _solved_all(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Gauss over all states at once; the matrices are positive definite."""
    matrix, right = matrix.copy(), right.copy()
    size = right.shape[1]
    for k in range(size):
        factor = matrix[:, k + 1 :, k] / matrix[:, k, k, None]
        matrix[:, k + 1 :] -= factor[:, :, None] * matrix[:, k, None]
        right[:, k + 1 :] -= factor * right[:, k, None]
    for k in range(size - 1, -1, -1):
        right[:, k] = (right[:, k] - np.sum(matrix[:, k, k + 1 :] * right[:, k + 1 :], axis=1)) / matrix[:, k, k]
    return right


def worst_spatial_error(folder: Path, links: int) -> float:
    """The same for the spatial chain on a cart."""
    function, parts = _forward_dynamics(folder), spatial_states(links)
    q, v, u = parts
    right, a = exact_spatial(q, v, u, links), np.empty((STATES, 2 + 3 * links), np.float32)
    for row, out in zip(zip(*parts, strict=True), a, strict=True):
        function(*(ctypes.c_void_p(array.ctypes.data) for array in (*row, out)))
    return float(np.max(np.max(np.abs(a - right), axis=1) / np.max(np.abs(right), axis=1)))
