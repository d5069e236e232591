"""The reference engine: dense Lagrangian in quadruple precision, compiled once from engine.cpp."""

from __future__ import annotations

import ctypes
import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mpmath as mp
import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import BenchmarkError, run_compiler
from phichain.scene import Scene

_SOURCE = Path(__file__).with_suffix(".cpp")
_HEADERS = tuple(_SOURCE.with_name(f"engine_{part}.hpp") for part in ("model", "run"))
_FLAGS = ("-O2", "-std=c++17", "-fPIC", "-shared")
_WIDTH = 48  # characters of one number
_DIGITS = 40

Rows = list[list[mp.mpf]]


@dataclass(frozen=True)
class Run:
    """A reference motion.

    Attributes:
        states: one row (q, v) per time, in the scene's coordinates, as decimal strings.
        steps: steps taken.
        fastest: the largest rate met on the way, rad/s or m/s.
    """

    states: tuple[tuple[str, ...], ...]
    steps: int
    fastest: float

    def numbers(self) -> Rows:
        """The states as mpf, in all their digits."""
        with mp.workdps(_DIGITS):
            return [[mp.mpf(text) for text in row] for row in self.states]


class _Chain(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_int) for name in ("links", "spatial", "cart")),
        *(
            (name, ctypes.POINTER(ctypes.c_double))
            for name in ("mass", "length", "com", "stiffness", "damping", "force")
        ),
        *((name, ctypes.c_double) for name in ("cart_mass", "gravity", "amount")),
        ("direction", ctypes.POINTER(ctypes.c_double)),
        ("kicks", ctypes.c_int),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in ("kick_time", "kick_direction")),
    ]


@dataclass(frozen=True)
class Nudge:
    """A relative change of every number of a problem, and of the state again at some times on the way.

    Attributes:
        amount: its size.
        signs: +-1 per number: mass, length, com, stiffness, damping (n each), cart mass, gravity, state.
        times: when the state is changed again, rising, s.
        more: +-1 per entry of the state, time after time.
    """

    amount: float
    signs: tuple[float, ...]
    times: tuple[float, ...] = ()
    more: tuple[float, ...] = ()


def nudge(scene: Scene, amount: float, seed: int) -> Nudge:
    """A random one of every number."""
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], 5 * scene.links + 2 + scene.nq + scene.nv)
    return Nudge(amount, tuple(signs.tolist()))


def kicked(scene: Scene, amount: float, seed: int, end: float, kicks: int) -> Nudge:
    """A random one of the state: at the start and `kicks` times on the way to `end`."""
    size = scene.nq + scene.nv
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size * (1 + kicks)).tolist()
    times = tuple(end * (k + 0.5) / kicks for k in range(kicks))
    return Nudge(amount, (*([0.0] * (5 * scene.links + 2)), *signs[:size]), times, tuple(signs[size:]))


def integrate(
    scene: Scene,
    x0: Sequence[float],
    times: Sequence[float],
    tol: float = 1e-24,
    *,
    u: Sequence[float] = (),
    wide: bool = True,
    columns: int = 14,
    stages: int = 0,
    change: Nudge | None = None,
    budget: int = 50_000_000,
) -> Run:
    """States at `times` from x0 at 0.

    Args:
        scene: the chain; numeric parameters.
        x0: (q, v), read as exact binary64 numbers; a spatial one is put on the manifold.
        times: rising (or falling) from 0, s.
        tol: error per step, positions over max(1, |q|), rates over the fastest so far or sqrt(g / length).
        u: force on the cart.
        wide: binary128; otherwise 80-bit.
        columns: of the extrapolation table (order 2 x columns).
        stages: of Radau IIA in its place, for stiff problems; 0 for none.
        change: a relative change of every number.
        budget: steps.

    Raises:
        BenchmarkError: the budget ran out.
    """
    held = _chain(scene, u, change)
    start = np.ascontiguousarray(x0, dtype=float)
    grid = np.ascontiguousarray(times, dtype=float)
    size = _WIDTH * len(start) * len(grid) + 80
    out, info = ctypes.create_string_buffer(size), np.zeros(2)
    tableau = radau_tableau(stages) if stages else None
    failed = _library().integrate(
        ctypes.c_int(wide), ctypes.byref(held.chain), _at(start), ctypes.c_int(len(grid)), _at(grid),
        ctypes.c_double(tol), ctypes.c_int(stages or columns), None if tableau is None else _at(tableau),
        ctypes.c_long(budget), out, ctypes.c_size_t(size), _at(info),
    )  # fmt: skip
    if failed:
        raise BenchmarkError(f"the reference engine gave up on {scene.name} after {budget} steps")
    states = tuple(tuple(line.split()) for line in out.value.decode().splitlines())
    return Run(states, int(info[0]), float(info[1]))


def accelerations(
    scene: Scene,
    x0: Sequence[float],
    *,
    u: Sequence[float] = (),
    wide: bool = True,
    change: Nudge | None = None,
) -> tuple[str, ...]:
    """v' at one state, as decimal strings."""
    held = _chain(scene, u, change)
    start = np.ascontiguousarray(x0, dtype=float)
    size = _WIDTH * len(start) + 80
    out = ctypes.create_string_buffer(size)
    if _library().accelerations(
        ctypes.c_int(wide), ctypes.byref(held.chain), _at(start), out, ctypes.c_size_t(size)
    ):
        raise BenchmarkError("the reference engine's buffer is too small")
    return tuple(out.value.decode().split())


@cache
def radau_tableau(stages: int) -> NDArray[np.float64]:
    """c and A of Radau IIA as sums of three doubles each, flat.

    The nodes are the zeros of d^(s-1)/dx^(s-1) [x^(s-1) (x-1)^s]; A integrates the Lagrange polynomials over them.
    """
    with mp.workdps(80):
        s = stages
        # x^(s-1) (x-1)^s, differentiated s-1 times, by powers of x from the constant up
        grown = [mp.mpf(0)] * (s - 1) + [mp.binomial(s, j) * (-1) ** (s - j) for j in range(s + 1)]
        for _ in range(s - 1):
            grown = [power * value for power, value in enumerate(grown)][1:]
        c = sorted(mp.re(root) for root in mp.polyroots(grown[::-1], maxsteps=500, extraprec=400))
        powers = mp.matrix(s, s)
        for i in range(s):
            for j in range(s):
                powers[i, j] = c[j] ** i
        inverse = powers**-1  # column of Lagrange coefficients: L_j(x) = sum_i inverse[j, i] x^i
        a = [
            mp.fsum(inverse[j, i] * c[row] ** (i + 1) / (i + 1) for i in range(s))
            for row in range(s)
            for j in range(s)
        ]
        parts = []
        for value in [*c, *a]:
            rest = value
            for _ in range(3):
                head = float(rest)
                parts.append(head)
                rest -= mp.mpf(head)
        return np.array(parts)


@dataclass(frozen=True)
class _Held:
    """The C struct and the arrays it points into."""

    chain: _Chain
    arrays: tuple[NDArray[np.float64], ...]


def _chain(scene: Scene, u: Sequence[float], change: Nudge | None) -> _Held:
    rest = (0.0,) * scene.links
    force = [*u, 0.0, 0.0][:2]
    values = (
        scene.mass,
        scene.length,
        scene.com or scene.length,
        scene.stiffness or rest,
        scene.damping or rest,
        force,
    )
    arrays = tuple(np.ascontiguousarray(value, dtype=float) for value in values)
    pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in arrays]
    moved = (
        ()
        if change is None
        else tuple(np.array(x, dtype=float) for x in (change.signs, change.times, change.more))
    )
    signs, *kicks = [x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for x in moved] or [None, None, None]
    chain = _Chain(
        scene.links, int(not scene.is_planar), int(scene.has_cart), *pointers,
        float(scene.cart_mass or 0.0), float(scene.gravity), 0.0 if change is None else change.amount, signs,
        0 if change is None else len(change.times), *kicks,
    )  # fmt: skip
    return _Held(chain, (*arrays, *moved))


def _at(array: NDArray[np.float64]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@cache
def _library() -> ctypes.CDLL:
    """The engine, compiled into the user's cache under a digest of its source."""
    digest = hashlib.sha256(
        repr(([path.read_text() for path in (_SOURCE, *_HEADERS)], _FLAGS)).encode()
    ).hexdigest()[:16]
    folder = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "phichain-bench"
    library = folder / f"engine-{digest}.so"
    if not library.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = library.with_suffix(f".{os.getpid()}")
        run_compiler(["c++", *_FLAGS, str(_SOURCE), "-o", str(unfinished), "-lquadmath"])
        unfinished.replace(library)
    return ctypes.CDLL(str(library))
