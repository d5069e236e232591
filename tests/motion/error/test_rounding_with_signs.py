"""At round-off an estimate is the error itself: the rounding of every step is known with its sign.

The judge is the dense closed form in absolute angles, M(phi) phi'' = ..., in 32 digits.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from benchmarks.horizon.cases import CASES
from benchmarks.horizon.judge import run
from phichain import build
from phichain.emit.flow.pairs import knows_rounding
from phichain.lowering.series import series
from phichain.mechanics import derive
from phichain.scene import Scene

WANT = ("forward_dynamics", "propagate")
SCENES = {
    "pair": Scene("pair", 2, mass=[1.0, 0.6], length=[1.0, 0.7], com=[0.3, 0.6], want=WANT),
    "triple": Scene("triple", 3, mass=[0.9, 0.4, 1.7], length=[0.7, 1.1, 0.3], angles="absolute", want=WANT),
    "sprung": Scene("sprung", 2, mass="runtime", length=[1.0, 0.7], stiffness=[300.0, 7.0], damping=0.3, actuated="all", want=WANT),
    "single": Scene("single", 1, mass=1.3, length=0.7, com=0.4, want=WANT),
    "many": Scene("many", 5, mass=[1.0, 0.6, 0.3, 0.8, 0.2], length=0.4, want=WANT),
}
MASSES, TORQUES = (1.1, 0.3), (0.3, -0.2)


def numbers(value: Any, count: int) -> list[Any]:
    return [mp.mpf(float(x)) for x in np.broadcast_to(value, (count,))]


def rates(scene: Scene, x: list[Any]) -> list[Any]:
    """x' of (q, v), from the dense closed form."""
    n = scene.links
    mass, length = numbers(MASSES if scene.mass == "runtime" else scene.mass, n), numbers(scene.length, n)
    com = length if scene.com is None else numbers(scene.com, n)
    sums = (lambda y: [mp.fsum(y[: k + 1]) for k in range(n)]) if scene.angles == "relative" else (lambda y: list(y))
    phi, w = sums(x[:n]), sums(x[n:])
    beyond = [mp.fsum(mass[k + 1 :]) for k in range(n)]
    mu = [mass[k] * com[k] + length[k] * beyond[k] for k in range(n)]
    own = [mass[k] * com[k] ** 2 + length[k] ** 2 * beyond[k] for k in range(n)]
    c = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            c[i, j] = own[i] if i == j else length[min(i, j)] * mu[max(i, j)]
    joint = [mp.mpf(0)] * (n + 1)
    if scene.stiffness is not None:
        stiffness, damping, torque = numbers(scene.stiffness, n), numbers(scene.damping, n), numbers(TORQUES, n)
        joint[:n] = [torque[k] - stiffness[k] * x[k] - damping[k] * x[n + k] for k in range(n)]
    gravity = mp.mpf(float(scene.gravity))
    push = mp.matrix([
        joint[i] - joint[i + 1] - gravity * mu[i] * mp.sin(phi[i]) - mp.fsum(c[i, j] * mp.sin(phi[i] - phi[j]) * w[j] ** 2 for j in range(n) if j != i)
        for i in range(n)
    ])  # fmt: skip
    inertia = mp.matrix(n, n)
    for i in range(n):
        for j in range(n):
            inertia[i, j] = c[i, j] * mp.cos(phi[i] - phi[j])
    a = mp.lu_solve(inertia, push)
    a = [a[k] - (a[k - 1] if k and scene.angles == "relative" else 0) for k in range(n)]
    return [*x[n:], *a]


def flown(field: Any, x: list[Any], h: Any, levels: int = 11) -> list[Any]:
    """The state after h by Gragg's midpoint rule, extrapolated (Hairer, Norsett, Wanner I, II.9)."""
    rows: list[list[list[Any]]] = []
    for level in range(levels):
        many = 2 * (level + 1)
        step = h / many
        before, now = x, [a + step * b for a, b in zip(x, field(x), strict=True)]
        for _ in range(many - 1):
            before, now = now, [a + 2 * step * b for a, b in zip(before, field(now), strict=True)]
        end = [(a + b + step * c) / 2 for a, b, c in zip(now, before, field(now), strict=True)]
        row = [end]
        for k in range(level):
            ratio = (mp.mpf(many) / (2 * (level - k))) ** 2 - 1
            row.append([a + (a - b) / ratio for a, b in zip(row[-1], rows[-1][k], strict=True)])
        rows.append(row)
    return rows[-1][-1]


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_a_step_is_off_by_what_is_said(name: str) -> None:
    scene, rng = SCENES[name], np.random.default_rng(5)
    system = build(scene, prove=False)
    given: dict[str, Any] = {"u": np.array(TORQUES), "p": {"mass": list(MASSES)}} if name == "sprung" else {}
    ratios = []
    for _ in range(2 if name == "many" else 4):
        x0, beside = 0.7 * rng.normal(size=system.nx), system.propagate.beside()
        found = system.propagate(x0[: system.nq], x0[system.nq :], 0.0, 0.03, 2.0**-52, beside=beside, max_steps=1, **given)
        said = beside.errors[-1]
        with mp.workdps(32):
            exact = flown(partial(rates, scene), list(map(mp.mpf, map(float, x0))), mp.mpf(found.t))
            off = [abs(mp.mpf(float(x)) + mp.mpf(float(lost)) - e) for x, lost, e in zip((*found.q, *found.v), found.lost[1:], exact, strict=True)]
        ratios += [said[0] / float(max(off[: system.nq])), said[1] / float(max(off[system.nq :]))]
    assert np.all(np.abs(np.array(ratios) - 1) < 0.25) and np.median(np.abs(np.array(ratios) - 1)) < 0.05


@pytest.mark.long
@pytest.mark.parametrize("name", ["wild_pair", "cart_pair", "triple"])
def test_estimates_at_round_off_are_twice_the_error(name: str) -> None:
    found = run(next(case for case in CASES if case.name == name), "taylor", None)
    seen = (found.true > 1e-13) & (found.true < 1e-2)
    ratio = found.estimated[seen] / found.true[seen]
    assert seen.sum() > 5 and np.all((ratio > 1.2) & (ratio < 4)) and abs(np.median(ratio) - 2) < 0.15


def test_what_has_no_pairs_is_said() -> None:
    """Dry friction, whose tanh has none; and space."""
    plain = {"mass": 1.0, "length": 1.0, "want": WANT}
    known = {
        "plain": Scene("plain", 2, **plain), "rubbing": Scene("rubbing", 2, friction=0.1, friction_speed=0.1, **plain),
        "ball": Scene("ball", 2, "spatial", **plain), "geared": Scene("geared", 6, armature=0.1, base="cart", cart_mass=2.0, **plain),
    }  # fmt: skip
    assert {name for name, scene in known.items() if knows_rounding(scene, series(derive(scene)))} == {"plain", "geared"}
