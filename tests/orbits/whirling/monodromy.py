"""Multipliers of spatial orbits of two links by the whole map, without any of their symmetries."""

from __future__ import annotations

from typing import Any

import numpy as np

from phichain.orbits.whirling.fixed import turned
from phichain.system import System


def spectrum(system: System, x: np.ndarray, span: float, turn: float, p: dict[str, Any]) -> np.ndarray:
    """The four multipliers of two links that are not 1, of the whole motion, turned back."""
    q, spins, tangent = x[:6].reshape(2, 3), x[6:].reshape(2, 3), np.zeros((12, 8))
    for k, link in enumerate(q):
        basis = np.linalg.qr(link[:, None], mode="complete")[0][:, 1:]
        here, there = slice(3 * k, 3 * k + 3), slice(6 + 3 * k, 9 + 3 * k)
        tangent[here, 2 * k : 2 * k + 2] = tangent[there, 4 + 2 * k : 6 + 2 * k] = basis
        tangent[there, 2 * k : 2 * k + 2] = -np.outer(link, spins[k] @ basis)
    whole = system.propagate(x[:6], x[6:], 0.0, span, 1e-16, transition=tangent, **p).transition
    found = np.linalg.eigvals(np.linalg.lstsq(tangent, turned(np.asarray(whole), -turn), rcond=None)[0])
    return found[np.argsort(np.abs(found - 1))[4:]]
