"""What was printed of a scene -> NAME.h and NAME.c."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from textwrap import wrap

from phichain.contract.meanings import state_meanings
from phichain.emit import bessel
from phichain.emit.c import sincos as trig
from phichain.emit.c.layout import WIDTH, aligned, laid_out_text
from phichain.emit.c.programs import explained_rows
from phichain.emit.cost import costs, kernel_flash
from phichain.emit.printed import Printed
from phichain.emit.render import render
from phichain.ir.nodes import Array
from phichain.scene import Scene


def header(printed: Printed, tolerances: Mapping[str, str]) -> str:
    """NAME.h: sizes, the params struct, and one documented prototype a wanted function."""
    scene, upper = printed.scene, printed.scene.name.upper()
    declared = [flow.text.declarations for flow in printed.flows]
    return render(
        "header.h.j2", name=scene.name, upper=upper, real=scene.real, sketch=_sketch(scene), digest=scene.digest,
        sizes=_sizes(scene), state=explained_rows(list(state_meanings(scene).items())), params=_params(printed.params),
        functions=printed.programs.functions, costs=_costs(printed), about=_about_angles(printed), flows=list(zip(printed.flows, declared, strict=True)), hook=scene.trig_hook or "",
        sizes_come_as_size_t=any("size_t" in text for text in declared),
        tolerances=aligned((f"#define {upper}_{name.upper()}_TOLERANCE", value) for name, value in tolerances.items()),
    )  # fmt: skip


def _costs(printed: Printed) -> dict[str, str]:
    """What a header says of each function's room, by its name."""
    return {
        name: f"Cortex-M4F, -Os: flash {cost.flash} bytes, stack {cost.stack} bytes at most." for name, cost in costs(printed).items()
    }


def _about_angles(printed: Printed) -> list[str]:
    """What a header says of sines and cosines: who computes them, how well, up to which angle."""
    scene, kernel, flash = printed.scene, trig.KERNELS[printed.scene.real], kernel_flash(printed)
    if not flash:
        return []
    beyond = f"from {trig.FLOAT_END} on" if scene.real == "float" else "beyond"
    said = {
        "bundled": f"by code of its own, within {trig.BUNDLED_ERROR[scene.real]:g} ulp up to {trig.RANGE} rad, NaN {beyond}",
        "libm": "by the C library, as well as that does",
        "hook": f"by {scene.trig_hook}, which you provide",
        None: f"by code of its own within {kernel.error_ulp:g} ulp up to {kernel.bound:.0f} rad, beyond by the C library",
    }  # fmt: skip
    return wrap(f"Sines and cosines: {said[scene.trig]}; flash {flash} bytes at most.", WIDTH - 3)


def source(printed: Printed) -> str:
    """NAME.c: kernels, tables and functions, each only where something needs it."""
    scene, programs, made = printed.scene, printed.programs, [flow.text for flow in printed.flows]
    uses = programs.uses.union(*(flow.uses for flow in made))
    sincos = sincos_kernel(scene, uses) if _wants_sincos(scene, uses) else ""
    flows = [flow.definitions for flow in made]
    printed_lines = [line for function in programs.functions for line in (function.definition, *function.lines)]
    return render(
        "source.c.j2", name=scene.name, functions=programs.functions, tables=programs.tables,
        includes=sorted(set(includes({*uses, *(("sincos",) if _wants_sincos(scene, uses) else ())})).union(*(flow.includes for flow in made))),
        sincos=sincos, bessel=bessel_kernel(scene) if "bessel" in uses else "",
        flows=flows, restrict=macros(scene.name, (sincos, *printed_lines, *flows)),
    )  # fmt: skip


def _wants_sincos(scene: Scene, uses: Collection[str]) -> bool:
    """Whether something computes sines and cosines: Bessel functions do, unless the C library serves them."""
    return bool({"sincos", "sincos_pairs"} & set(uses)) or (scene.trig is not None and "bessel" in uses)


def restrict_macro(name: str) -> str:
    """NAME_RESTRICT, which definitions, kernels and flows lean on: every file with one of them has it first."""
    return render("restrict.c.j2", name=name)


def macros(name: str, texts: Iterable[str]) -> str:
    """NAME_RESTRICT; NAME_REGISTER and NAME_VALUE, and NAME_LANES, where one of the texts that follow has one of them."""
    texts, upper = tuple(texts), name.upper()
    values = any(f"{upper}_{word} " in text for text in texts for word in ("VALUE", "REGISTER"))
    lanes = any(f"{upper}_LANES" in text for text in texts)
    chosen = (("value.c.j2", values), ("lanes_loop.c.j2", lanes))
    return restrict_macro(name) + "".join(render(template, name=name) for template, is_wanted in chosen if is_wanted)


def sincos_kernel(scene: Scene, uses: Collection[str]) -> str:
    """The vectorisable sine-cosine kernel in the scene's type, and what sets its angles side by side ("write_2", "write_4")."""
    if scene.trig is not None:
        return laid_out_text(_chosen_trigonometry(scene, apart=bool({"sincos", "bessel"} & set(uses))))
    writes = [width for width in (2, 4) if f"write_{width}" in uses]
    numbers = trig.coefficients(scene.real)
    return laid_out_text(render("trig/sincos.c.j2", name=scene.name, real=scene.real, writes=writes, **numbers))


def _chosen_trigonometry(scene: Scene, apart: bool) -> str:
    """Sines and cosines by whom the scene says; of a kernel that sets pairs, whether two arrays are wanted as well."""
    numbers = trig.coefficients(scene.real)
    if scene.trig == "bundled":
        template = "trig/bundled.c.j2" if scene.real == "float" else "trig/bundled_double.c.j2"
        return render(template, name=scene.name, real=scene.real, apart=apart, **numbers, **trig.bundled(scene.real))
    return render("trig/given.c.j2", name=scene.name, hook=scene.trig_hook or "", **numbers)


def bessel_kernel(scene: Scene) -> str:
    """The Bessel functions J_0 to J_4 in the scene's type."""
    return laid_out_text(render("bessel.c.j2", name=scene.name, real=scene.real, own=scene.trig is not None, **bessel.coefficients(scene.real)))


def includes(uses: Iterable[str]) -> list[str]:
    """Standard headers that kernels want."""
    uses = set(uses)
    wanted = set(trig.HEADERS) if "sincos" in uses else set()
    return sorted(wanted | ({"math.h"} if uses & {"math", "bessel"} else set()))


def _sizes(scene: Scene) -> list[str]:
    upper = scene.name.upper()
    sizes = [
        ("LINKS", scene.links, "number of links"),
        ("NQ", scene.nq, "entries of q: " + _listed(scene.q_names)),
        ("NV", scene.nv, "entries of v and a: " + _listed(scene.v_names)),
        *([("NU", scene.nu, "entries of u: " + _listed(scene.u_names))] if scene.nu else []),
    ]
    return aligned((f"#define {upper}_{size}", str(value), f"/* {doc} */") for size, value, doc in sizes)


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names) if len(names) <= 5 else f"{', '.join(names[:3])}, ..., {names[-1]}"


def _params(arrays: tuple[Array, ...]) -> list[tuple[str, str]]:
    """(declarator, doc) of every field of the params struct."""
    fields = [f"{array.name}{f'[{array.size}]' if array.shape else ''};" for array in arrays]
    width = max(map(len, fields), default=0)
    return [(f"{field:{width}}", array.doc) for field, array in zip(fields, arrays, strict=True)]


def _sketch(scene: Scene) -> list[str]:
    """The scene's picture as lines fit for a C comment."""
    lines = [line.rstrip().replace("*/", "* /") for line in str(scene).splitlines()]
    return [part for line in lines for part in wrap(line, WIDTH - 3, subsequent_indent=" " * 9) or [""]]
