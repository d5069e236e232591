"""What a spring and damper between two unit vectors adds to the linearised equations of both links.

Joint k puts Q = k_k b - d_k (omega_h - omega_b) x h on link k (direction h, rate omega_h) and k_k h + d_k (omega_h - omega_b) x b
on the link before (b, omega_b). With d omega = q x dnu - q (omega . ds) of either link, P across it,

    on h:  k (b.h) ds_h + d dnu_h - d (omega_b . h) h x ds_h     - P_h (k ds_b + d d omega_b x h)
    on b:  k (b.h) ds_b + d dnu_b - d (omega_h . b) b x ds_b     - P_b (k ds_h + d d omega_h x b)

is what -P dQ + (Q . q) ds comes to. Dry friction puts c for d, a function of the slip w = omega_h - omega_b with
dc = g (w . dw), and adds g (w . dw) (w x h) on h and the opposite of g (w . dw) (w x b) on b. The same words give the constant part and, column by column, the matrices.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.matrix import Matrix, transposed
from phichain.lowering.algebra.vector import Vector, add, cross, dot, load, scale, sub
from phichain.lowering.chain.losses import joint_resisted
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.spatial.chart import across
from phichain.scene import Scene

#: A perturbation (ds, dnu) of a link.
Perturbation = tuple[Vector, Vector]


#: c and g of every joint where dry friction acts.
RESISTED = "resisted"


def write_resistances(builder: Builder, scene: Scene, parameters: Parameters, known: dict[str, ArrayRef]) -> None:
    """Write c_k and g_k of every joint at the rates of `known`."""
    spin, out = known["spin"], known[RESISTED]

    def write(k: Index, slip: Vector) -> None:
        found = joint_resisted(scene, parameters, k, slip)
        assert found.g is not None
        out[2 * k], out[2 * k + 1] = found.c, found.g

    write(0, load(spin, 0))
    with builder.loop("k", 1, scene.links) as loop:
        write(loop.index, sub(load(spin, loop.index), load(spin, loop.index - 1)))


class Joint:
    """Joint k; the one at the base ties link 0 to the vertical, which does not move."""

    def __init__(
        self,
        builder: Builder,
        parameters: Parameters,
        known: dict[str, ArrayRef],
        k: Index,
        at_base: bool,
    ) -> None:
        unit, spin = known["unit"], known["spin"]
        nothing, one = builder.lift(0), builder.lift(1)
        self.builder = builder
        self.stiffness = None if parameters.stiffness is None else parameters.stiffness[k]
        self.damping = None if parameters.damping is None else parameters.damping[k]
        self.here, self.spin = load(unit, k), load(spin, k)
        self.before: Vector = (nothing, nothing, one) if at_base else load(unit, k - 1)
        self.spin_before: Vector = (nothing, nothing, nothing) if at_base else load(spin, k - 1)
        self.bend: Expr | None = None
        if RESISTED in known:
            self.damping, self.bend = known[RESISTED][2 * k], known[RESISTED][2 * k + 1]
        self.slip = sub(self.spin, self.spin_before)

    def on_link(self, moved: Perturbation) -> Vector:
        """On link k where link k moves."""
        return self._own(self.here, self.spin, self.spin_before, moved)

    def on_before(self, moved: Perturbation) -> Vector:
        """On the link before where that one moves."""
        return self._own(self.before, self.spin_before, self.spin, moved)

    def across_to_link(self, moved: Perturbation) -> Vector:
        """On link k where the link before moves."""
        return self._other(self.here, self.before, self.spin_before, moved)

    def across_to_before(self, moved: Perturbation) -> Vector:
        """On the link before where link k moves."""
        return self._other(self.before, self.here, self.spin, moved)

    def _own(self, here: Vector, spin: Vector, other_spin: Vector, moved: Perturbation) -> Vector:
        shift, rate = moved
        total = scale(0, shift)
        if self.stiffness is not None:
            total = scale(self.stiffness * dot(self.before, self.here), shift)
        if self.damping is not None:
            total = add(total, scale(self.damping, rate))
            total = sub(total, scale(self.damping * dot(other_spin, here), cross(here, shift)))
        if self.bend is not None:
            turning = sub(cross(here, rate), scale(dot(spin, shift), here))
            total = add(total, scale(self.bend * dot(self.slip, turning), cross(self.slip, here)))
        return total

    def _other(self, here: Vector, there: Vector, spin: Vector, moved: Perturbation) -> Vector:
        shift, rate = moved
        total = scale(0, shift)
        if self.stiffness is not None:
            total = scale(self.stiffness, shift)
        if self.damping is not None:
            turning = sub(cross(there, rate), scale(dot(spin, shift), there))
            total = add(total, scale(self.damping, cross(turning, here)))
            if self.bend is not None:
                total = add(total, scale(self.bend * dot(self.slip, turning), cross(self.slip, here)))
        return scale(-1, across(here, total))

    def matrix(self, response: Callable[[Perturbation], Vector], gain: Expr) -> Matrix:
        """A response to x, which moves by ds = g^2 x and dnu = g x."""
        columns = []
        for axis in range(3):
            nothing = self.builder.lift(0)
            rate = tuple(gain if i == axis else nothing for i in range(3))
            shift = tuple(gain * part for part in rate)
            columns.append(response(((shift[0], shift[1], shift[2]), (rate[0], rate[1], rate[2]))))
        return transposed(tuple(columns))
