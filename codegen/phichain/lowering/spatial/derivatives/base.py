"""What a spatial chain's base does to the derivatives of its accelerations, where joints' accelerations carry it (`mobilities`).

A base that is given its acceleration, and a cart that is pushed, move joint 0, and that goes outwards as everything does; a cart answers the force
F of every column by -Y F.
"""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.algebra.matrix import Matrix, load_matrix, product, scaled
from phichain.lowering.algebra.vector import dot, load, scale
from phichain.lowering.chain.base import Carried
from phichain.lowering.chain.losses import brakes_cart, cart_slopes
from phichain.lowering.spatial.derivatives.blocks import Blocks
from phichain.lowering.spatial.derivatives.mobilities import Lanewise
from phichain.lowering.spatial.derivatives.passing import Recalled
from phichain.scene import Scene


class Moved:
    """Writes what a base does that is given its acceleration, or a cart that is pushed: its columns, and the rows of a cart."""

    def __init__(self, columns: Lanewise) -> None:
        self.columns, self.builder, self.passing = columns, columns.builder, columns.passing

    def cart(self) -> None:
        """Rows of a free cart: -Y phi of every column."""
        columns, cart = self.columns, self.columns.sweep.cart
        assert cart is not None
        length, links = columns.parameters.units.length, columns.links
        rows = tuple(scale(-length, row) for row in cart[:2])
        wide = 3 if columns.joints is not None else 1
        with self.builder.loop("c", 0, 3 * links) as loop:
            for r, row in enumerate(rows):
                columns.by_q.entry(r - 2, loop.index, dot(row, columns.forces[0].at(loop.index)))
        with self.builder.loop("c", 0, wide * links) as loop:
            for r, row in enumerate(rows):
                entry = dot(row, columns.forces[1].at(loop.index))
                if wide == 3:
                    columns.by_v.entry(r - 2, loop.index, entry)
                    continue
                for i, part in enumerate(load(columns.load, loop.index)):
                    columns.by_v.entry(r - 2, 3 * loop.index + i, entry * part)

    def by(self, moves: list[tuple[ArrayRef, int, int, Matrix]], axes: tuple[int, ...]) -> None:
        """Rows of links where the base accelerates.

        Args:
            moves: matrices of results, the row of their first link, their width, and how each of their first columns accelerates the base.
            axes: along which it does, counted from 0.
        """
        builder, one, nothing, size = self.builder, self.builder.lift(1), self.builder.lift(0), len(axes)
        start = [one if i == axis else nothing for i in range(3) for axis in axes]
        with builder.loop("k", 0, self.columns.links) as loop:
            k = loop.index
            carried = [loop.carry(f"moved_{'xyz'[i // size]}{'xyz'[axes[i % size]]}", entry) for i, entry in enumerate(start)]
            motion = tuple(tuple(carried[size * i : size * (i + 1)]) for i in range(3))
            rows = product(load_matrix(self.passing.outwards, k), motion)
            for array, first, width, pushed in moves:
                for r, row in enumerate(product(rows, pushed)):
                    for c, entry in enumerate(row):
                        array[(3 * k + r + first) * width + c] = entry
            for old, new in zip(carried, [entry for row in product(self.passing.passed(k), motion) for entry in row], strict=True):
                loop.follow(old, new)


def derivatives(
    builder: Builder, scene: Scene, base: Carried, sweep: Recalled, results: tuple[ArrayRef, ArrayRef, ArrayRef | None]
) -> None:
    """Write dadq, dadv and dadu of a chain whose sweep has run."""
    (dadq, dadv, dadu), carts, width = results, 2 * scene.has_cart, scene.nv
    columns = Lanewise(builder, scene, base, sweep, Blocks(dadq, carts, width), Blocks(dadv, carts, width))
    columns.write()
    moved, parameters, nothing, unit = Moved(columns), base.parameters, builder.lift(0), base.parameters.units
    braked = brakes_cart(scene)
    moves: list[tuple[ArrayRef, int, int, Matrix]] = []
    for target in (dadq, dadv) if carts else ():
        for row in range(2) if scene.is_driven else ():
            with builder.loop("i", carts, width) as loop:
                target[loop.index + row * width] = nothing
        for c in range(2) if target is dadq or not braked else ():
            with builder.loop("i", 0, width) as loop:
                target[loop.index * width + c] = nothing
    if sweep.cart is not None:
        moved.cart()
        mobility = tuple(row[1:3] for row in sweep.cart[:2])
        if braked:
            own, aside, other = cart_slopes(base.scene, parameters, sweep.rates.cart())
            slopes = (own, aside), (aside, other)
            pushed = scaled(-(1 / builder.lift(unit.length)), product(mobility, slopes))
            _head(dadv, width, scaled(unit.length, pushed))
            moves.append((dadv, carts, width, pushed))
        if dadu is not None:
            pushed = scaled(1 / builder.lift(unit.force), mobility)
            _head(dadu, scene.nu, scaled(unit.length, pushed))
            moves.append((dadu, carts, scene.nu, pushed))
    elif dadu is not None:
        size, one = len(scene.told_axes), builder.lift(1)
        pushed = tuple(tuple(one / unit.length if i == c else nothing for c in range(size)) for i in range(size))
        moves.append((dadu, carts, scene.nu, pushed))
        if carts:
            _head(dadu, scene.nu, ((one, nothing), (nothing, one)))
    if moves:
        moved.by(moves, scene.told_axes or (0, 1))


def _head(target: ArrayRef, width: int, rows: Matrix) -> None:
    """The cart's own rows and first columns."""
    for r, row in enumerate(rows):
        for c, entry in enumerate(row):
            target[r * width + c] = entry
