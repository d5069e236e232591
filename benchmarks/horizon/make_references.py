"""Makes benchmarks/horizon/references.json: where ten chaotic motions go, in binary128.

    python -m benchmarks.horizon.make_references

The dense closed form in absolute angles, M(phi) phi'' = ..., by heyoka's Taylor method at 1e-32; held against the same at 1e-29.
A reference holds until the two lie 1e-5 apart.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import heyoka as hy
import mpmath as mp
import numpy as np

from benchmarks.horizon.cases import CASES, FILE, TIMES, Case

APART = 1e-5
DIGITS = 20


def main() -> int:
    motions = {}
    for case in CASES:
        begin = time.perf_counter()
        fine, other = (states(case, tol) for tol in ("1e-32", "1e-29"))
        gaps = [float(max(abs(a - b) for a, b in zip(*rows, strict=True))) for rows in zip(fine, other, strict=True)]
        until = float(TIMES[next((k for k, gap in enumerate(gaps) if gap > APART), len(gaps)) - 1])
        gap = max(g for t, g in zip(TIMES, gaps, strict=True) if t <= until)
        motions[case.name] = {"until": until, "gap": gap, "states": [[mp.nstr(x, DIGITS) for x in row] for row in fine]}
        print(f"{case.name}: holds until {until:g} s, to {gap:.1g}, {time.perf_counter() - begin:.0f} s", flush=True)
    made = (__doc__ or "").split("\n\n")[2].replace("\n", " ")
    FILE.write_text(json.dumps({"made": made, "times": TIMES.tolist(), "motions": motions}) + "\n")
    return 0


def states(case: Case, tol: str) -> list[list[mp.mpf]]:
    """(q, v) of the scene at TIMES."""
    wide, links = hy.real128, case.scene().links
    cart = len(case.q) - links
    turn = np.eye(len(case.q))
    if case.scene().angles == "relative":
        turn[cart:, cart:] = np.tril(np.ones((links, links)))
    exact = [[mp.mpf(x) for x in part] for part in np.split(case.x0, 2)]
    start = [wide(mp.nstr(x, 36)) for part in exact for x in mp.matrix(turn.tolist()) * mp.matrix(part)]
    flow = hy.taylor_adaptive(equations(case), np.array(start), fp_type=wide, tol=wide(tol), compact_mode=True)
    back, found = mp.matrix(np.linalg.inv(turn).tolist()), [[*exact[0], *exact[1]]]
    for t in TIMES[1:]:
        flow.propagate_until(wide(float(t)))
        x = [mp.mpf(str(value)) for value in flow.state]
        found.append([*(back * mp.matrix(x[: len(case.q)])), *(back * mp.matrix(x[len(case.q) :]))])
    return found


def equations(case: Case) -> list[tuple[Any, Any]]:
    """(state, its rate) in absolute angles: mu_k, c_ij and M00 as section 1 of docs/theory.md has them, solved densely."""
    scene, wide = case.scene(), hy.real128
    n, cart = scene.links, len(case.q) - scene.links
    each = lambda value: [wide(float(x)) for x in np.broadcast_to(value, (n,))]
    mass, length, gravity = each(scene.mass), each(scene.length), wide(float(scene.gravity))
    com = length if scene.com is None else each(scene.com)
    beyond = [sum(mass[k + 1 :], wide(0)) for k in range(n)]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in range(n)]
    own = [mass[k] * com[k] * com[k] + length[k] * length[k] * beyond[k] for k in range(n)]
    c = [[own[i] if i == j else length[min(i, j)] * mu[max(i, j)] for j in range(n)] for i in range(n)]
    q, v = (list(hy.make_vars(*(f"{name}{k}" for k in range(cart + n)))) for name in "qv")
    phi, w = q[cart:], v[cart:]
    inertia = [[c[i][j] * hy.cos(phi[i] - phi[j]) if i != j else hy.expression(c[i][i]) for j in range(n)] for i in range(n)]
    push = [
        -gravity * mu[i] * hy.sin(phi[i]) - sum((c[i][j] * hy.sin(phi[i] - phi[j]) * w[j] * w[j] for j in range(n) if j != i), start=hy.expression(wide(0)))
        for i in range(n)
    ]  # fmt: skip
    if cart:
        whole = hy.expression(wide(float(scene.cart_mass)) + sum(mass, wide(0)))
        coupling = [mu[i] * hy.cos(phi[i]) for i in range(n)]
        inertia = [[whole, *coupling], *([coupling[i], *inertia[i]] for i in range(n))]
        push = [sum((mu[i] * hy.sin(phi[i]) * w[i] * w[i] for i in range(n)), start=hy.expression(wide(0))), *push]
    return [*zip(q, v, strict=True), *zip(v, solved(inertia, push), strict=True)]


def solved(matrix: list[list[Any]], right: list[Any]) -> list[Any]:
    """Gaussian elimination of a positive definite system of expressions."""
    rows, size = [[*row, b] for row, b in zip(matrix, right, strict=True)], len(right)
    for k in range(size):
        for i in range(k + 1, size):
            share = rows[i][k] / rows[k][k]
            rows[i] = [a - share * b for a, b in zip(rows[i], rows[k], strict=True)]
    found: list[Any] = [None] * size
    for k in reversed(range(size)):
        rest = sum((rows[k][j] * found[j] for j in range(k + 1, size)), start=hy.expression(hy.real128(0)))
        found[k] = (rows[k][size] - rest) / rows[k][k]
    return found


if __name__ == "__main__":
    mp.mp.dps = 40
    sys.exit(main())
