"""How springs, dampers and dry friction of spatial joints move with both their links.

With M_k = s_k q_k x q_{k-1} - c_k w_k, w_k = omega_k - omega_{k-1}, of joint k (s_k its stiffness) the couple on link k is
n_k = (M_k - M_{k+1}) x q_k, and hat(a) b = a x b gives

    dn_k = s_k hat(q_k) (hat(q_{k-1}) dq_k - hat(q_k) dq_{k-1}) + s_{k+1} hat(q_k) (hat(q_{k+1}) dq_k - hat(q_k) dq_{k+1})
           + hat(M_k - M_{k+1}) dq_k + hat(q_k) (C_k dw_k - C_{k+1} dw_{k+1}),   C = c + g w w^T,

c a number, or what moves by g (w.dw) (`chain.losses`). Joint 0 ties link 0 to the vertical, and nothing is beyond the tip.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder, Index
from phichain.lowering.algebra.matrix import Matrix, hat, outer, plus, product, scalar, scaled, zero
from phichain.lowering.algebra.vector import Vector, down, load, sub
from phichain.lowering.chain.losses import joint_resisted, slows_joints
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene


class Joints:
    """The derivatives of the couples n_k of one chain by its directions and by its angular velocities."""

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters, direction: ArrayRef, omega: ArrayRef, moment: ArrayRef) -> None:
        """Take the chain's arrays.

        Args:
            builder: where the Program is recorded.
            scene: the chain, joints of which transmit moments.
            parameters: its numbers.
            direction: unit vectors.
            omega: angular velocities.
            moment: M_k, zero beyond the tip.
        """
        self.builder, self.scene, self.parameters = builder, scene, parameters
        self.direction, self.omega, self.moment = direction, omega, moment
        self.resisted = self._resisted() if slows_joints(scene) else None

    def _resisted(self) -> tuple[ArrayRef, ArrayRef | None]:
        """c_k, and g_k where dry friction acts, one cell a joint."""
        if self.scene.friction is None:
            assert self.parameters.damping is not None
            return self.parameters.damping, None
        c, g = (self.builder.array(name, self.scene.links) for name in ("resistance", "resistance_slope"))

        def write(k: Index) -> None:
            found = joint_resisted(self.scene, self.parameters, k, self._slip(k))
            assert found.g is not None
            c[k], g[k] = found.c, found.g

        write(0)
        with self.builder.loop("k", 1, self.scene.links) as loop:
            write(loop.index)
        return c, g

    def _slip(self, k: Index) -> Vector:
        here = load(self.omega, k)
        return here if isinstance(k, int) and k == 0 else sub(here, load(self.omega, k - 1))

    def by_direction(self, k: Index, of: int, is_tip: bool) -> Matrix:
        """dn_k / dq_{k+of}, `of` one of -1, 0 and 1."""
        stiffness, here = self.parameters.stiffness, load(self.direction, k)
        own, nothing = hat(self.builder, here), zero(self.builder)
        if of:
            return nothing if stiffness is None else scaled(-stiffness[k if of < 0 else k + 1], product(own, own))
        net = load(self.moment, k) if is_tip else sub(load(self.moment, k), load(self.moment, k + 1))
        total = hat(self.builder, net)
        if stiffness is None:
            return total
        before = down(self.builder, 3) if isinstance(k, int) and k == 0 else load(self.direction, k - 1)
        pulled = scaled(stiffness[k], hat(self.builder, before))
        if not is_tip:
            pulled = plus(pulled, scaled(stiffness[k + 1], hat(self.builder, load(self.direction, k + 1))))
        return plus(total, product(own, pulled))

    def by_rate(self, k: Index, of: int, is_tip: bool) -> Matrix:
        """dn_k / domega_{k+of}."""
        if self.resisted is None:
            return zero(self.builder)
        own = hat(self.builder, load(self.direction, k))
        if of:
            return scaled(-1, product(own, self._resistance(k if of < 0 else k + 1)))
        total = self._resistance(k)
        return product(own, total if is_tip else plus(total, self._resistance(k + 1)))

    def _resistance(self, k: Index) -> Matrix:
        """C_k."""
        assert self.resisted is not None
        c, g = self.resisted
        if g is None:
            return scalar(c[k])
        slip = self._slip(k)
        return plus(scalar(c[k]), scaled(g[k], outer(slip, slip)))
