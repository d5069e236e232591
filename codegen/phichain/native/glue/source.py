"""The C that is compiled beside a generated folder's own: twins that Ctrl-C can leave, and proof that structs lie as ctypes says."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

from phichain.contract.chain import Chain
from phichain.contract.flow import Flow, Passed, Struct
from phichain.contract.functions import ROWS
from phichain.native.flows.bound import bound_struct
from phichain.native.flows.structs import struct_type
from phichain.native.glue.bound import bound_source
from phichain.native.glue.brake import TWINNED, brake_calls, brakes
from phichain.native.glue.interrupts import HEADERS, Foreign, interrupts_source
from phichain.native.glue.rows import row_loop
from phichain.native.signature import Manifest, Signature

_PLAIN = ("int", "unsigned long", "size_t")


def glue_source(manifest: Manifest, chain: Chain, prepared: Signature | None = None) -> str:
    """C text of the glue; `prepared` as in `rows_source`."""
    name = manifest.name
    signatures = [*manifest.functions.values(), *([prepared] if prepared else [])]
    loops = [row_loop(name, signature) for signature in signatures]
    declared = [f"{loop.declaration};" for loop in loops]
    twins = [*loops, *(foreign_flow(symbol, flow, chain) for flow, symbol in manifest.flows.items())]
    if beside_file(manifest) in manifest.files:
        flow = foreign_flow(manifest.flows["propagate"], "propagate", chain)
        judged = [noted_flow(flow, name), errors_beside(flow, name)]
        twins += judged
        declared += [f"{one.declaration};" for one in judged]
    if brakes(manifest, chain):
        of_orbits = [brake_calls(manifest)[call] for call in TWINNED]
        twins += of_orbits
        declared += [f"{twin.declaration};" for twin in of_orbits]
    structs = [struct for flow in manifest.flows for struct in (_flow(flow).carries, _flow(flow).event) if struct]
    bound = [bound_source(chain)] if "propagate" in manifest.flows else []
    structs += [bound_struct(chain) for _ in bound]
    checks = [line for struct in structs for line in _layout_checks(name, struct, chain)]
    parts = [*HEADERS, f'#include "{name}.h"', "", *bound, *checks, *declared, interrupts_source(name, twins)]
    return "\n".join(parts)


def foreign_flow(symbol: str, name: str, chain: Chain) -> Foreign:
    """A flow of the contract as its twin declares it; addresses are handed on as they come."""
    flow = _flow(name)
    return Foreign(symbol, flow.returns, tuple(_argument(argument, chain) for argument in flow.arguments_of(chain)))


def beside_file(manifest: Manifest) -> str:
    """What is compiled behind NAME.c where neighbours fly beside its flow; no generated folder has it."""
    return f"{manifest.name}_beside.c"


def noted_flow(flow: Foreign, name: str) -> Foreign:
    """The Taylor flow that leaves its steps: behind all else it takes whether it goes on, with what, and where steps go."""
    more = (("int", "goes_on"), ("void", "*stop"), ("void", "*steps"))
    return Foreign(f"{name}_propagate_noted", flow.returns, (*flow.arguments, *more))


def errors_beside(flow: Foreign, name: str) -> Foreign:
    """What flies beside these steps: it is given what the flow is given that stays the same, the steps and the tolerance."""
    held = tuple(argument for argument in flow.arguments if argument[1] in ("*p", "*u"))
    more = (("unsigned long", "count"), ("void", "*steps"), (f"{name}_real", "tolerance"), ("void", "*room"), ("void", "*errors"))
    return Foreign(f"{name}_errors_beside", "void", (*held, *more))


def _argument(argument: Passed, chain: Chain) -> tuple[str, str]:
    if argument.form != "value":
        return "void", f"*{argument.name}"
    return argument.type if argument.type in _PLAIN else f"{chain.name}_{argument.type}", argument.name


def _flow(name: str) -> Flow:
    flow = ROWS[name].flow
    assert flow is not None, name
    return flow


def _layout_checks(name: str, struct: Struct, chain: Chain) -> Iterable[str]:
    """Compile-time proof that C and ctypes agree on a struct's size and where its fields begin."""
    layout, kind = struct_type(struct, chain), f"{name}_{struct.name}"
    yield f"typedef char {kind}_is_whole[sizeof({kind}) == {ctypes.sizeof(layout)} ? 1 : -1];"
    for field in struct.fields_of(chain):
        at = getattr(layout, field.name).offset
        yield f"typedef char {kind}_{field.name}_is_in_place[offsetof({kind}, {field.name}) == {at} ? 1 : -1];"
