"""The one way from Python into an emitted flow: arguments by name, checked, converted and handed over in the order of the C."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.contract.chain import Chain
from phichain.contract.flow import Flow
from phichain.contract.functions import ROWS
from phichain.contract.registry import Registry
from phichain.errors import ArrayError
from phichain.native.arrays import REAL, converted, flat_parameters
from phichain.native.flows.structs import RESULTS, handed, struct_type
from phichain.native.signature import Argument, Signature
from phichain.system.arrays import number, positive, whole
from phichain.system.propagation import OUTCOMES, Stop

_MOST_STEPS: Final = 2 ** (8 * ctypes.sizeof(ctypes.c_ulong)) - 1

Make = TypeVar("Make", bound=Callable[..., Callable[..., Any]])

CALLERS: Final[Registry[Callable[..., Callable[..., Any]]]] = Registry("phichain.native.flows", "callable")


def calls(name: str) -> Callable[[Make], Make]:
    """Register what makes the Python callable of a flow of the contract."""

    def register(make: Make) -> Make:
        CALLERS.add(name, make)
        return make

    return register


@dataclass(frozen=True)
class FlowCall:
    """An emitted flow that takes its arguments by the names of the contract.

    Attributes:
        name: The flow's name in the contract.
        sizes: nq, nv, nu and the number of links.
        kind: The type that C computes in.
        signature: The scene's runtime parameters, and names for messages.
        function: The foreign function.
        takes: Name and conversion of every argument, in the order of the C.
        carried: Makes the struct that goes on from call to call.
        event: Makes the struct that says where to stop.
    """

    name: str
    sizes: tuple[int, int, int, int]
    kind: np.dtype[Any]
    signature: Signature
    function: Any
    takes: tuple[tuple[str, Callable[[Any], Any]], ...]
    carried: Callable[..., Any]
    event: Callable[..., Any]

    def __call__(self, values: dict[str, Any], p: Mapping[str, Any] | None) -> Any:
        """Call C.

        Args:
            values: The arguments by name: numbers, arrays that C may change where it does, structs, None for NULL.
            p: The runtime parameters.

        Raises:
            ArrayError: A runtime parameter is missing, unknown, or has another shape.
        """
        for block in flat_parameters(self.signature, p, self.kind):
            values["p"] = block
        return self.function(*[convert(values[name]) for name, convert in self.takes])


def flow_call(name: str, chain: Chain, parameters: Sequence[Argument], function: Any) -> FlowCall:
    """Wrap a foreign function.

    Args:
        name: The flow's name in the contract.
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        function: The foreign function; its result type is set here.
    """
    flow = _row(name)
    function.restype = RESULTS[flow.returns]
    return FlowCall(
        name=name,
        sizes=(chain.nq, chain.nv, chain.nu, chain.links),
        kind=REAL[chain.real],
        signature=Signature(name, f"{chain.name}_{name}", (), (), tuple(parameters), bool(parameters)),
        function=function,
        takes=tuple((argument.name, handed(argument, chain)) for argument in flow.arguments_of(chain)),
        carried=struct_type(flow.carries, chain) if flow.carries else _none,
        event=struct_type(flow.event, chain) if flow.event else _none,
    )


def _row(name: str) -> Flow:
    flow = ROWS[name].flow
    assert flow is not None, name
    return flow


def _none(*_: Any, **__: Any) -> None:
    return None


def one_motion(
    call: FlowCall, q: ArrayLike, v: ArrayLike, u: ArrayLike | None, span: tuple[float, float], times: ArrayLike, flow: Any,
    max_steps: int,
) -> dict[str, Any]:  # fmt: skip
    """The arguments that every flow of a single trajectory takes.

    Args:
        call: The flow.
        q: Configuration at the start.
        v: Rates there.
        u: Inputs; zeros when None.
        span: t and t_end.
        times: Where states are wanted, in the order of travel.
        flow: The struct that it carries.
        max_steps: Its budget.

    Raises:
        ArrayError: A vector or a time is not what C could take.
    """
    name, kind, (nq, nv, nu, _) = call.name, call.kind, call.sizes
    span = (time_of(f"{name}.t", span[0], kind), time_of(f"{name}.t_end", span[1], kind))
    state_q, state_v = vector(f"{name}.q", q, nq, kind), vector(f"{name}.v", v, nv, kind)
    grid = output_times(name, times, *span, kind)
    values = {
        "flow": flow, "t_end": span[1], "max_steps": step_budget(name, max_steps), "q": state_q, "v": state_v, "count": len(grid), "times": grid,
        "q_out": np.empty((len(grid), nq), kind), "v_out": np.empty((len(grid), nv), kind),
    }  # fmt: skip
    flow.t = span[0]
    if nu:
        values["u"] = vector(f"{name}.u", np.zeros(nu) if u is None else u, nu, kind)
    elif u is not None and np.size(u):
        raise ArrayError(f"{name}.u", u, "is given to a chain that has no input", "leave u out, or actuate the scene")
    return values


def step_budget(name: str, max_steps: int) -> int:
    """A budget that C can count.

    Raises:
        ToleranceError: It is no whole number, negative, or larger.
    """
    return whole(f"{name}.max_steps", max_steps, 0, _MOST_STEPS, "leave it out for a million steps")


def time_of(field: str, value: Any, kind: np.dtype[Any]) -> float:
    """A time that C can hold.

    Raises:
        ArrayError: It is no number, or not finite in the type of the C.
    """
    time = number(field, value, "give a finite time in s")
    if abs(time) > float(np.finfo(kind).max):
        raise ArrayError(field, value, f"is outside the range of {kind}", "give a shorter time in s")
    return time


def continued(call: FlowCall, flow: Any, lost: ArrayLike | None) -> None:
    """Let a trajectory go on with what rounding took from it before.

    Raises:
        ArrayError: it has another shape than that of the result it should be from, or is not finite.
    """
    if lost is not None:
        size = 1 + sum(call.sizes[:2])
        flow.t_lost, *flow.lost[:] = vector(f"{call.name}.lost", lost, size, np.dtype(float)).tolist()


def reached(values: Mapping[str, Any], result: int) -> dict[str, Any]:
    """Where a single trajectory ended, as the fields of `Propagation` that all flows fill."""
    flow = values["flow"]
    return {
        "outcome": OUTCOMES[result], "t": flow.t, "q": wide(values["q"]), "v": wide(values["v"]),
        "q_at": wide(values["q_out"][: flow.written]), "v_at": wide(values["v_out"][: flow.written]),
        "tol": flow.tolerance, "steps": flow.steps, "lost": np.array([flow.t_lost, *flow.lost]),
    }  # fmt: skip


def event_argument(call: FlowCall, stop: Stop | None) -> ctypes.Structure | None:
    """The struct of an event, None for none.

    Raises:
        ArrayError: it is on an entry or a link that is not there.
    """
    if stop is None:
        return None
    if not isinstance(stop, Stop):
        raise ArrayError(f"{call.name}.stop", stop, "is no Stop", 'give one, as Stop("q", 0), or leave it out')
    nq, nv, _, links = call.sizes
    limit = {"q": nq, "v": nv, "depth": links}[stop.scalar]
    if not 0 <= stop.index < limit:
        raise ArrayError("stop.index", stop.index, f"is not below {limit}", "count entries and links from 0")
    event: ctypes.Structure = call.event(stop.number, stop.index, stop.value, stop.direction)
    return event


def vector(field: str, value: ArrayLike, size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy of a finite vector that C may change.

    Raises:
        ArrayError: it has another shape, or is not finite.
    """
    array = own(field, value, kind)
    if array.shape != (size,):
        raise ArrayError(field, array.shape, f"must have shape ({size},)", "give one vector")
    return finite(field, array)


def own(field: str, value: ArrayLike, kind: np.dtype[Any]) -> NDArray[Any]:
    """A copy in rows that C may change.

    Raises:
        ArrayError: It is ragged, or of a kind that real numbers cannot hold.
    """
    return np.array(converted(field, value, kind), order="C")


def finite(field: str, array: NDArray[Any], remedy: str = "give finite values") -> NDArray[Any]:
    """The array, if it is finite.

    Raises:
        ArrayError: it is not.
    """
    if not np.isfinite(array).all():
        raise ArrayError(field, array.tolist(), "is not finite", remedy)
    return array


def output_times(function: str, times: ArrayLike, t: float, t_end: float, kind: np.dtype[Any]) -> NDArray[Any]:
    """The times at which states are wanted, in the order of travel from t to t_end.

    Raises:
        ArrayError: a time is not finite, or they do not lie in that order.
    """
    grid = np.atleast_1d(own(f"{function}.times", times, kind))
    if grid.ndim != 1:
        raise ArrayError(f"{function}.times", grid.shape, "is no list of times", "give them one after the other")
    finite(f"{function}.times", grid, "give finite times")
    if not grid.size:
        return grid
    gaps = np.diff(np.concatenate([[t], grid, [t_end]]))
    if not (np.all(gaps >= 0) or np.all(gaps <= 0)):
        problem = "do not lie between t and t_end in the order of travel"
        raise ArrayError(f"{function}.times", grid, problem, "sort them")
    return grid


def checked_tolerance(field: str, tol: float, usual: float = 1e-12) -> float:
    """The tolerance, if it is one.

    Raises:
        ToleranceError: it is not positive and finite.
    """
    return positive(field, tol, f"use {usual:g}")


def wide(array: NDArray[Any]) -> NDArray[np.float64]:
    """A result in double precision, of its own."""
    return array.astype(np.float64)
