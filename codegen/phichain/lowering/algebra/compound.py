"""A 3 x 3 matrix that carries its adjugate and determinant along, so that nothing formed from them cancels.

The sweeps of `planar.implicit` shift such a matrix, add a mass to it and eliminate its last row and column. What is left then,
A - u w^T / d, would be a difference of large numbers where masses differ by many orders of magnitude; its numerator is an
entry of the adjugate, which is carried instead. Entries that are structurally zero cost nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from phichain.ir.builder import Builder, Expr
from phichain.lowering.algebra.matrix import Matrix, flat, from_flat, zero


@dataclass(frozen=True)
class Compound:
    """Lambda with K = adj(Lambda), Lambda K = det I. Rows and columns: along the link, along its tangent, its angle."""

    matrix: Matrix
    adjugate: Matrix
    determinant: Expr

    @classmethod
    def zero(cls, builder: Builder) -> Compound:
        """What lies beyond the tip."""
        return cls(zero(builder), zero(builder), builder.lift(0))

    def flat(self) -> list[Expr]:
        """All entries: matrix, adjugate, determinant."""
        return [*flat(self.matrix), *flat(self.adjugate), self.determinant]

    @classmethod
    def from_flat(cls, values: Sequence[Expr]) -> Compound:
        """The inverse of `flat`."""
        return cls(from_flat(values[:9]), from_flat(values[9:18]), values[18])

    def shifted(self, arm: Expr, column: tuple[Expr, Expr]) -> Compound:
        """L Lambda R with L = [I 0; arm e_y^T 1] and R = [I arm n; 0 1]; both have determinant 1."""
        matrix, adjugate = _copy(self.matrix), _copy(self.adjugate)
        for j in range(3):
            matrix[2][j] = matrix[2][j] + arm * matrix[1][j]
        for i in range(3):
            matrix[i][2] = matrix[i][2] + arm * (column[0] * matrix[i][0] + column[1] * matrix[i][1])
        for j in range(3):
            for i in range(2):
                adjugate[i][j] = adjugate[i][j] - arm * (column[i] * adjugate[2][j])
        for i in range(3):
            adjugate[i][1] = adjugate[i][1] - arm * adjugate[i][2]
        return Compound(_rows(matrix), _rows(adjugate), self.determinant)

    def with_mass(self, mass: Expr) -> Compound:
        """Lambda + mass diag(1, 1, 0)."""
        matrix, adjugate = _copy(self.matrix), _copy(self.adjugate)
        inertia = mass * self.matrix[2][2]
        trace = self.matrix[0][0] + self.matrix[1][1]
        for i in range(2):
            matrix[i][i] = matrix[i][i] + mass
            adjugate[i][i] = adjugate[i][i] + inertia
            adjugate[i][2] = adjugate[i][2] - mass * self.matrix[i][2]
            adjugate[2][i] = adjugate[2][i] - mass * self.matrix[2][i]
        adjugate[2][2] = adjugate[2][2] + mass * (trace + mass)
        determinant = self.determinant + mass * (self.adjugate[0][0] + self.adjugate[1][1] + inertia)
        return Compound(_rows(matrix), _rows(adjugate), determinant)

    def stiffened(self, stiffness: Expr) -> Compound:
        """Lambda + stiffness e_3 e_3^T."""
        matrix, adjugate = _copy(self.matrix), _copy(self.adjugate)
        matrix[2][2] = matrix[2][2] + stiffness
        for i in range(2):
            for j in range(2):
                if i == j:
                    adjugate[i][i] = adjugate[i][i] + stiffness * self.matrix[1 - i][1 - i]
                else:
                    adjugate[i][j] = adjugate[i][j] - stiffness * self.matrix[i][j]
        return Compound(_rows(matrix), _rows(adjugate), self.determinant + stiffness * self.adjugate[2][2])

    def released(self, joint: Expr, inverse: Expr) -> Compound:
        """Behind a joint of the given stiffness in series: (Lambda^-1 + e_3 e_3^T / joint)^-1.

        `inverse` is 1 / (Lambda_33 + joint). A free joint (structurally zero stiffness) transmits no moment.
        """
        full, adjugate = self.matrix, self.adjugate
        share = joint * inverse
        nothing = joint.builder.lift(0)
        matrix = [[nothing] * 3 for _ in range(3)]
        for i in range(2):
            for j in range(2):
                minor = adjugate[1 - i][1 - i] if i == j else -adjugate[i][j]
                matrix[i][j] = (minor + joint * full[i][j]) * inverse
            matrix[i][2], matrix[2][i] = share * full[i][2], share * full[2][i]
        matrix[2][2] = share * full[2][2]
        behind = [[share * entry for entry in row] for row in adjugate]
        behind[2][2] = (self.determinant + joint * adjugate[2][2]) * inverse
        return Compound(_rows(matrix), _rows(behind), share * self.determinant)

    def turned(self, sine: Expr, cosine: Expr) -> Compound:
        """The same in the frame of the link before."""
        return Compound(
            _turned(self.matrix, sine, cosine), _turned(self.adjugate, sine, cosine), self.determinant
        )


def _copy(rows: Matrix) -> list[list[Expr]]:
    return [list(row) for row in rows]


def _rows(rows: list[list[Expr]]) -> Matrix:
    return tuple(map(tuple, rows))


def _turned(m: Matrix, sine: Expr, cosine: Expr) -> Matrix:
    shear = sine * (m[0][0] - m[1][1]) + cosine * (m[0][1] + m[1][0])
    lean, slope = sine * shear, cosine * shear
    return (
        (m[0][0] - lean, slope - m[1][0], cosine * m[0][2] - sine * m[1][2]),
        (slope - m[0][1], m[1][1] + lean, sine * m[0][2] + cosine * m[1][2]),
        (cosine * m[2][0] - sine * m[2][1], sine * m[2][0] + cosine * m[2][1], m[2][2]),
    )
