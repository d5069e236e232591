"""Batch forms compiled from their text alone, with and without the compiler's vectors."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from phichain.emit.c import sincos as trig
from phichain.emit.c.function import c_function
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro, sincos_kernel
from phichain.emit.flow.forward_dynamics_batch import forward_dynamics_batch
from phichain.emit.flow.propagate_batch import flow_batch
from phichain.ir.nodes import Array
from phichain.lowering.lower import lower_function
from phichain.lowering.rates import scales_program
from phichain.mechanics import derive
from phichain.native.flows.forward_dynamics_batch import make_forward_dynamics_batch
from phichain.native.flows.propagate_batch import PropagateBatch, make_propagate_batch
from phichain.native.signature import Argument
from phichain.scene import Scene
from tests.flow.flows import FAST

#: Contraction off: the same roundings whatever the compiler makes of the text.
EXACT = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")

WRITERS = {"forward_dynamics_batch": forward_dynamics_batch, "propagate_batch": flow_batch}


def parameters(chain: Scene) -> tuple[Array, ...]:
    """Fields of the scene's struct of runtime parameters."""
    return scales_program(derive(chain)).params if chain.runtime else ()


@cache
def unit(chain: Scene, name: str, portable: bool = False) -> str:
    """One C file with a batch form, the scalar forward dynamics, and what they lean on."""
    made, dynamics = WRITERS[name](derive(chain)), lower_function(derive(chain), "forward_dynamics", chain.code)
    tables = {key: f"{chain.name}_{key[0]}_{i}" for i, key in enumerate(dynamics.tables.items())}
    body = c_function(dynamics, CNames(chain.name, chain.real, tables), {})
    uses = made.uses | body.uses
    text = [f"#include <{header}>" for header in sorted({*made.includes, *trig.HEADERS})]
    text += [restrict_macro(chain.name), f"typedef {chain.real} {chain.name}_real;"]
    fields = [f"{chain.name}_real {a.name}{f'[{a.size}]' if a.shape else ''};" for a in parameters(chain)]
    if fields:
        text.append(f"typedef struct {{ {' '.join(fields)} }} {chain.name}_params;")
    text.append(made.declarations)
    if "sincos" in uses:
        text.append(sincos_kernel(chain))
    numbers = CNames(chain.name, chain.real, {}).number
    for (_, values), table in tables.items():
        listed = ", ".join(numbers(value).text for value in values)
        text.append(f"static const {chain.real} {table}[{len(values)}] = {{{listed}}};")
    declared = [f"const {chain.name}_params *p"] if dynamics.params else []
    declared += [declaration(array, chain.name, False, False) for array in dynamics.inputs]
    declared += [declaration(array, chain.name, True, False) for array in dynamics.outputs]
    head = f"void {chain.name}_forward_dynamics({', '.join(declared)})"
    text += [f"{head};", head, "{", *body.lines, "}", made.definitions]
    whole = "\n".join(text)
    return whole.replace("defined(__GNUC__)", "0") if portable else whole


@cache
def library(chain: Scene, name: str, flags: tuple[str, ...], portable: bool) -> ctypes.CDLL:
    """The unit as a loaded object."""
    folder = Path(mkdtemp(prefix="batch-"))
    (folder / "batch.c").write_text(unit(chain, name, portable))
    subprocess.run(
        ["cc", *flags, "-fPIC", "-shared", "batch.c", "-o", "batch.so", "-lm"], cwd=folder, check=True
    )
    return ctypes.CDLL(str(folder / "batch.so"))


def dynamics(chain: Scene, flags: tuple[str, ...] = FAST, portable: bool = False) -> tuple[Any, Any]:
    """(batch form, scalar C function) of the forward dynamics."""
    loaded, name = library(chain, "forward_dynamics_batch", flags, portable), f"{chain.name}_forward_dynamics"
    known = [Argument(array.name, array.shape) for array in parameters(chain)]
    scalar = loaded[name]
    scalar.restype = None
    return make_forward_dynamics_batch(chain, known, loaded[f"{name}_batch"]), scalar


def flow(chain: Scene, flags: tuple[str, ...] = FAST, portable: bool = False) -> PropagateBatch:
    """The batch flow of a scene as a callable."""
    loaded = library(chain, "propagate_batch", flags, portable)
    known = [Argument(array.name, array.shape) for array in parameters(chain)]
    return make_propagate_batch(chain, known, loaded[f"{chain.name}_propagate_batch"])
