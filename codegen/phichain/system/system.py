"""System: the frozen record of callables and sizes that every numerical package takes.

`build` makes one from compiled code, a test makes one by hand from a few NumPy functions; `simulate`,
`continuation`, `control` and `fractional` cannot tell the difference and import nothing above this file.

The state of the numerics is ``x = (q, v)`` in one vector of length ``nq + nv``; callables are ``f(t, x, u, p)``.

* planar:  ``q = [x (cart only), theta_1 .. theta_N]``, ``v = q'``, ``nq = nv``; metres, radians, seconds.
* spatial: ``q = [x (2, cart only), q_1 .. q_N]`` (unit vectors, 3 each), ``v = [x' (2), omega_1 .. omega_N]`` with
  ``q_k' = omega_k x q_k`` and ``omega_k . q_k = 0``.

Every array may carry one leading batch axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from html import escape
from types import MappingProxyType
from typing import Any

import numpy as np

from phichain.contract.bases import law_of
from phichain.contract.chain import Sample
from phichain.contract.function import Absence
from phichain.contract.functions import ROWS
from phichain.errors import ArrayError, UnsupportedError
from phichain.records import frozen, thawed
from phichain.system.arrays import reals
from phichain.system.described import RUNTIME, Drive, Joints, Numbers, angles_of, drive_of

Parameters = Mapping[str, Any]


class AbsentFunctionError(UnsupportedError, AttributeError):
    """A function was asked of a System whose scene did not want it.

    It is an `AttributeError` too, so ``hasattr(system, "energy")`` answers instead of raising.
    """


@dataclass(frozen=True)
class System:
    """Sizes, names and callables of one chain.

    Attributes:
        name: Name of the scene.
        space: ``"planar"`` or ``"spatial"``.
        base: What carries it, a word of the contract's bases such as ``"fixed"`` or ``"cart"``.
        links: Number of links N.
        nq: Length of q.
        nv: Length of v.
        nu: Length of u; 0 means the callables take no u.
        real: ``"double"`` or ``"float"``, the type the callables compute in.
        functions: Contract name -> callable. Positional arguments in the order of the C signature, runtime
            parameters last as the keyword ``p``; one array or a tuple of arrays comes back. The entry ``casadi``,
            when there, is a casadi.Function of the forward dynamics (or a callable that makes it).
        q_names, v_names, u_names: Names of the entries of q, v and u.
        params: Default values of the runtime parameters, or None.
        angles: Planar: "relative" (unless said), "absolute" or "adjacent" (docs/theory.md, 2); None in space.
        numbers: Masses, lengths and what else the scene measures.
        joints: Springs and dampers; none unless said.
        drive: What the inputs push; the first nu entries of v unless said.
        variational: Whether its Taylor flow carries the variational equations along.
        varied: What beside the state it carries derivatives by, and how many numbers each is; none unless said.
        scene: The scene as a plain mapping, for the record.
        digest: The scene's canonical digest.

    Raises:
        ArrayError: angles or drive do not fit the chain.
    """

    name: str
    space: str
    base: str
    links: int
    nq: int
    nv: int
    nu: int
    real: str = "double"
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    q_names: tuple[str, ...] = ()
    v_names: tuple[str, ...] = ()
    u_names: tuple[str, ...] = ()
    params: Parameters | None = None
    angles: str | None = None
    numbers: Numbers = field(default_factory=Numbers)
    joints: Joints = field(default_factory=Joints)
    drive: Drive = field(default_factory=Drive)
    variational: bool = False
    varied: Mapping[str, int] = field(default_factory=dict)
    scene: Mapping[str, Any] = field(default_factory=dict)
    digest: str = ""

    def __post_init__(self) -> None:
        kept = {
            "functions": MappingProxyType(dict(self.functions)),
            "params": frozen(self.params),
            "angles": angles_of(self.angles, self.is_planar),
            "varied": MappingProxyType(dict(self.varied)),
            "drive": drive_of(self.drive, self.nu, self.nv),
            "scene": frozen(self.scene),
        }
        for name, value in kept.items():
            object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        functions = self.__dict__.get("functions", ())
        if name in functions:
            return functions[name]
        # Dunder look-ups (copy, pickle) come before `functions` exists and must fail the ordinary way.
        if name.startswith("_") or "functions" not in self.__dict__:
            raise AttributeError(name)
        return self.function(name)

    def __reduce__(self) -> tuple[Any, ...]:
        # A mapping proxy cannot be pickled, nor a compiled callable: what it was made from is, and makes it again.
        functions = {name: getattr(function, "made_by", function) for name, function in self.functions.items()}
        made = frozenset(name for name, function in self.functions.items() if hasattr(function, "made_by"))
        plain = {"functions": functions, "scene": thawed(self.scene), "params": thawed(self.params), "varied": dict(self.varied)}
        return _unpickled, (self.__dict__ | plain, made)

    def __copy__(self) -> System:
        return self

    def __deepcopy__(self, memo: object) -> System:
        # Frozen, its functions without state: there is nothing that a copy could keep apart.
        return self

    def __str__(self) -> str:
        wanted = ", ".join(self.functions) or "none"
        return (
            f"{self.name}: {self.space} chain of {self.links} link(s), {self.base} base, "
            f"nq={self.nq}, nv={self.nv}, nu={self.nu}, {self.real}; functions: {wanted}"
        )

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"

    @property
    def nx(self) -> int:
        """Length of the state x = (q, v)."""
        return self.nq + self.nv

    @property
    def is_planar(self) -> bool:
        """True for a chain in the vertical plane."""
        return self.space == "planar"

    @property
    def is_forced(self) -> bool:
        """True when its flow is driven by A cos(omega t), the scene's [forcing]."""
        return self.forcing[0] is not None

    @property
    def forcing(self) -> tuple[Any, int | None]:
        """What A cos(omega t) drives, and along which axis of a cart or base, as the scene's [forcing] says; None where nothing is said."""
        said = self.scene.get("forcing")
        return (None, None) if said is None else (said.get("forced"), said.get("axis"))

    @property
    def has_cart(self) -> bool:
        """True when the base is a cart."""
        return law_of(self.base).is_placed

    @property
    def is_moving(self) -> bool:
        """True when accelerations of the base are inputs, and it has no coordinates."""
        return law_of(self.base).is_told and not self.has_cart

    @property
    def rests(self) -> bool:
        """True when the base is a wall."""
        return law_of(self.base).rests

    @property
    def cart_size(self) -> int:
        """Number of cart coordinates at the head of q and of v: 0, 1 (planar) or 2 (spatial)."""
        if not self.has_cart:
            return 0
        return 1 if self.is_planar else 2

    def has(self, name: str) -> bool:
        """True when the callable `name` is there."""
        return name in self.functions

    def function(self, name: str) -> Callable[..., Any]:
        """The callable of that contract name.

        Raises:
            AbsentFunctionError: It is not among this system's functions.
        """
        if name in self.functions:
            return self.functions[name]
        problem = f"system '{self.name}' has no such function"
        remedy = f'add "{name}" to [functions] want of the scene and build it again'
        remedy += f" (it wants: {', '.join(self.functions) or 'nothing'})"
        reason = self._absence(name)
        if reason is not None:
            problem, remedy = f"{problem}, which {reason.problem}", reason.remedy
        raise AbsentFunctionError("function", name, problem, remedy, system=self.name, available=tuple(self.functions))

    def _absence(self, name: str) -> Absence | None:
        """Why no scene of this kind has a function, which nobody should be told to add."""
        if name not in ROWS or not self.digest:
            return None

        def given(value: object) -> str | None:
            return None if value is None else RUNTIME

        joints, numbers = self.joints, self.numbers
        kind = Sample(
            self.is_planar, damping=given(joints.damping), friction=given(joints.friction), rest_angle=given(joints.rest_angle),
            cart_damping=given(numbers.cart_damping), cart_friction=given(numbers.cart_friction), runtime=("",),
        )  # fmt: skip
        return ROWS[name].absence(kind)

    def number(self, name: str, p: Parameters | None = None, default: Any = None) -> Any:
        """A physical parameter: the number that the chain has, or its runtime value.

        Args:
            name: "mass", "length", "com", "inertia", "stiffness", "damping", "armature", "rest_angle" or "friction", per link;
                "cart_mass", "gravity", "cart_damping" or "cart_friction".
            p: Runtime values by name; those left out keep the system's defaults.
            default: What stands in where the chain has none; an error unless given.

        Returns:
            An array (N,), or one float.

        Raises:
            ArrayError: The chain has no such parameter, or no value of it was given.
        """
        value = getattr(self.joints if hasattr(self.joints, name) else self.numbers, name, None)
        if value == RUNTIME:
            value = self.parameters(p).get("p", {}).get(name)
        if value is None and default is not None:
            return default
        if value is None:
            raise ArrayError(
                f"p.{name}", None, f"system '{self.name}' holds no value of it", f"pass p={{'{name}': ...}}"
            )
        given = reals(f"p.{name}", value, "give real numbers")
        return float(given) if name == "gravity" or name.startswith("cart_") else np.broadcast_to(given, (self.links,))

    def parameters(self, p: Parameters | None = None) -> dict[str, Any]:
        """Keyword arguments that carry the runtime parameters: ``{}`` or ``{"p": values}``.

        Args:
            p: Values by name; those left out keep the system's defaults.

        Raises:
            ArrayError: p is no mapping.
        """
        if p is not None and not isinstance(p, Mapping):
            raise ArrayError("p", p, "does not hold parameters by name", 'give a mapping, such as {"gravity": 9.81}')
        if p is None and self.params is None:
            return {}
        return {"p": {**(self.params or {}), **(p or {})}}

    def values(self, p: Parameters | None = None) -> dict[str, Any]:
        """The runtime parameters as results keep them, numbers and lists of numbers by name; arguments as `parameters`."""
        return {name: reals(f"p.{name}", value, "give real numbers").tolist() for name, value in self.parameters(p).get("p", {}).items()}


def given_system(value: object) -> System:
    """Return a system that a caller handed over, or say what must be done to what is none.

    Raises:
        ArrayError: It is no `System`, such as a scene that nobody built.
    """
    if isinstance(value, System):
        return value
    what = "is a Scene, of which nothing is compiled yet" if type(value).__name__ == "Scene" else "is no System"
    raise ArrayError("system", value, what, "hand over what build(scene) returns")


def _unpickled(fields: dict[str, Any], made: frozenset[str]) -> System:
    """The System whose fields these are, with those of its functions made that are given by what makes them."""
    functions = {name: held() if name in made else held for name, held in fields["functions"].items()}
    return System(**{**fields, "functions": functions})
