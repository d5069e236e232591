"""One link of either side eliminated, and the turn into the next link's frame: the same formula beyond and before where sides meet.

What the links between the base and a joint are to those beyond it is a mobility W and an acceleration a0 (`scalars`). With x
and y exchanged,

    P = lambda^2 W,   c = lambda a0,   E = det P,   k = adj(P) c

obey the recurrences of the inertia A, the force b, E = det A and k = adj(A) b beyond (`articulated`), but for two things: the
couple on a link and its rate squared change places, and c and k change sign from link to link. T is the couple and O the rate
squared beyond, T the rate squared and O the couple before; (p, q) = (1, lambda - 1) beyond, (lambda - 1, 1) before. Then for both

    D = 1 + A_yy,   A'_xx = lambda^2 + p^2 (A_xx + E) / D,   A'_xy = -p q A_xy / D,   A'_yy = q^2 A_yy / D
    E' = q^2 (lambda^2 A_yy + p^2 E) / D,   free = (T - b_y + O A_xy) / D
    b'_x = p (b_x + k_x + T A_xy) / D - O (lambda + p (A_xx + E) / D),   b'_y = p T + q free
    k'_x = lambda q (p q k_x / lambda + p T A_xy - O q (A_yy + p E / lambda)) / D
    k'_y = lambda^2 b'_y + lambda p (p (T (A_xx + p E / lambda) - q k_y / lambda) - O q A_xy) / D

with p q = lambda - 1. Carried are E / lambda and k / lambda. The inertia is handed on as it was before the division, with 1 / D beside it: turned into
the next frame it is a square of the turn's sine and cosine plus 1 / D times what does not wait for D, so that one pivot waits for
the one before through a division and a multiply-add. Both parts of a diagonal entry are positive, and nothing cancels between them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.lowering.planar.both_ends.numbers import Numbers


@dataclass(frozen=True)
class Seen:
    """The chain at a joint, in the frame and units of the link that is next: inertia A, E / lambda, force b, k / lambda, and D."""

    xx: Expr
    xy: Expr
    yy: Expr
    pivot: Expr
    determinant: Expr
    force_x: Expr
    force_y: Expr
    minor_x: Expr
    minor_y: Expr


@dataclass(frozen=True)
class Left:
    """What a link leaves for the next one, in its own frame: A before the division and 1 / D, in its own units; the others in the next's."""

    axial: Expr
    skew: Expr
    across: Expr
    inverse: Expr
    determinant: Expr
    force_x: Expr
    force_y: Expr
    minor_x: Expr
    minor_y: Expr


@dataclass(frozen=True)
class Kept:
    """What the way back takes from a link's elimination: 1 / D, free, A_xy / D, b_x + k_x + T A_xy, T - b_y, A_xx + E and A_yy."""

    inverse: Expr
    free: Expr
    gain: Expr
    pull: Expr
    push: Expr
    axial: Expr
    across: Expr


@dataclass(frozen=True)
class Cells:
    """What every link leaves and what is kept of it, row by row, the tip's side first."""

    left: dict[str, ArrayRef]
    kept: dict[str, ArrayRef]

    def write(self, cell: Index, left: Left, kept: Kept) -> None:
        """Those of a link; what the next link reads comes last, so that a compiler sees at once that nothing else reads it."""
        for values, arrays in ((kept, self.kept), (left, self.left)):
            for name, array in arrays.items():
                array[cell] = getattr(values, name)

    def __getitem__(self, cell: Index) -> Left:
        return Left(**{name: array[cell] for name, array in self.left.items()})


def cells(builder: Builder, rows: int) -> Cells:
    """Room for so many rows."""
    left, kept = (
        {field.name: builder.array(f"{name}_{field.name}", 2 * rows) for field in fields(kind)}
        for name, kind in (("left", Left), ("row", Kept))
    )
    return Cells(left, kept)


def nothing(builder: Builder) -> Seen:
    """Beyond the tip."""
    zero = builder.lift(0)
    return Seen(**{field.name: zero for field in fields(Seen)} | {"pivot": builder.lift(1)})


def turned(builder: Builder, left: Left, numbers: Numbers, sine: Expr, cosine: Expr) -> Seen:
    """What a link left in the frame of the next one; `numbers` are those of the link that left it."""
    let = builder.let
    axial, skew, across = numbers.inner_squared * left.axial, numbers.overhang * left.skew, numbers.outer_squared * left.across
    share = numbers.mass * left.inverse
    shear = let("shear", sine * (axial - across) - cosine * (skew + skew))
    lean = let("lean", sine * shear)
    along = numbers.own * cosine
    lifted = let("lifted", sine * (numbers.own * sine))
    rest = share * (across + lean)
    return Seen(
        xx=let("seen_xx", along * cosine + share * (axial - lean)),
        xy=let("seen_xy", along * sine + share * (cosine * shear + skew)),
        yy=let("seen_yy", lifted + rest),
        pivot=(1 + lifted) + rest,
        determinant=left.determinant,
        force_x=let("seen_force_x", cosine * left.force_x - sine * left.force_y),
        force_y=let("seen_force_y", sine * left.force_x + cosine * left.force_y),
        minor_x=let("seen_minor_x", cosine * left.minor_x - sine * left.minor_y),
        minor_y=let("seen_minor_y", sine * left.minor_x + cosine * left.minor_y),
    )


def eliminated(builder: Builder, seen: Seen, numbers: Numbers, drive: Expr, spin: Expr) -> tuple[Left, Kept]:
    """Link and all that was seen from it, `drive` and `spin` its T and O."""
    let = builder.let
    inverse = let("inverse_pivot", 1 / seen.pivot)
    push = let("push", drive - seen.force_y)
    swing, driven = let("swing", spin * seen.xy), let("driven", drive * seen.xy)
    free = let("free", (push + swing) * inverse)
    axial = let("axial", seen.xx + numbers.leverage * seen.determinant)
    pull = let("pull", seen.force_x + numbers.leverage * seen.minor_x + driven)
    share = numbers.inner * inverse
    force_y = let("left_force_y", numbers.force * (numbers.inner * drive + numbers.outer * free))
    own = numbers.inner * seen.determinant
    determinant = numbers.leverage * seen.yy + numbers.inner * own
    minor_x = numbers.overhang * seen.minor_x + numbers.inner * driven - spin * (numbers.outer * (seen.yy + own))
    minor_y = numbers.inner * (drive * (seen.xx + own) - numbers.outer * seen.minor_y) - numbers.outer * swing
    left = Left(
        axial=axial, skew=seen.xy, across=seen.yy, inverse=inverse,
        determinant=let("left_determinant", numbers.determinant * (determinant * inverse)),
        force_x=let("left_force_x", numbers.force * (pull * share - spin * (numbers.leverage + axial * share))),
        force_y=force_y,
        minor_x=let("left_minor_x", numbers.minor_outer * (minor_x * inverse)),
        minor_y=let("left_minor_y", numbers.lift * force_y + numbers.minor_inner * (minor_y * inverse)),
    )  # fmt: skip
    return left, Kept(inverse, free, let("gain", seen.xy * inverse), pull, push, axial, seen.yy)
