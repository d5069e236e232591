"""Forward dynamics with what the runtime parameters alone determine kept from call to call, around NAME_prepare."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from phichain.contract.chain import Chain
from phichain.native.callables import Kept, make_callable, struct_of
from phichain.native.flows.call import calls
from phichain.native.memory.arrays import REAL, address
from phichain.native.memory.parameters import ParameterBlock
from phichain.native.signature import Argument, Signature


@dataclass(frozen=True)
class Foreigners:
    """The foreign functions that go together.

    Attributes:
        prepare: NAME_prepare.
        dynamics: NAME_forward_dynamics_prepared.
        rows: Its row loop.
        size: Bytes of the struct between them.
    """

    prepare: Callable[..., None]
    dynamics: Callable[..., None]
    rows: Callable[..., None]
    size: int

    def __post_init__(self) -> None:
        for function in (self.prepare, self.dynamics, self.rows):
            function.restype = None  # type: ignore[attr-defined]


def prepared_signature(chain: Chain, parameters: Sequence[Argument]) -> Signature:
    """NAME_forward_dynamics_prepared, which from Python is the forward dynamics."""
    inputs = [("q", chain.nq), ("v", chain.nv), *([("u", chain.nu)] if chain.nu else [])]
    return Signature(
        "forward_dynamics", f"{chain.name}_forward_dynamics_prepared", tuple(Argument(name, (size,)) for name, size in inputs),
        (Argument("a", (chain.nv,)),), tuple(parameters), True, "prepared",
    )  # fmt: skip


def prepared_dynamics(chain: Chain, parameters: Sequence[Argument], foreign: Foreigners) -> Callable[..., Any]:
    """``forward_dynamics(q, v, [u,] *, p)``, which prepares where p is another than in the last call."""
    signature, kept = prepared_signature(chain, parameters), Kept(foreign.prepare, foreign.size)
    return make_callable(signature, foreign.dynamics, foreign.rows, REAL[chain.real], kept)


@calls("prepare")
def make_prepare(chain: Chain, parameters: Sequence[Argument], foreign: Foreigners) -> Callable[..., Callable[..., Any]]:
    """Wrap NAME_prepare.

    Args:
        chain: The scene.
        parameters: Its runtime parameters in the order of the C struct.
        foreign: The foreign functions.

    Returns:
        ``prepare(p) -> dynamics``: runtime parameters by name, and ``dynamics(q, v, [u])``, the accelerations under them, one state
        or a batch; it is given no p.
    """
    signature = prepared_signature(chain, parameters)
    asking = replace(signature, name="prepare")
    alone = replace(signature, parameters=(), takes_parameters=False)

    def prepare(p: Mapping[str, Any] | None = None) -> Callable[..., Any]:
        block = ParameterBlock(asking, REAL[chain.real])
        block.fill(p)
        values = struct_of(foreign.size)
        foreign.prepare(address(block.values), address(values))
        return make_callable(alone, foreign.dynamics, foreign.rows, REAL[chain.real], values)

    return prepare
