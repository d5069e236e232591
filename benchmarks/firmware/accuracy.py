"""Errors in single precision: the very C that targets run, built for the host, on the probe's states."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

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


def worst_error(folder: Path, links: int) -> float:
    """Largest error of the forward dynamics over the states, max norm over max norm."""
    name = next(folder.glob("*.h")).stem
    words = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", f"{name}.c", "-o", "host.so", "-lm"]
    subprocess.run(words, cwd=folder, check=True)
    function = ctypes.CDLL(str(folder / "host.so"))[f"{name}_forward_dynamics"]
    worst, a = 0.0, np.empty(links, np.float32)
    for row in zip(*states(links), strict=True):
        arrays = [np.ascontiguousarray(part) for part in row]
        function(*(ctypes.c_void_p(array.ctypes.data) for array in (*arrays, a)))
        right = exact(*arrays)
        worst = max(worst, float(np.max(np.abs(a - right)) / np.max(np.abs(right))))
    return worst
