"""The system of `link_multipliers` where masses sit anywhere on their links: a sweep in from the tip, one out from the base.

The chain beyond a joint asks for the force A a + b, a the joint's acceleration less gravity. For a link with mass m at r, couple s,
mu = m r^2, D = mu + l^2 A, W = D^-1 (m r + l A), kappa = m (l - r)^2, gamma = m r (l - r), and n its normal (rigid links have their
moments in the place of m r and m r^2, and W as it stands: their gamma may be negative),

    y = D^-1 q,  z = D^-1 (s - l b),  p = W q,  p* = W^T n,  f = n.y,  e = (along - n.z) / f
    q'' = z + e y + (y p*^T / f - W) a
    A' = B + p p*^T / f,   B = kappa A D^-1,        b' = W s - gamma D^-1 b + e p,        W = (I + gamma D^-1) / l

*Proof.* The link's row is m r (a + r q'') + l (A (a + l q'') + b) = s + lambda q, or D q'' = s - l b + lambda q - (m r + l A) a; n.q''
= along gives lambda = e + p*.a / f. The force at its base is m (a + r q'') + A (a + l q'') + b, and matrices that are polynomials of
A commute: m + A - (m r + l A) W = kappa A D^-1, I - l W = -gamma D^-1.

A heavy chain beyond makes A nearly singular beside its largest entry, so its adjugate K and determinant E are carried, too:

    adj D = mu^2 + mu l^2 (tr A - A) + l^4 K,   A adj D = mu^2 A + mu l^2 (tr K - K) + l^4 E,
    det D = mu^3 + mu^2 l^2 tr A + mu l^4 tr K + l^6 E,   adj B = kappa^2 (mu K + l^2 E) / det D,   det B = kappa^3 E / det D,
    K' = adj B - hat(p*) B^T hat(p) / f,   E' = det B + p*.adj(B) p / f

(Cayley-Hamilton: tr(A) A - A^2 = tr(K) - K); in the plane adj D = mu + l^2 K, A adj D = mu A + l^2 E, det D = mu^2 + mu l^2 tr A + l^4 E,
adj B = kappa (mu K + l^2 E) / det D, det B = kappa^2 E / det D. Nothing is subtracted that grows with the chain.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.algebra.matrix import (
    Matrix,
    adjugate,
    applied,
    combined,
    complement,
    flat,
    hat,
    outer,
    plus,
    product,
    trace,
    transposed,
)
from phichain.lowering.algebra.vector import Vector, add, dot, load, multiple, named, store, sub, zeros
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.steps.link_multipliers import Links


@dataclass(frozen=True)
class Inertia:
    """A matrix, its adjugate and its determinant."""

    matrix: Matrix
    adjugate: Matrix
    determinant: Expr

    @property
    def entries(self) -> list[Expr]:
        """All numbers that have to be carried; in the plane the adjugate is the matrix in another order."""
        minors = flat(self.adjugate) if len(self.matrix) == 3 else []
        return [*flat(self.matrix), *minors, self.determinant]

    @classmethod
    def carried(cls, loop: Loop, size: int) -> Inertia:
        """That of nothing beyond the tip, to be followed inwards."""

        def square(name: str) -> Matrix:
            axes = "xyz"[:size]
            return tuple(tuple(loop.carry(f"{name}_{row}{column}", 0) for column in axes) for row in axes)

        matrix = square("inertia")
        minors = square("minor") if size == 3 else adjugate(matrix)
        return cls(matrix, minors, loop.carry("determinant", 0))


def sweep(links: Links) -> None:
    """Accelerations of a chain with masses anywhere on its links."""
    builder, count, size = links.builder, links.scene.links, links.size
    constant = builder.array("free_acceleration", size * count)
    slope = builder.array("slope", size * size * count)
    with builder.loop("k", count - 1, -1, -1) as loop:
        k = loop.index
        inertia = Inertia.carried(loop, size)
        bias = tuple(loop.carry(f"bias_{row}", 0) for row in "xyz"[:size])
        link = Link(links, k, inertia, bias)
        store(constant, k, link.free)
        store(slope, k, tuple(flat(link.slope)))
        for before, after in zip(inertia.entries, link.inertia_at_base.entries, strict=True):
            loop.follow(before, after)
        for before, after in zip(bias, link.bias_at_base, strict=True):
            loop.follow(before, after)
    base = moved_base(links, inertia.matrix, bias, links.parameters.base_mass)
    with builder.loop("k", 0, count) as loop:
        k = loop.index
        joint = tuple(loop.carry(f"joint_{axis}", x) for axis, x in zip("xyz", base, strict=False))
        entries = load(slope, k, size * size)
        rows = tuple(entries[size * i : size * (i + 1)] for i in range(size))
        value = named(builder, "turning", add(load(constant, k, size), applied(rows, joint)))
        links.write(k, value)
        for before, after in zip(joint, add(joint, multiple(links.parameters.length[k], value)), strict=True):
            loop.follow(before, after)


class Link:
    """One link on its way in: what its own motion is, and what it asks of its base.

    Attributes:
        yielding: D^-1.
        turn: W.
        response: y.
        pull: p.
        seen: p* / f.
        over: 1 / f.
        lever: gamma.
        free: q'' in a joint that does not move.
        slope: what the joint's acceleration adds.
        inertia_at_base: A'.
        bias_at_base: b'.
    """

    def __init__(self, links: Links, k: Index, inertia: Inertia, bias: Vector) -> None:
        builder, parameters, size = links.builder, links.parameters, links.size
        length = parameters.length
        own, lever, overhang = _numbers(parameters)
        square = parameters.derived("length_squared", lambda k: length[k] * length[k])
        over_length = parameters.derived("over_length", lambda k: 1 / length[k])[k]
        joined = _joined(inertia, own[k], square[k])
        over_joined = builder.let("over_determinant", 1 / joined.determinant)
        yielding = tuple(
            named(builder, f"yield_{axis}", multiple(over_joined, row))
            for axis, row in zip("xyz", joined.adjugate, strict=False)
        )
        if parameters.bodies is None:
            turn = combined(over_length * lever[k], yielding, over_length)
        else:
            met = _met(inertia, own[k], square[k])
            turn = plus(combined(parameters.bodies.first[k], yielding, 0), combined(length[k] * over_joined, met, 0))
        turn = tuple(named(builder, f"turn_{axis}", row) for axis, row in zip("xyz", turn, strict=False))
        q, normal = links.at(links.q, k), links.at(links.normal, k)
        couple = zeros(builder, size) if links.couple is None else load(links.couple, k, size)
        response = named(builder, "response", applied(yielding, q))
        free = applied(yielding, sub(couple, multiple(length[k], bias)))
        pull = named(builder, "pull", applied(turn, q))
        seen = applied(transposed(turn), normal)
        over = builder.let("over_response", 1 / dot(normal, response))
        self.yielding, self.turn, self.response, self.pull, self.over = yielding, turn, response, pull, over
        excess = builder.let("excess", (links.along[k] - dot(normal, free)) * over)
        self.seen = seen = named(builder, "seen", multiple(over, seen))
        self.free = add(free, multiple(excess, response))
        self.slope = tuple(sub(row, other) for row, other in zip(outer(response, seen), turn, strict=True))
        bent = _bent(inertia, own[k], square[k], overhang[k], over_joined)
        self.inertia_at_base = _added(builder, bent, pull, seen)
        self.lever = lever[k]
        carried = sub(applied(turn, couple), multiple(lever[k], applied(yielding, bias)))
        self.bias_at_base = add(carried, multiple(excess, pull))


def _numbers(parameters: Parameters) -> tuple[ArrayRef, ArrayRef, ArrayRef]:
    """mu, gamma and kappa of every link."""
    mass, length, com, bodies = parameters.mass, parameters.length, parameters.com, parameters.bodies
    if bodies is not None:
        return bodies.second, bodies.lever, bodies.beyond
    own = parameters.derived("own_inertia", lambda k: mass[k] * com[k] * com[k])
    lever = parameters.derived("lever", lambda k: mass[k] * com[k] * (length[k] - com[k]))
    overhang = parameters.derived("overhang", lambda k: mass[k] * (length[k] - com[k]) * (length[k] - com[k]))
    return own, lever, overhang


def _met(inertia: Inertia, own: Expr, square: Expr) -> Matrix:
    """A adj D."""
    matrix, minors, determinant = inertia.matrix, inertia.adjugate, inertia.determinant
    if len(matrix) == 2:
        return combined(own, matrix, square * determinant)
    return plus(
        combined(own * own, matrix, square * square * determinant), combined(own * square, complement(minors), 0)
    )


def _joined(inertia: Inertia, own: Expr, square: Expr) -> Inertia:
    """D = mu + l^2 A with its adjugate and determinant."""
    matrix, minors, determinant = inertia.matrix, inertia.adjugate, inertia.determinant
    whole = combined(square, matrix, own)
    if len(matrix) == 2:
        product_ = own * (own + square * trace(matrix)) + square * square * determinant
        return Inertia(whole, combined(square, minors, own), product_)
    spread = own * (own + square * trace(matrix))
    cofactors = plus(
        combined(own * square, complement(matrix), own * own), combined(square * square, minors, 0)
    )
    product_ = own * spread + square * square * (own * trace(minors) + square * determinant)
    return Inertia(whole, cofactors, product_)


def _bent(inertia: Inertia, own: Expr, square: Expr, overhang: Expr, over_joined: Expr) -> Inertia:
    """B = kappa A D^-1 with its adjugate and determinant."""
    matrix, minors, determinant = inertia.matrix, inertia.adjugate, inertia.determinant
    lean = overhang * over_joined
    minor = combined(own, minors, square * determinant)
    if len(matrix) == 2:
        times = _met(inertia, own, square)
        return Inertia(combined(lean, times, 0), combined(lean, minor, 0), overhang * lean * determinant)
    return Inertia(
        combined(lean, _met(inertia, own, square), 0),
        combined(overhang * lean, minor, 0),
        overhang * overhang * lean * determinant,
    )


def _added(builder: Builder, bent: Inertia, pull: Vector, seen: Vector) -> Inertia:
    """B + p p*^T / f, with its adjugate and determinant; seen = p* / f."""
    matrix = plus(bent.matrix, outer(pull, seen))
    determinant = bent.determinant + dot(seen, applied(bent.adjugate, pull))
    if len(matrix) == 2:
        return Inertia(matrix, adjugate(matrix), determinant)
    crossed = product(product(hat(builder, seen), transposed(bent.matrix)), hat(builder, pull))
    return Inertia(matrix, plus(bent.adjugate, combined(-1, crossed, 0)), determinant)


def moved_base(links: Links, inertia: Matrix, bias: Vector, mass: Expr) -> Vector:
    """Acceleration of joint 0 less gravity, on a cart of a mass if there is one; writes that of the cart."""
    builder, parameters, size = links.builder, links.parameters, links.size
    rise = tuple(-entry for entry in parameters.fall)
    if not links.scene.has_cart:
        return rise
    asked = add(bias, applied(inertia, rise))[:-1]
    force = multiple(-1, asked) if links.push is None else sub(links.push, asked)
    horizontal = tuple(row[:-1] for row in inertia[:-1])
    pivot = combined(1, horizontal, mass)
    over = 1 / (pivot[0][0] if size == 2 else dot(pivot[0], transposed(adjugate(pivot))[0]))
    cart = named(builder, "cart", multiple(over, applied(adjugate(pivot), force)))
    for i, entry in enumerate(cart):
        links.out[i] = entry
    return (*cart, rise[-1])
