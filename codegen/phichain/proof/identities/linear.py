"""The linear equations (19) about the straight chain, against second variations of the Lagrangian.

The signs s_k are random elements of the field, and s_k^2 counts as 1: M, G and D are compared as polynomials that are linear in every
s_k, which says more than any number of tries with +1 and -1. The second variation of T, V and R at (cos phi_k, sin phi_k) = (s_k, 0), or
at q_k = s_k e_3, is linear in them but for c_kk s_k^2, which is mended.
"""

from __future__ import annotations

from collections.abc import Callable

from phichain.mechanics.coordinates import absolute_angles
from phichain.proof.case import Case, Wrong, proves
from phichain.proof.lagrange import BASE_RATE, triples
from phichain.proof.modular.field import PRIME, Vector, dot, inverse

Form = Callable[[Vector], int]


@proves("linearization")
def linearization(case: Case) -> None:
    """one^T M other, one^T G other, one^T D other and one^T B u along random vectors."""
    point, scene = case.point, case.scene
    s = point.free("s", scene.links)
    found = case.run(point.given(s=s))
    size = point.carts + scene.links * (1 if scene.is_planar else 2)
    other = point.free("other", size)
    for name, form in _forms(case, s, other).items():
        if name in found:
            matrix = found[name]
            column = [dot(matrix[i * size : (i + 1) * size], other) for i in range(size)]
            _rows(case, name, column, form, point.free("one", size))
    if scene.nu:
        rows = [dot(found["B"][i * scene.nu : (i + 1) * scene.nu], point.u) for i in range(size)]
        case.same("a row of B, B", rows, _pushed(case, s, size))


def _pushed(case: Case, s: Vector, size: int) -> Vector:
    """B u: forces where they act, and what of T couples links with a base that is given its acceleration."""
    point, scene, carts = case.point, case.scene, case.point.carts
    given, pushed = point.u[: scene.base_accelerations], [0] * size
    for u, i in zip(point.u[len(given) :], scene.driven, strict=True):
        pushed[i] = u
    straight = _Planar(case, s) if scene.is_planar else _Spatial(case, s)
    for i in range(size if given else 0):
        alone = [int(k == i) for k in range(size)]
        pushed[i] += given[i] if i < carts else -straight.coupling(alone, given)
    return pushed


def _rows(case: Case, name: str, column: Vector, form: Form, one: Vector) -> None:
    """Hold one^T column against a form; name the first row that shows a difference."""
    if (dot(column, one) - form(one)) % PRIME == 0:
        return
    for i, entry in enumerate(one):
        alone = [entry if k == i else 0 for k in range(len(one))]
        if (dot(column, alone) - form(alone)) % PRIME:
            raise Wrong(f"a row of {name}, {name}[{i}]")
    raise Wrong(name)


def _forms(case: Case, s: Vector, other: Vector) -> dict[str, Form]:
    """M, G and D as functions of `one`."""
    straight = _Planar(case, s) if case.scene.is_planar else _Spatial(case, s)
    told = case.point.carts if case.scene.is_driven else 0
    # x'' = u leaves the cart's own row, and nothing of T between it and the links.
    return {
        "M": lambda one: dot(one[:told], other[:told])
        + straight.inertia(*([*[0] * told, *vector[told:]] for vector in (one, other))),
        "G": lambda one: straight.stiffness(one, other),
        "D": lambda one: straight.damping(*([*[0] * told, *vector[told:]] for vector in (one, other))),
    }


def _of_base(case: Case, rate: str, given: Vector) -> dict[str, Vector]:
    """A motion of the base as a direction: of a cart's coordinates, or of what is none."""
    return {BASE_RATE: given} if case.scene.is_moving else {rate: [*given, *[0] * (case.scene.nq - len(given))]}


class _Planar:
    """Second variations about phi_k with cosine s_k and sine 0."""

    def __init__(self, case: Case, s: Vector) -> None:
        self._case, self._signs = case, s
        cosines: Vector = []
        for k, sign in enumerate(s):
            # The angle whose sum with those before it is phi_k.
            before = {"absolute": 1, "relative": s[k - 1], "adjacent": cosines[-1] if k else 1}[str(case.scene.angles)]
            cosines.append(sign * (inverse(before) if k else 1) % PRIME)
        self._circles = [*[(1, 0)] * case.point.carts, *((cosine, 0) for cosine in cosines)]

    def _second(self, name: str, at: str, one: Vector, other: Vector) -> int:
        """The mixed derivative of one of the energies along two vectors in an argument."""
        judge, still = self._case.judge, {"q": self._case.point.q, "v": [0] * self._case.scene.nv}
        parts = judge.evaluate(self._case.point, still, self._circles, along={at: one}, across={at: other})
        return parts[name][3][0]

    def inertia(self, one: Vector, other: Vector) -> int:
        """one^T M other."""
        carts, angles = self._case.point.carts, str(self._case.scene.angles)
        mended = sum(
            moment * (1 - s * s) % PRIME * (a % PRIME) % PRIME * b
            for moment, s, a, b in zip(
                self._case.chain.moments, self._signs, absolute_angles(angles, one[carts:]),
                absolute_angles(angles, other[carts:]), strict=True,
            )
        )  # fmt: skip
        return self._second("kinetic", "v", one, other) + mended

    def coupling(self, one: Vector, given: Vector) -> int:
        """What of T lies between rates of the links and a motion of the base."""
        judge, point, nv = self._case.judge, self._case.point, self._case.scene.nv
        still = {"q": point.q, "v": [0] * nv}
        parts = judge.evaluate(point, still, self._circles, along={"v": one}, across=_of_base(self._case, "v", given))
        return parts["kinetic"][3][0]

    def stiffness(self, one: Vector, other: Vector) -> int:
        """one^T G other."""
        return self._second("potential", "q", one, other)

    def damping(self, one: Vector, other: Vector) -> int:
        """one^T D other."""
        return self._second("dissipation", "v", one, other)


class _Spatial:
    """Second variations about q_k = s_k e_3, in the horizontal components of the links' rotations."""

    def __init__(self, case: Case, s: Vector) -> None:
        self._case, self._signs = case, s
        self._q = [*case.point.q[: case.point.carts], *(entry for sign in s for entry in (0, 0, sign))]

    def _turn(self, vector: Vector) -> tuple[Vector, Vector]:
        """Rotations as vectors of space, and what they do to the coordinates."""
        carts = self._case.point.carts
        turns = vector[:carts]
        for k in range(carts, len(vector), 2):
            turns = [*turns, *vector[k : k + 2], 0]
        return turns, [*vector[:carts], *triples(self._q, turns, carts)]

    def _evaluated(self, **directions: dict[str, Vector]) -> dict[str, tuple[list[int], ...]]:
        zero = [0] * self._case.scene.nq
        return self._case.judge.evaluate(self._case.point, {"q": self._q, "v": zero, "q_dot": zero}, None, **directions)

    def _aligned(self, one: Vector, other: Vector) -> Vector:
        """xi_k.eta_k of every link."""
        carts = self._case.point.carts
        return [dot(one[k : k + 2], other[k : k + 2]) for k in range(carts, len(one), 2)]

    def inertia(self, one: Vector, other: Vector) -> int:
        """one^T M other."""
        parts = self._evaluated(along={"q_dot": self._turn(one)[1]}, across={"q_dot": self._turn(other)[1]})
        mended = sum(
            moment * (1 - s * s) % PRIME * both
            for moment, s, both in zip(self._case.chain.moments, self._signs, self._aligned(one, other), strict=True)
        )
        return parts["kinetic"][3][0] + mended

    def coupling(self, one: Vector, given: Vector) -> int:
        """What of T lies between rates of the links and a motion of the base."""
        parts = self._evaluated(along={"q_dot": self._turn(one)[1]}, across=_of_base(self._case, "q_dot", given))
        return parts["kinetic"][3][0]

    def stiffness(self, one: Vector, other: Vector) -> int:
        """one^T G other: turned by xi and eta, q_k moves by -(xi_k.eta_k) q_k in second order."""
        carts = self._case.point.carts
        inward = [0] * carts
        for s, both in zip(self._signs, self._aligned(one, other), strict=True):
            inward += [0, 0, -both * s % PRIME]
        parts = self._evaluated(
            along={"q": self._turn(one)[1]}, across={"q": self._turn(other)[1]}, mixed={"q": inward}
        )
        return parts["potential"][3][0]

    def damping(self, one: Vector, other: Vector) -> int:
        """one^T D other."""
        directions = (dict(zip(("v", "q_dot"), self._turn(vector), strict=True)) for vector in (one, other))
        parts = self._evaluated(**dict(zip(("along", "across"), directions, strict=True)))
        return parts["dissipation"][3][0]
