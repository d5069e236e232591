"""C text of the brake orbits' stencils for one scene, compiled beside its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from phichain.contract.chain import Chain
from phichain.contract.functions import ROWS
from phichain.identity import beside
from phichain.native.flows.brake import has_brake
from phichain.native.flows.desk import Shape, desk_fields, event_fields, offsets, orbit_fields, row_fields
from phichain.native.glue.interrupts import Foreign
from phichain.native.signature import Manifest

STENCILS: Final = ("desk", "small", "touch", "brake", "newton", "run", "zero", "dips", "met", "calls")
"""Those of `stencils/orbits`, in the order in which they lean on each other."""
CALLS: Final = ("at", "settled", "corrected", "ahead", "run", "zero", "places", "touched")
"""What is called from Python."""
TWINNED: Final = ("at", "settled", "corrected", "ahead", "run", "zero", "places")
"""Those that may run long, which Ctrl-C leaves."""
_GIVEN: Final = {
    "p": "p", "flow": "flow", "t_end": "quarter", "max_steps": "most", "u": "still_input", "amplitude": "0", "omega": "0", "q": "q", "v": "v",
    "event": "NULL", "count": "0", "times": "NULL", "q_out": "NULL", "v_out": "NULL",
}  # fmt: skip
"""What the stencils give for an argument of the flow."""


def brakes(manifest: Manifest, chain: Chain) -> bool:
    """Whether the stencils are compiled for a scene: they need its flow with derivatives, and its mass matrix."""
    return has_brake(chain) and "propagate" in manifest.flows and "mass_matrix" in manifest.functions


def brake_file(manifest: Manifest) -> str:
    """The file's name."""
    return f"{manifest.name}_brake.c"


def brake_calls(manifest: Manifest) -> dict[str, Foreign]:
    """The functions as C declares them."""
    with_flow = (*([("const void", "*p")] if manifest.parameters else []), ("const void", "*flow"))
    desk = (("void", "*desk"),)
    return {
        name: Foreign(f"{manifest.name}_brake_{name}", "int", (*(with_flow if name in TWINNED else ()), *desk)) for name in CALLS
    }


def brake_source(manifest: Manifest, chain: Chain) -> str:
    """The file: names and sizes of the scene, the stencils, and proof that the desk lies as Python says."""
    name, flow = manifest.name, ROWS["propagate"].flow
    assert flow is not None
    given = ", ".join(_GIVEN[argument.name] for argument in flow.arguments_of(chain))
    takes = manifest.functions["mass_matrix"].takes_parameters
    energy = manifest.functions.get("energy")
    lines = [
        "#include <math.h>", "#include <stddef.h>", "#include <string.h>", f'#include "{name}.h"', "",
        f"#define PHI_Q {chain.nq}", f"#define PHI_CART {chain.nq - chain.links}",
        f"#define CONTEXT {f'const {name}_params *p,' if manifest.parameters else ''}",
        f"#define PASS {'p,' if manifest.parameters else ''}",
        *([f"#define PHI_ENERGY(q, v, kinetic, potential) {name}_energy({'p, ' if energy.takes_parameters else ''}q, v, kinetic, potential)"] if energy else []),
        f"#define PHI_FLOW_DONE {name.upper()}_DONE",
        f"#define PHI_FLOW(flow, quarter, most, still_input, q, v) {name}_propagate({given})",
        f"#define MASS_PASS {'p,' if takes else ''}",
        *(f"#define phi_{plain} {name}_{plain}" for plain in ("real", "flow", "mass_matrix")),
        *(f"#define phi_brake_{call} {name}_brake_{call}" for call in CALLS), "",
    ]  # fmt: skip
    texts = [(beside("stencils") / "orbits" / f"{part}.c").read_text(encoding="utf-8") for part in STENCILS]
    structs = {"orbit": orbit_fields, "row": row_fields, "event": event_fields, "desk": desk_fields}
    checks = [line for struct, fields in structs.items() for line in _checks(name, f"brake_{struct}", fields(chain.nq, chain.links))]
    return "\n".join([*lines, *texts, *checks, ""])


def _checks(name: str, struct: str, fields: Mapping[str, Shape]) -> Iterable[str]:
    """Compile-time proof that C and Python agree on a struct's size and on where its fields begin."""
    places = offsets(fields)
    size = max(end for _, end, _ in places.values())
    yield f"typedef char {name}_{struct}_is_whole[sizeof({struct}) == {size} * sizeof({name}_real) ? 1 : -1];"
    for field, (begin, _, _) in places.items():
        yield f"typedef char {name}_{struct}_{field}_is_in_place[offsetof({struct}, {field}) == {begin} * sizeof({name}_real) ? 1 : -1];"
