"""Truncated power series over the field, with derivatives along up to three directions, as an algebra that runs Programs.

A value is x(t) + x_a(t) a + x_b(t) b + x_c(t) c + x_m(t) a b where all other products of a, b and c vanish, each a list of coefficients.
What is an angle knows the point of the circle (cosine, sine) that it has at t = 0; from there c' = -s x' and s' = c x'. A tanh
begins with an element of its own, from which y' = (1 - y^2) x' leads on; of ln cosh only derivatives along b are asked, tanh times x_b,
and so of a root.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from phichain.ir.interpret import Algebra
from phichain.proof.modular.compiled import Circle
from phichain.proof.modular.field import PRIME, exact, inverse

Coefficients = list[int]

_PRODUCT = {
    "": (("", ""),),
    "a": (("", "a"), ("a", "")),
    "b": (("", "b"), ("b", "")),
    "c": (("", "c"), ("c", "")),
    "m": (("", "m"), ("m", ""), ("a", "b"), ("b", "a")),
}


@dataclass(frozen=True)
class Jet:
    """One value.

    Attributes:
        parts: coefficients by mark: "" itself, "a", "b" and "c" its derivatives, "m" that along a and b; what is zero is left out.
        circle: (cosine, sine) at t = 0 where it is an angle.
        whole: the number that it is, where it is an integer constant.
    """

    parts: Mapping[str, Coefficients]
    circle: Circle | None = None
    whole: int | None = None


@cache
def _product_of(size: int) -> Callable[[Sequence[int], Sequence[int]], Coefficients]:
    """The product of series with so many coefficients, written out: most of a proof's time goes here."""
    sums = (" + ".join(f"a[{j}] * b[{n - j}]" for j in range(n + 1)) for n in range(size))
    text = ", ".join(f"({entry}) % {PRIME}" for entry in sums)
    made: Callable[[Sequence[int], Sequence[int]], Coefficients] = eval(f"lambda a, b: [{text}]")
    return made


@dataclass(frozen=True)
class PowerSeries:
    """The algebra of series with so many coefficients.

    Attributes:
        size: coefficients of a series.
        tanh: the element that stands for tanh of another.
        root: the element that stands for the root of another.
    """

    size: int
    tanh: Callable[[int], int] | None = None
    root: Callable[[int], int] | None = None

    @property
    def algebra(self) -> Algebra:
        """What `ir.interpret.run` needs."""
        return Algebra(self.constant, self._apply)

    def constant(self, value: Fraction | int) -> Jet:
        """A number."""
        whole = int(value) if Fraction(value).denominator == 1 else None
        return Jet(
            {"": [exact(Fraction(value)), *[0] * (self.size - 1)]}, (1, 0) if not value else None, whole
        )

    @property
    def times(self) -> Callable[[Sequence[int], Sequence[int]], Coefficients]:
        """The product of two series."""
        return _product_of(self.size)

    def _apply(self, kind: str, args: Sequence[Jet], label: str) -> Jet:
        match kind:
            case "add" | "sub":
                return self._sum(args[0], args[1], 1 if kind == "add" else -1)
            case "neg":
                return self._sum(self.constant(0), args[0], -1)
            case "mul":
                return self._product(args[0], args[1])
            case "div":
                return self._product(args[0], self._reciprocal(args[1]))
            case "sin" | "cos":
                return self._turned(args[0], kind)
            case "lncosh":
                return self._braked(args[0])
            case "sqrt":
                return self._rooted(args[0])
        raise NotImplementedError(f"{kind} of power series")

    def _sum(self, a: Jet, b: Jet, sign: int) -> Jet:
        zeros = [0] * self.size
        parts = {
            mark: [
                (x + sign * y) % PRIME
                for x, y in zip(a.parts.get(mark, zeros), b.parts.get(mark, zeros), strict=True)
            ]
            for mark in _PRODUCT
            if mark in a.parts or mark in b.parts
        }
        if a.circle is None or b.circle is None:
            return Jet(parts)
        (c, s), (x, y) = a.circle, (b.circle[0], sign * b.circle[1])
        return Jet(parts, ((c * x - s * y) % PRIME, (s * x + c * y) % PRIME))

    def _product(self, a: Jet, b: Jet) -> Jet:
        parts: dict[str, Coefficients] = {}
        for mark, pairs in _PRODUCT.items():
            terms = [
                self.times(a.parts[one], b.parts[other])
                for one, other in pairs
                if one in a.parts and other in b.parts
            ]
            if terms:
                parts[mark] = [sum(entries) % PRIME for entries in zip(*terms, strict=True)]
        times, angle = (a.whole, b) if a.whole is not None else (b.whole, a)
        if times is None or angle.circle is None:
            return Jet(parts)
        circle = (1, 0)
        for _ in range(abs(times)):
            (c, s), (x, y) = circle, angle.circle
            circle = ((c * x - s * y) % PRIME, (s * x + c * y) % PRIME)
        return Jet(parts, circle if times > 0 else (circle[0], -circle[1] % PRIME))

    def _reciprocal(self, a: Jet) -> Jet:
        """1/x; derivatives are -x_a / x^2 and so on, and those of what divides a Lagrangian are zero."""
        if set(a.parts) != {""}:
            raise NotImplementedError("derivatives of a quotient of power series")
        first, found = inverse(a.parts[""][0]), Coefficients()
        for n in range(self.size):
            found.append((int(n == 0) - sum(found[j] * a.parts[""][n - j] for j in range(n))) * first % PRIME)
        return Jet({"": found})

    def _braked(self, x: Jet) -> Jet:
        """ln cosh x, of which nothing is known but its derivative along b."""
        if self.tanh is None or not set(x.parts) <= {"", "a", "b"}:
            raise NotImplementedError("ln cosh of power series but for its derivative along rates")
        base = x.parts.get("", [0] * self.size)
        saturation, steepness = [self.tanh(base[0])], list[int]()
        for n in range(1, self.size):
            steepness.append((int(n == 1) - sum(saturation[j] * saturation[n - 1 - j] for j in range(n))) % PRIME)
            saturation.append(inverse(n) * sum(j * base[j] * steepness[n - j] for j in range(1, n + 1)) % PRIME)
        return Jet({"b": self.times(saturation, x.parts["b"])} if "b" in x.parts else {})

    def _rooted(self, x: Jet) -> Jet:
        """The root of x, of which nothing is known but its derivative along b."""
        if self.root is None or "c" in x.parts:
            raise NotImplementedError("the root of a power series but for its derivative along rates")
        base = x.parts.get("", [0] * self.size)
        found = [self.root(base[0])]
        over = inverse(2 * found[0])
        for n in range(1, self.size):
            found.append((base[n] - sum(found[j] * found[n - j] for j in range(1, n))) * over % PRIME)
        if "b" not in x.parts:
            return Jet({"": found})
        slope = self.times(self._reciprocal(Jet({"": [2 * entry for entry in found]})).parts[""], x.parts["b"])
        return Jet({"": found, "b": slope})

    def _turned(self, x: Jet, kind: str) -> Jet:
        if x.circle is None:
            raise NotImplementedError(f"{kind} of what is no sum of angles")
        base, zeros = x.parts.get("", [0] * self.size), [0] * self.size
        cosine, sine = [x.circle[0]], [x.circle[1]]
        for n in range(1, self.size):
            over = inverse(n)
            cosine.append(-over * sum(j * base[j] * sine[n - j] for j in range(1, n + 1)) % PRIME)
            sine.append(over * sum(j * base[j] * cosine[n - j] for j in range(1, n + 1)) % PRIME)
        value, slope = (sine, cosine) if kind == "sin" else (cosine, [-entry for entry in sine])
        parts = {"": value} | {mark: self.times(slope, x.parts[mark]) for mark in "abc" if mark in x.parts}
        if "m" in x.parts or ("a" in x.parts and "b" in x.parts):
            bent = self.times(self.times(value, x.parts.get("a", zeros)), x.parts.get("b", zeros))
            parts["m"] = [
                (p - q) % PRIME for p, q in zip(self.times(slope, x.parts.get("m", zeros)), bent, strict=True)
            ]
        return Jet(parts)
