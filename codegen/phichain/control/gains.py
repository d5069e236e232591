"""Gains: the frozen record of a linear regulator, its law and its files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phichain.archive import (
    COUNT,
    DURATION,
    NUMBER,
    TEXT,
    VALUES,
    Schema,
    complex_numbers,
    names,
    read_archive,
    real,
    refuse,
    signs,
    word,
)
from phichain.control.measured import Measured, on_angles, on_unit_vectors
from phichain.control.weights import Spectrum
from phichain.errors import ArrayError
from phichain.laws import StateFeedback
from phichain.records import Shown, write_csv, write_npz
from phichain.system import Vector
from phichain.system.arrays import real_numbers
from phichain.system.vertical import Signs
from phichain.units import unit_of

_ARRAYS = {
    "K": real("nu", "state"),
    "S": real("state", "state"),
    "A": real("state", "state"),
    "B": real("state", "nu"),
    "Q": real("state", "state"),
    "R": real("nu", "nu"),
    "poles": complex_numbers("state"),
    "modes": complex_numbers("modes"),
    "margins": real("modes"),
    "equilibrium": real("nq"),
}
_PLAIN = {
    "name": TEXT,
    "space": word("planar", "spatial"),
    "cart": COUNT,
    "residual": NUMBER,
    "iterations": COUNT,
    "digest": replace(TEXT, default=""),
    "sample": replace(DURATION, default=0.0),
    "error": replace(DURATION, default=0.0),
    "p": VALUES,
}
_SCHEMA = Schema(
    "Gains",
    _ARRAYS,
    {**_PLAIN, "s": signs("links"), "state_names": names("state"), "input_names": names("nu")},
    filled=("nu", "state", "modes", "links"),
)


@dataclass(frozen=True, eq=False, repr=False)
class Gains(Shown):
    """A linear regulator u = -K z about one equilibrium, with what it was made from.

    z = (x, x') in the coordinates of (19): z = [x; C^T xi; x'; C^T omega] in space, [x; delta theta; x'; theta'] in
    the plane. Equation (22) is the same law by blocks: K = [K_x, K_q, K_xdot, K_omega].

    Attributes:
        name: Name of the system.
        space: "planar" or "spatial".
        cart: Number of cart coordinates.
        s: The equilibrium: +1 hanging, -1 upright, per link.
        equilibrium: Its configuration q (nq,), the cart at the origin.
        K: Gains (nu, 2m).
        S: Solution of the Riccati equation (2m, 2m); z^T S z is the cost to go.
        A: Dynamics (2m, 2m) of z' = A z + B u.
        B: Input (2m, nu).
        Q: State weight (2m, 2m).
        R: Input weight (nu, nu).
        poles: Closed-loop eigenvalues (2m,), slowest first, 1/s.
        modes: Open-loop eigenvalues of the links, one of each pair (k,), 1/s.
        margins: Controllability margin of each of them (k,).
        residual: Relative residual of the chain's Riccati equation: no less than the accuracy of A and B, which is that of
            the type its functions compute in.
        iterations: Newton-Kleinman refinements.
        state_names: Names of z.
        input_names: Names of u.
        digest: Canonical digest of the system's scene; empty for one that was made by hand.
        sample: Time between two samples, s, over which the input is held; 0 for a regulator in continuous time. Where it is not,
            S and the weights belong to the sum over samples, and poles are log(z) / sample of the closed loop's eigenvalues z.
        error: Relative error of K that the accuracy of A and B explains, where they are less accurate than a double: those of a
            scene in single precision. 0 where it was not estimated.
    """

    name: str
    space: str
    cart: int
    s: Signs
    equilibrium: Vector
    K: Vector
    S: Vector
    A: Vector
    B: Vector
    Q: Vector
    R: Vector
    poles: Spectrum
    modes: Spectrum
    margins: Vector
    residual: float
    iterations: int
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    digest: str = ""
    sample: float = 0.0
    error: float = 0.0

    def __str__(self) -> str:
        slowest = complex(self.poles[0])
        kind = f"regulator sampled every {self.sample:g} s" if self.sample else "linear regulator"
        return (
            f"{self.name}: {kind} about s = {list(self.s)}, slowest closed-loop eigenvalue "
            f"{slowest.real:.8f} 1/s, controllability margin {self.margin:.3g}, largest gain "
            f"{np.max(np.abs(self.K)):.4g}, Riccati residual {self.residual:.1e}"
        ) + (f", gains right to {self.error:.1e}" if self.error else "")

    @property
    def margin(self) -> float:
        """The smallest controllability margin."""
        return float(np.min(self.margins))

    @property
    def decay(self) -> float:
        """Slowest closed-loop decay rate, 1/s: -max Re lambda."""
        return -float(np.max(self.poles.real))

    @property
    def blocks(self) -> dict[str, Vector]:
        """The blocks of (22): K_x (nu, cart), K_q (nu, links' coordinates), K_xdot, K_omega."""
        m = self.K.shape[1] // 2
        c = self.cart
        ranges = {"K_x": (0, c), "K_q": (c, m), "K_xdot": (m, m + c), "K_omega": (m + c, 2 * m)}
        return {name: self.K[:, start:stop] for name, (start, stop) in ranges.items()}

    def on_state(self, rows: Vector) -> Measured:
        """Rows (k, 2m) that act on z as rows (k, nx) on the state's deviation x - x_target, and what x is."""
        if self.space == "planar":
            return on_angles(rows, self.cart, self.state_names)
        return on_unit_vectors(rows, self.cart, self.s, self.state_names)

    def law(
        self,
        target: ArrayLike | None = None,
        *,
        u_0: ArrayLike | None = None,
        limit: ArrayLike | None = None,
        wrap: bool = True,
    ) -> StateFeedback:
        """The law (22) on the measured state x = (q, v), as a record that `lowering.laws.state_feedback` writes as a Program.

        In the plane z = x - x_target; in space z is linear in x and zero at the target, and the gains are those on x.

        Args:
            target: Where the cart is to stand (cart,), m; the origin unless given.
            u_0: Input that keeps the chain there (nu,); zero unless given.
            limit: Largest size of every input, one number or (nu,); no limit unless given.
            wrap: Whether angles count modulo a full turn.

        Raises:
            ArrayError: Shapes that do not fit, or limits that are not positive.
            ControlError: They hold no real numbers.
        """
        nu, nq = len(self.input_names), len(self.equilibrium)
        on = self.on_state(self.K)
        state = np.concatenate([self.equilibrium, np.zeros(nq)])
        place = real_numbers("target", np.zeros(self.cart) if target is None else target, "give where the cart goes")
        if np.atleast_1d(place).shape != (self.cart,):
            raise ArrayError("target", target, f"must hold {self.cart} position(s)", "give where the cart goes")
        state[: self.cart] = place
        bound = real_numbers("limit", np.inf if limit is None else limit, "give the largest size of every input")
        if bound.shape not in ((), (nu,)):
            raise ArrayError("limit", limit, f"must be one number or hold {nu}", "give the largest size of every input")
        if not np.all(bound > 0):
            raise ArrayError("limit", limit, "is not positive", "give the largest size of every input")
        high = np.broadcast_to(bound, (nu,))
        return StateFeedback(
            name=self.name,
            digest=self.digest,
            state_names=on.names,
            state_units=on.units,
            input_names=self.input_names,
            input_units=tuple(unit_of(name) or ("N" if k < self.cart else "N m") for k, name in enumerate(self.input_names)),
            target=tuple(state),
            rest=tuple(np.zeros(nu) if u_0 is None else real_numbers("u_0", u_0, "give one number per input")),
            gains=tuple(map(tuple, on.gains)),
            wraps=tuple(turns and wrap for turns in on.wraps),
            low=tuple(-high),
            high=tuple(high),
            sample=self.sample,
            p=self.p,
        )

    def to_csv(self, path: Path | str) -> Path:
        """Write one row per entry of z: its name and the gain of every input; 17 digits."""
        rows = {f"K_{name}": self.K[k] for k, name in enumerate(self.input_names)}
        return write_csv(path, {"state": np.array(self.state_names), **rows}, self)

    def to_npz(self, path: Path | str) -> Path:
        """Write the whole record; `from_npz` reads it back."""
        meta: dict[str, Any] = {name: getattr(self, name) for name in _PLAIN}
        meta |= {"kind": _SCHEMA.kind, "s": list(self.s)}
        meta |= {"state_names": list(self.state_names), "input_names": list(self.input_names)}
        return write_npz(path, {name: getattr(self, name) for name in _ARRAYS}, meta)

    @classmethod
    def from_npz(cls, path: Path | str) -> Gains:
        """Read what `to_npz` wrote.

        Raises:
            OutputError: The file is missing or holds no Gains, or not whole ones.
        """
        arrays, meta = read_archive(path, _SCHEMA)
        planar, links, cart = meta["space"] == "planar", len(meta["s"]), meta["cart"]
        sizes = {"equilibrium": cart + links * (1 if planar else 3), "K": 2 * (cart + links * (1 if planar else 2))}
        for name, size in sizes.items():
            if arrays[name].shape[-1] != size:
                kind = f"{meta['space']} chain of {links} link(s) with {cart} cart coordinate(s)"
                refuse(path, _SCHEMA, name, arrays[name].shape, f"is not that of a {kind}")
        plain: dict[str, Any] = {name: meta[name] for name in _PLAIN}
        plain |= {name: tuple(meta[name]) for name in ("s", "state_names", "input_names")}
        plain |= {name: arrays[name] for name in _ARRAYS}
        return cls(**plain)
