"""The one way from Python into an emitted flow: arguments by name, checked, converted and handed over in the order of the C."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np

from phichain.contract.chain import Chain
from phichain.contract.flow import Flow
from phichain.contract.functions import ROWS
from phichain.contract.registry import Registry
from phichain.errors import ArrayError
from phichain.native.flows.structs import RESULTS, handed, struct_type
from phichain.native.memory.arrays import REAL
from phichain.native.memory.parameters import ParameterBlock
from phichain.native.signature import Argument, Signature
from phichain.system.propagation import Stop

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
        brief: Steps that are over before anybody could press Ctrl-C, and after which a flow goes on as if it had not stopped.
    """

    name: str
    sizes: tuple[int, int, int, int]
    kind: np.dtype[Any]
    signature: Signature
    function: Any
    takes: tuple[tuple[str, Callable[[Any], Any]], ...]
    carried: Callable[..., Any]
    event: Callable[..., Any]
    brief: int

    def __call__(self, values: dict[str, Any], p: Mapping[str, Any] | None) -> Any:
        """Call C.

        Args:
            values: The arguments by name: numbers, arrays that C may change where it does, structs, None for NULL.
            p: The runtime parameters.

        Raises:
            ArrayError: A runtime parameter is missing, unknown, or has another shape.
        """
        if self.signature.parameters or p is not None:
            block = ParameterBlock(self.signature, self.kind)
            block.fill(p)
            values["p"] = block.values
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
        brief=_BRIEF // chain.links if chain.is_planar and name == "propagate" else 0,  # refused steps are counted once
    )


_BRIEF: Final = 1024
"""Steps of one link that take less than a millisecond."""


def _row(name: str) -> Flow:
    flow = ROWS[name].flow
    assert flow is not None, name
    return flow


def _none(*_: Any, **__: Any) -> None:
    return None


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
