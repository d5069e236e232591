r"""One Runge-Kutta step of order 4 on unit vectors with its exact discrete Jacobian, for controllers and estimators.

A state in floating point is never exactly unit and tangent; the nearest consistent state, project(q, v), stands for it, and what is
differentiated is the step from there: A = D step(q, v) P with P = D project(q, v), at q_k of length 1 and q_k.omega_k = 0

    dq -> dq - q (q.dq),    domega -> domega - q (q.domega + omega.dq_tangent),

so that A may be multiplied by any variation, returns tangent ones, and lets covariances of unit vectors be carried on as they are. With
x = (q, omega) and stages x_s = x + w_s h k_{s-1} (w = 0, 1/2, 1/2, 1), a column runs through the step beside the state:

    dk_s = (domega x q + omega x dq,  dadq dq + dadv domega [+ dadu]) at stage s,    dx_{s+1} = dx + w_{s+1} h dk_s,
    dx_free = dx + h/6 (dk_1 + 2 dk_2 + 2 dk_3 + dk_4),    and D project at the end, where x_free is neither unit nor tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, store, sub
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.links import directions
from phichain.lowering.steps.runge_kutta import moved, velocity
from phichain.lowering.writers import writes
from phichain.scene import Scene

_HALF = 0.5
_WEIGHTS = (0, _HALF, _HALF, 1)
_SHARES = (1, 2, 2, 1)


@dataclass(frozen=True)
class _Stage:
    """Where a stage is, its slope, and the derivatives of its accelerations."""

    q: ArrayRef
    v: ArrayRef
    slope: tuple[ArrayRef, ArrayRef]
    by: tuple[ArrayRef, ...]


@writes("step_jacobian", space="spatial", calls=("dynamics_and_jacobian",))
def step_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, dynamics: Program, **arguments: ArrayRef
) -> None:
    """Write the state after one step of size h, and its derivatives by the state before and by the held input."""
    _Step(builder, scene, dynamics, arguments).run()


class _Step:
    """The step being written: `run` is the whole of it."""

    def __init__(self, builder: Builder, scene: Scene, dynamics: Program, arguments: dict[str, ArrayRef]) -> None:
        self.builder, self.scene, self.dynamics, self.arguments = builder, scene, dynamics, arguments
        self.size, self.cart, self.h = scene.nv, 2 if scene.has_cart else 0, arguments["h"][0]
        self.sixth = builder.let("sixth", self.h / 6)

    def run(self) -> None:
        """Write q_next, v_next, A and B."""
        builder, scene = self.builder, self.scene
        self.stages: list[_Stage] = []
        for weight in _WEIGHTS:
            self.stages.append(self._stage(weight))
        self.tangent, self.tilt = self._starts()
        self.free = tuple(self._end(part, start) for part, start in enumerate(("q", "v")))
        self._land()
        self.column = {name: builder.array(name, self.size) for name in ("dq", "dv", "at_dq", "at_dv", "sum_q", "sum_v", "slope_q", "slope_v")}
        for first in (0, self.size):
            if self.cart:
                with builder.loop("axis", 0, self.cart) as loop:
                    self._seed_cart(loop.index, of_q=not first)
                    self._carry(None)
                    self._put("A", 2 * self.size, loop.index + first)
            with builder.loop("link", 0, scene.links) as loop, builder.loop("a", 0, 3) as axes:
                self._seed_link(loop.index, axes.index, of_q=not first)
                self._carry(None)
                self._put("A", 2 * self.size, 3 * loop.index + axes.index + (first + self.cart))
        if scene.nu:
            with builder.loop("input", 0, scene.nu) as loop:
                self._fill("dq", 0, self.size)
                self._fill("dv", 0, self.size)
                self._carry(loop.index)
                self._put("B", scene.nu, loop.index)

    def _stage(self, weight: float) -> _Stage:
        """The next stage of the state itself."""
        builder, scene, number = self.builder, self.scene, len(self.stages) + 1
        q, v = self.arguments["q"], self.arguments["v"]
        if self.stages:
            q, v = moved(builder, scene, (q, v), self.h * weight, self.stages[-1].slope)
        size = self.size
        a, *by = builder.call(
            self.dynamics, [q, v, *([self.arguments["u"]] if scene.nu else [])],
            {
                f"acceleration_{number}": size, f"by_q_{number}": size * size, f"by_v_{number}": size * size,
                **({f"by_u_{number}": size * scene.nu} if scene.nu else {}),
            },
        )  # fmt: skip
        return _Stage(q, v, (velocity(builder, scene, q, v, number), a), tuple(by))

    def _end(self, part: int, start: str) -> ArrayRef:
        """Where the stages lead, off the sphere."""
        free = self.builder.array(f"{start}_free", self.size)
        with self.builder.loop("i", 0, self.size) as loop:
            i = loop.index
            k1, k2, k3, k4 = (stage.slope[part][i] for stage in self.stages)
            free[i] = self.arguments[start][i] + self.sixth * ((k1 + k4) + 2 * (k2 + k3))
        return free

    def _starts(self) -> tuple[ArrayRef, ArrayRef]:
        """P, link by link and row by row of a unit variation of q: what it does to the link, and to its rate."""
        tangent, tilt = self.builder.array("tangent", 9 * self.scene.links), self.builder.array("tilt", 9 * self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            here, omega = (load(directions(self.scene, self.arguments[name]), k) for name in ("q", "v"))
            for a in range(3):
                along = tuple(
                    self.builder.let("across", (1 - here[a] * here[b]) if a == b else -(here[a] * here[b])) for b in range(3)
                )
                store(tangent.shifted(3 * a), 3 * k, along)
                store(tilt.shifted(3 * a), 3 * k, scale(-dot(along, omega), here))
        return tangent, tilt

    def _land(self) -> None:
        """Write q_next and v_next; keep what their derivatives ask for: unit vectors, lengths, rates along them."""
        builder, scene = self.builder, self.scene
        q_free, v_free = self.free
        for i in range(self.cart):
            self.arguments["q_next"][i], self.arguments["v_next"][i] = q_free[i], v_free[i]
        self.unit, self.shorten = builder.array("unit", 3 * scene.links), builder.array("shorten", scene.links)
        self.along = builder.array("along", scene.links)
        with builder.loop("k", 0, scene.links) as loop:
            k = loop.index
            here, turning = load(q_free.shifted(self.cart), k), load(v_free.shifted(self.cart), k)
            shorten = builder.let("over_length", 1 / builder.sqrt(dot(here, here)))
            unit: Vector = tuple(builder.let("unit_k", part) for part in scale(shorten, here))
            along = builder.let("spin", dot(unit, turning))
            store(self.unit, k, unit)
            self.shorten[k], self.along[k] = shorten, along
            store(self.arguments["q_next"].shifted(self.cart), k, unit)
            store(self.arguments["v_next"].shifted(self.cart), k, sub(turning, scale(along, unit)))

    def _fill(self, name: str, first: Index | int, last: Index | int) -> None:
        """Zeros."""
        with self.builder.loop("i", first, last) as loop:
            self.column[name][loop.index] = self.builder.lift(0)

    def _seed_cart(self, axis: Index, of_q: bool) -> None:
        """A column that moves the cart, or changes its rate."""
        seeded, still = ("dq", "dv") if of_q else ("dv", "dq")
        self._fill(seeded, 0, axis)
        self.column[seeded][axis] = self.builder.lift(1)
        self._fill(seeded, axis + 1, self.size)
        self._fill(still, 0, self.size)

    def _seed_link(self, k: Index, a: Index, of_q: bool) -> None:
        """A column of P: a link's direction along an axis, or its rate."""
        parts = {"dq": self.tangent, "dv": self.tilt} if of_q else {"dv": self.tangent}
        for name in ("dq", "dv"):
            if name not in parts:
                self._fill(name, 0, self.size)
                continue
            self._fill(name, 0, 3 * k + self.cart)
            for b in range(3):
                self.column[name][3 * k + (self.cart + b)] = parts[name][9 * k + 3 * a + b]
            self._fill(name, 3 * k + (self.cart + 3), self.size)

    def _carry(self, pushed: Index | None) -> None:
        """Carry a column through the stages; an input that it is of acts at each."""
        builder, column = self.builder, self.column
        for number, (stage, weight, share) in enumerate(zip(self.stages, _WEIGHTS, _SHARES, strict=True)):
            at = ("dq", "dv") if not number else ("at_dq", "at_dv")
            if number:
                with builder.loop("i", 0, self.size) as loop:
                    for name, start, slope in (("at_dq", "dq", "slope_q"), ("at_dv", "dv", "slope_v")):
                        column[name][loop.index] = column[start][loop.index] + self.h * weight * column[slope][loop.index]
            self._slope(stage, column[at[0]], column[at[1]], pushed)
            with builder.loop("i", 0, self.size) as loop:
                i = loop.index
                for total, slope in (("sum_q", "slope_q"), ("sum_v", "slope_v")):
                    column[total][i] = column[slope][i] if not number else column[total][i] + share * column[slope][i]

    def _slope(self, stage: _Stage, dq: ArrayRef, dv: ArrayRef, pushed: Index | None) -> None:
        """dk of a stage."""
        builder, slope_q, slope_v = self.builder, self.column["slope_q"], self.column["slope_v"]
        for axis in range(self.cart):
            slope_q[axis] = dv[axis]
        with builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            q, v, link, spin = (load(array.shifted(self.cart), k) for array in (stage.q, stage.v, dq, dv))
            store(slope_q.shifted(self.cart), k, add(cross(spin, q), cross(v, link)))
        with builder.loop("i", 0, self.size) as rows:
            i = rows.index
            first = builder.lift(0) if pushed is None else stage.by[2][i * self.scene.nu + pushed]
            with builder.loop("j", 0, self.size) as loop:
                total, j = loop.carry("sum", first), loop.index
                loop.follow(total, total + (stage.by[0][i * self.size + j] * dq[j] + stage.by[1][i * self.size + j] * dv[j]))
            slope_v[i] = total

    def _put(self, name: str, width: int, place: Index) -> None:
        """Write a column of A or B: D project at the end."""
        column, out, rows = self.column, self.arguments[name], self.size

        def moved_by(start: str, total: str) -> Callable[[Index | int], Expr]:
            return lambda i: column[start][i] + self.sixth * column[total][i]

        of_q, of_v = moved_by("dq", "sum_q"), moved_by("dv", "sum_v")
        for i in range(self.cart):
            out[place + width * i], out[place + width * (i + rows)] = of_q(i), of_v(i)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            cells = [3 * k + (self.cart + b) for b in range(3)]
            unit, turning = load(self.unit, k), load(self.free[1].shifted(self.cart), k)
            link: Vector = tuple(self.builder.let("free_dq", of_q(i)) for i in cells)
            spin: Vector = tuple(self.builder.let("free_dv", of_v(i)) for i in cells)
            away = self.builder.let("away", dot(unit, link))
            turned: Vector = tuple(
                self.builder.let("turned", self.shorten[k] * part) for part in sub(link, scale(away, unit))
            )
            lost = self.builder.let("lost_spin", dot(turned, turning) + dot(unit, spin))
            rate = sub(sub(spin, scale(lost, unit)), scale(self.along[k], turned))
            for b in range(3):
                out[cells[b] * width + place] = turned[b]
                out[(cells[b] + rows) * width + place] = rate[b]
