"""Flows compiled from their text alone, and scenes that the tests share."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from phichain.emit.c import sincos as trig
from phichain.emit.c.text import macros, sincos_kernel
from phichain.emit.flow.propagate import TaylorFlow, flow
from phichain.mechanics import derive
from phichain.native.flows.propagate import Propagate, make_propagate
from phichain.native.glue.bound import bound_source, bound_symbol
from phichain.native.signature import Argument
from phichain.scene import Scene, scene_from_dict

#: Warnings that no line may cause.
STRICT = (
    "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wfloat-conversion", "-Wshadow", "-Wcast-qual", "-Wundef", "-Wvla", "-Wfloat-equal", "-Wunreachable-code", "-Werror",
)  # fmt: skip

FAST = ("-std=c99", "-O2", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")


def planar(links: int, name: str = "", **more: Any) -> Scene:
    """Paper A's chain: m = l = 1/N, masses half-way, relative angles, unforced."""
    chain = {"links": links, "space": "planar", "base": "fixed", "mass": 1 / links, "length": 1 / links}
    chain |= {"com": 0.5 / links, **more.pop("chain", {})}
    return scene_from_dict({"name": name or f"chain{links}", "chain": chain, **more})


def scene(name: str, space: str, base: str, **chain: Any) -> Scene:
    """A scene of its chain table alone."""
    table = {"name": name, "chain": {"space": space, "base": base, **chain}}
    return scene_from_dict(table)


def unit(chain: Scene) -> tuple[str, TaylorFlow]:
    """One C file with the flow and what it leans on."""
    made = flow(derive(chain))
    includes = {*made.includes, *(trig.HEADERS if "sincos" in made.uses else ())}
    text = [f"#include <{header}>" for header in sorted(includes)]
    text += [macros(chain.name, [made.declarations, made.definitions]), f"typedef {chain.real} {chain.name}_real;"]
    fields = [f"{chain.name}_real {field}{extent};" for field, extent in _fields(chain)]
    if fields:
        text.append(f"typedef struct {{ {' '.join(fields)} }} {chain.name}_params;")
    text.append(made.declarations)
    if "sincos" in made.uses:
        text.append(sincos_kernel(chain, made.uses))
    return "\n".join([*text, made.definitions]), made


def _fields(chain: Scene) -> list[tuple[str, str]]:
    return [
        (array.name, f"[{array.size}]" if array.shape else "")
        for array in flow(derive(chain)).recurrences.factor.params
    ]


@cache
def compiled(chain: Scene, flags: tuple[str, ...] = FAST) -> Propagate:
    """The flow of a scene as a callable."""
    folder = Path(mkdtemp(prefix="flow-"))
    text, made = unit(chain)
    (folder / "flow.c").write_text("\n".join(["#include <math.h>", "#include <string.h>", text, bound_source(chain)]))
    subprocess.run(
        ["cc", *flags, "-fPIC", "-shared", "flow.c", "-o", "flow.so", "-lm"], cwd=folder, check=True
    )
    library = ctypes.CDLL(str(folder / "flow.so"))
    parameters = [Argument(array.name, array.shape) for array in made.recurrences.factor.params]
    return make_propagate(chain, parameters, library[f"{chain.name}_propagate"], library[bound_symbol(chain.name)])


#: Scenes that differ in every way the printer knows.
CHAINS = {
    "arms": planar(3, "arms", joints={"stiffness": [5.0, 0, 1], "angles": "absolute", "actuated": "all"}),
    "loops": planar(4, "looped", target={"code": "loops"}),
    "cart": scene("carted", "planar", "cart", links=2, mass=1, length=[0.5, 1], cart_mass=0.7),
}
