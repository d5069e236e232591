"""A Program compiled once to Python over the field, with derivatives along up to two directions beside every value.

    level 0: x          level 1: x + x_a a, a^2 = 0          level 2: x + x_a a + x_b b + x_m a b, a^2 = b^2 = 0

Products are reduced modulo the prime, sums when they are multiplied or returned. Cells are entries of a dictionary: an index below
zero does not wrap, and a cell or local value that nobody wrote is an error, as is a division by zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

from phichain.ir.inline import inline
from phichain.ir.nodes import Program
from phichain.proof.modular.circles import angles_of
from phichain.proof.modular.field import PRIME, inverse
from phichain.proof.modular.parts import MARKS
from phichain.proof.modular.written import Python

Circle = tuple[int, int]

FAULTS: Final = (KeyError, IndexError, NameError, ArithmeticError)
"""What running a Program that makes no sense raises."""


@dataclass(frozen=True)
class Given:
    """The arguments of one run.

    Attributes:
        values: flat values of every argument, by name.
        circles: the points (cosine, sine) of the arguments that hold angles.
        along: derivatives of the arguments along the first direction; zero where not given.
        across: the same along the second one.
        mixed: and along both.
    """

    values: Mapping[str, Sequence[int]]
    circles: Mapping[str, Sequence[Circle]] = field(default_factory=dict)
    along: Mapping[str, Sequence[int]] = field(default_factory=dict)
    across: Mapping[str, Sequence[int]] = field(default_factory=dict)
    mixed: Mapping[str, Sequence[int]] = field(default_factory=dict)


class Functions(Protocol):
    """The functions that are no rational ones, by what they obey: the same element for the same argument."""

    def bessel(self, x: int) -> Mapping[int, int]:
        """J_n(x) by n."""

    def atom(self, x: int) -> Circle:
        """A point of the circle for the sine and cosine of what is no sum of angles."""

    def root(self, x: int) -> int:
        """The square root of x."""

    def tanh(self, x: int) -> int:
        """tanh(x), an odd function."""

    def log_cosh(self, x: int) -> int:
        """ln cosh(x), an even one."""


@dataclass(frozen=True)
class Compiled:
    """A Program as Python.

    Attributes:
        source: its text.
        run: the function made of it.
    """

    source: str
    run: Callable[..., dict[str, tuple[list[int], ...]]]

    def __call__(self, given: Given, functions: Functions | None = None) -> dict[str, tuple[list[int], ...]]:
        """Every output by name: its values, then its derivatives `along`, `across` and `mixed` as far as they were compiled.

        Raises:
            KeyError, IndexError, NameError, ArithmeticError: it reads what nobody wrote, writes where nothing is, or divides by
                zero.
        """
        return self.run(given, functions)


def compiled(program: Program, level: int = 0) -> Compiled:
    """Compile a Program; what it calls is run as a function of its own, and inlined where derivatives are wanted.

    Args:
        program: what to compile.
        level: 0 for values, 1 for derivatives along one direction, 2 along two.
    """
    program = inline(program) if program.callees and level else program
    text = Python(program, MARKS[: (1, 2, 4)[level]], angles_of(program)).text()
    names: dict[str, Any] = {"inverse": inverse, "checked": _checked, "flat": _flat, "Given": Given}
    names["callees"] = {name: compiled(callee) for name, callee in program.callees.items()}
    exec(compile(text, f"<{program.name}>", "exec"), names)  # noqa: S102  the text is written above, of integers and names alone
    return Compiled(text, names["run"])


def _flat(array: dict[int, int], size: int) -> list[int]:
    """The cells of an array, every one of them written."""
    return [array[i] % PRIME for i in range(size)]


def _checked(array: dict[int, int], size: int, name: str) -> None:
    """Refuse writing beyond an array."""
    if array and not (min(array) >= 0 and max(array) < size):
        raise IndexError(f"a cell beyond {name}")

