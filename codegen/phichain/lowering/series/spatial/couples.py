"""The couples of springs and dampers on spatial links, order by order: linear in coefficients that are known.

What a spring does to a link may be changed along the link, where the multiplier takes it: k_k (q_{k-1} - q_k), a difference of
coefficients that are known, stands for the gradient of V = k_k (1 - q_{k-1}.q_k). The damper's couple
-d_k (omega_k - omega_{k-1}) x q_k is -d_k v_k - q_k x (-d_k omega_{k-1}), omega = q x v. Where joints rub, dampers and dry friction
are one moment N_k on link k, the difference of both joints', and its couple is -q_k x N_k.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.algebra.vector import Vector, add, cross, load, scale, store, sub
from phichain.lowering.chain.losses import ties_links
from phichain.lowering.series.held import Layout
from phichain.lowering.series.spatial.rubs import Rubs
from phichain.lowering.spatial.links import directions
from phichain.scene import Scene


def keep_rests(builder: Builder, links: int, lost: ArrayRef, rest: ArrayRef) -> None:
    """Hold what rounding took from q_{k-1} - q_k: springs that are stiff enough make of it what they make of a bend.

    Args:
        builder: where the Program is written.
        links: how many there are.
        lost: what rounding took from the unit vectors, three cells a link.
        rest: where it is held, likewise.
    """
    store(rest, 0, tuple(-entry for entry in load(lost, 0)))
    with builder.loop("k", 1, links) as loop:
        store(rest, loop.index, sub(load(lost, loop.index - 1), load(lost, loop.index)))


@dataclass(frozen=True)
class Joints:
    """The couples of springs and dampers at order n, linear in coefficients that are known."""

    builder: Builder
    scene: Scene
    layout: Layout
    held: ArrayRef
    sums: ArrayRef
    coefficient: ArrayRef
    right: ArrayRef
    first: Expr
    rubs: Rubs
    rub_sums: ArrayRef

    def couples(self) -> ArrayRef | None:
        """n_k, three cells a link, or None; writes the right rows of dampers."""
        if not ties_links(self.scene):
            return None
        builder, links = self.builder, self.scene.links
        force = self._springs() if "spring" in self.layout else None
        drag = None
        if self.scene.friction is not None:
            drag = self._rubbed()
        elif "damper" in self.layout:
            drag = self._dampers()
        couple = builder.array("couple", 3 * links)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            parts = [sub(load(force, k), load(force, k + 1))] if force is not None else []
            parts += [load(drag, k)] if drag is not None else []
            store(couple, k, parts[0] if len(parts) == 1 else add(*parts))
        return couple

    def _springs(self) -> ArrayRef:
        """rho^2 k_k (q_{k-1} - q_k), q_{-1} = e_3, to the digits that rounded vectors do not hold; zero beyond the tip."""
        builder, links, nothing = self.builder, self.scene.links, self.builder.lift(0)
        stiffness, q = self.layout.of(self.held, "spring"), directions(self.scene, self.coefficient)
        force = builder.array("spring_force", 3 * links + 3)
        upright = self.first * self.layout.of(self.held, "upright")[0] if "upright" in self.layout else self.first
        rest = self.layout.of(self.held, "rest")

        def pulled(k: Index, apart: Vector) -> Vector:
            return scale(stiffness[k], add(apart, scale(self.first, load(rest, k))))

        store(force, 0, pulled(0, sub((nothing, nothing, upright), load(q, 0))))
        with builder.loop("k", 1, links) as loop:
            k = loop.index
            store(force, k, pulled(k, sub(load(q, k - 1), load(q, k))))
        store(force, links, (nothing, nothing, nothing))
        return force

    def _dampers(self) -> ArrayRef:
        """-(d_k + d_{k+1}) v_k - q_k x Omega_k."""
        builder, links, nothing = self.builder, self.scene.links, self.builder.lift(0)
        damping, start = self.layout.of(self.held, "damper"), self.layout.of(self.held, "direction")
        rate, spin = directions(self.scene, self.coefficient.shifted(self.scene.nq)), self._spins()
        beyond = builder.array("damping_beyond", links)
        with builder.loop("k", 1, links) as loop:
            beyond[loop.index - 1] = damping[loop.index]
        beyond[links - 1] = nothing
        drag = builder.array("drag", 3 * links)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            neighbours = add(scale(damping[k], load(spin, k)), scale(beyond[k], load(spin, k + 2)))
            self._keep_turned(3, k, neighbours)
            turned = add(cross(load(start, k), neighbours), self._crossed(3, k))
            store(drag, k, sub(scale(-(damping[k] + beyond[k]), load(rate, k)), turned))
        return drag

    def _spins(self) -> ArrayRef:
        """omega, of link k - 1 at k: zeros below the base and beyond the tip."""
        builder, links, nothing = self.builder, self.scene.links, self.builder.lift(0)
        start = self.layout.of(self.held, "direction")
        rate = directions(self.scene, self.coefficient.shifted(self.scene.nq))
        spin = builder.array("spin", 3 * links + 6)
        store(spin, 0, (nothing, nothing, nothing))
        store(spin, links + 1, (nothing, nothing, nothing))
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            v = load(rate, k)
            self._keep_turned(1, k, v)
            store(spin, k + 1, add(cross(load(start, k), v), self._crossed(1, k)))
        return spin

    def _rubbed(self) -> ArrayRef:
        """-q_k x N_k of dampers and dry friction."""
        builder, links, nothing = self.builder, self.scene.links, self.builder.lift(0)
        start, spin = self.layout.of(self.held, "direction"), self._spins()
        moment, drag = builder.array("moment", 3 * links + 3), builder.array("drag", 3 * links)
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            slip = sub(load(spin, k + 1), load(spin, k))
            resisted = self.rubs.resisted(k, slip, self.rub_sums, self.first)
            if "damper" in self.layout:
                resisted = add(resisted, scale(self.layout.of(self.held, "damper")[k], slip))
            store(moment, k, resisted)
        store(moment, links, (nothing, nothing, nothing))
        with builder.loop("k", 0, links) as loop:
            k = loop.index
            net = sub(load(moment, k), load(moment, k + 1))
            self._keep_turned(3, k, net)
            store(drag, k, add(cross(load(start, k), net), self._crossed(3, k)))
        return drag

    def _keep_turned(self, row: int, k: Index, value: Vector) -> None:
        """A vector's right rows: its axes turned by one, and by two."""
        lanes, (x, y, z) = 3 * self.scene.links, value
        store(self.right.shifted(row * lanes), k, (y, z, x))
        store(self.right.shifted((row + 1) * lanes), k, (z, x, y))

    def _crossed(self, row: int, k: Index) -> Vector:
        """The known part of q x the vector of these rows."""
        lanes = 3 * self.scene.links
        ahead, behind = load(self.sums.shifted(row * lanes), k), load(self.sums.shifted((row + 1) * lanes), k)
        return tuple(ahead[(i + 1) % 3] - behind[(i + 2) % 3] for i in range(3))
