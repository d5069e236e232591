"""Whether a law is a function of (t, x): the same question must have the same answer, whatever was asked in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from phichain.errors import ArrayError
from phichain.motion.inputs.afresh import Afresh
from phichain.motion.inputs.piece import Control
from phichain.records import Held
from phichain.system import Vector

SAME = 1e-12
"""Two answers that differ by less, relative to their size, are one: a sum may be taken in another order."""


@dataclass(frozen=True, eq=False)
class _Answer(Held):
    t: float
    x: Vector
    u: Vector


class Purity:
    """Questions put to a law at accepted steps, once and again after later and after earlier ones, and to what it was before.

    A law that remembers its last call answers by what it saw last. So the last step's question is put again after each step, and after
    1, 2, 4, 8, ... steps the first one, and this step's after these earlier ones: twelve evaluations of a step cost more. One that
    remembers what it saw first answers everything twice alike; its copy, that nobody has asked, is asked after 1, 2, 3, 5, 9, ... steps.
    A copy that does not answer the very first question as the law does is none, and says nothing.
    """

    def __init__(self, control: Control, t: float, x: Vector, is_copied: bool = True) -> None:
        """Ask at the start; and whether a copy may be made before."""
        self._control, self._steps = control, 0
        self._before = Afresh(control) if is_copied else None
        self._first = self._last = _Answer(t, x, control(t, x))
        u = self._u_before(self._first)
        if u is None or not _is_same(self._first.u, u):
            self._before = None

    def look(self, t: float, x: Vector) -> None:
        """Ask at the end of a step, and again what was asked before.

        Raises:
            ArrayError: An answer has changed.
        """
        self._steps += 1
        if not np.isfinite(x).all():
            return
        here = _Answer(t, x, self._control(t, x))
        self._again(self._last)
        if self._steps & (self._steps - 1) == 0:
            self._again(self._first)
            self._again(here)
        if (self._steps - 1) & (self._steps - 2) == 0:  # odd ones: every other step may begin a sample
            self._as_before(here)
        self._last = here

    def _again(self, before: _Answer) -> None:
        _demand_same(before, self._control(before.t, before.x))

    def _as_before(self, here: _Answer) -> None:
        u = self._u_before(here)
        if u is not None:
            _demand_same(_Answer(here.t, here.x, u), here.u)

    def _u_before(self, here: _Answer) -> Vector | None:
        """The answer of a fresh copy; None where there is none."""
        law = None if self._before is None else self._before.law()
        if law is None:
            return None
        try:
            return law(here.t, here.x)
        except Exception:  # noqa: BLE001 - a copy that cannot answer says nothing
            return None


def _demand_same(before: _Answer, now: Vector) -> None:
    """Refuse a law that gives two answers to one question.

    Raises:
        ArrayError: It does.
    """
    if not _is_same(before.u, now):
        raise ArrayError(
            "u", (before.u.tolist(), now.tolist()),
            f"gives two answers at t = {before.t:.6g} s in one state, so it is no function of (t, x): it remembers earlier calls",
            "give sample=Ts for a law that samples or has a memory: it is then asked once at every sample, in their order",
        )  # fmt: skip


def _is_same(one: Vector, other: Vector) -> bool:
    if np.array_equal(one, other):
        return True
    return not np.max(np.abs(other - one)) > SAME * max(np.max(np.abs(other)), np.max(np.abs(one)))
