"""Batch forms compiled from their text alone, with and without the compiler's vectors."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phichain.emit.c import sincos as trig
from phichain.emit.c.function import c_function
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro, sincos_kernel
from phichain.emit.flow.forward_dynamics_batch import forward_dynamics_batch
from phichain.emit.flow.propagate_batch import flow_batch
from phichain.ir.nodes import Array
from phichain.lowering.dynamics import form_of_many
from phichain.lowering.lower import lower_function
from phichain.lowering.rates import scales_program
from phichain.mechanics import derive
from phichain.native.flows.forward_dynamics_batch import make_forward_dynamics_batch
from phichain.native.flows.propagate_batch import PropagateBatch, make_propagate_batch
from phichain.native.signature import Argument
from phichain.scene import Scene
from tests.flow.flows import FAST, planar, scene

#: Contraction off: the same roundings whatever the compiler makes of the text.
EXACT = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")

WRITERS = {"forward_dynamics_batch": forward_dynamics_batch, "propagate_batch": flow_batch}

RUNTIME = {"mass": "runtime", "length": "runtime", "com": "runtime", "gravity": "runtime"}
CHAINS = {
    "unrolled": planar(
        3, "arms3", joints={"actuated": "all", "angles": "absolute", "stiffness": [1.0, 0, 2]}
    ),
    "loops": planar(64, "chain64", joints={"actuated": [1, 64]}),
    "cart": scene("carted", "planar", "cart", links=2, mass=1, length=[0.5, 1], cart_mass=0.7),
    "spatial": scene("sphere3", "spatial", "cart", links=3, mass=0.1, length=0.1, cart_mass=0.5),
    "half": scene("halfway", "spatial", "fixed", links=2, mass=0.1, length=0.1, com=0.06),
    "runtime": scene("given", "planar", "fixed", links=2, **RUNTIME),
    "rods": scene("rods", "planar", "cart", links=2, mass=1, length=[0.5, 1], com=[0.3, 0.0], inertia=0.1, cart_mass=0.7),
    "bars": scene("bars", "spatial", "fixed", links=2, mass=0.1, length=0.1, com=[0.06, 0.2], inertia=[0, 1e-4]),
    "single": planar(2, "single", target={"real": "float"}),
}
GIVEN = {"mass": [1.0, 0.5], "length": [1.0, 0.7], "com": [0.5, 0.3], "gravity": 9.81}


def parameters(chain: Scene) -> tuple[Array, ...]:
    """Fields of the scene's struct of runtime parameters."""
    return scales_program(derive(chain)).params if chain.runtime else ()


@cache
def unit(chain: Scene, name: str, portable: bool = False) -> str:
    """One C file with a batch form, the forward dynamics of one state by the same Program, and what they lean on."""
    made, dynamics = WRITERS[name](derive(chain)), lower_function(derive(chain), form_of_many(chain), chain.code)
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
        text.append(sincos_kernel(chain, uses))
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


def states(chain: Scene, n: int, seed: int = 1) -> list[NDArray[np.float64]]:
    """Random q, v and, where there is one, u."""
    random = np.random.default_rng(seed)
    q, v = random.normal(size=(n, chain.nq)), random.normal(size=(n, chain.nv))
    if not chain.is_planar:
        cart = 2 if chain.has_cart else 0
        for row, rate in zip(q, v, strict=True):
            units, spins = row[cart:].reshape(-1, 3), rate[cart:].reshape(-1, 3)
            units /= np.linalg.norm(units, axis=1)[:, None]
            spins -= np.sum(spins * units, axis=1)[:, None] * units
    kind = np.float32 if chain.real == "float" else np.float64
    return [x.astype(kind) for x in (q, v, *([random.normal(size=(n, chain.nu))] if chain.nu else []))]


def given(chain: Scene) -> dict[str, Any]:
    return {"p": {k: np.array(v) for k, v in GIVEN.items()}} if chain.runtime else {}


def one_by_one(chain: Scene, scalar: Any, inputs: list[NDArray[Any]]) -> NDArray[Any]:
    """The scalar C function, row by row."""
    head = []
    if chain.runtime:
        fields = (np.ravel(GIVEN[array.name]) for array in parameters(chain))
        head = [np.concatenate(list(fields))]
    out = np.empty((len(inputs[0]), chain.nv), inputs[0].dtype)
    for k, row in enumerate(out):
        arrays = [*head, *(np.ascontiguousarray(x[k]) for x in inputs), row]
        scalar(*(ctypes.c_void_p(array.ctypes.data) for array in arrays))
    return out
