"""Row loops in C: a function of one state applied to a whole trajectory, without a Python call per row.

For each emitted function ``NAME_f`` the glue holds ``NAME_rows_f``, which steps through arrays whose rows lie
a stride apart. A stride of 0 gives every row the same values. Scalars come through pointers as well, so they
can vary along the rows too. The glue is compiled into the loaded shared object and never written into a
generated folder.
"""

from __future__ import annotations

from phichain.native.glue.interrupts import Foreign
from phichain.native.signature import Argument, Manifest, Signature


def rows_symbol(name: str, signature: Signature) -> str:
    """Name of a function's row loop."""
    return f"{name}_rows_{signature.symbol.removeprefix(f'{name}_')}"


def rows_source(manifest: Manifest, prepared: Signature | None = None) -> str:
    """C text of the row loops of every function in the manifest.

    Args:
        manifest: The generated folder.
        prepared: The function that goes on from what was prepared, where there is one.
    """
    name = manifest.name
    parts = ["#include <stddef.h>", f'#include "{name}.h"', *_layout_checks(name, manifest.parameters)]
    parts += [_row_loop(name, signature) for signature in manifest.functions.values()]
    if prepared:
        size = f"size_t {prepared_size(name)}(void)"
        parts += [_row_loop(name, prepared), f"{size};\n{size}\n{{\n    return sizeof({name}_prepared);\n}}"]
    return "\n\n".join(parts) + "\n"


def prepared_size(name: str) -> str:
    """Name of the function that says how many bytes NAME_prepared takes."""
    return f"{name}_rows_prepared_size"


def _layout_checks(name: str, parameters: tuple[Argument, ...]) -> list[str]:
    """Compile-time proof that the parameter struct is one flat array in the manifest's order."""
    checks, offset = [], 0
    for parameter in parameters:
        fits = f"offsetof({name}_params, {parameter.name}) == {offset} * sizeof({name}_real)"
        checks.append(f"typedef char {name}_rows_{parameter.name}_is_in_place[({fits}) ? 1 : -1];")
        offset += parameter.size
    if parameters:
        fits = f"sizeof({name}_params) == {offset} * sizeof({name}_real)"
        checks.append(f"typedef char {name}_rows_params_are_flat[({fits}) ? 1 : -1];")
    return checks


def row_loop(name: str, signature: Signature) -> Foreign:
    """The row loop of a function as C declares it."""
    real = f"{name}_real"
    arguments = [("size_t", "rows")]
    if signature.takes_parameters:
        arguments.append((f"const {name}_{signature.struct}", "*p"))
    for item in signature.inputs:
        arguments += [(f"const {real}", f"*in_{item.name}"), ("size_t", f"in_{item.name}_stride")]
    arguments += [(real, f"*out_{item.name}") for item in signature.outputs]
    return Foreign(rows_symbol(name, signature), "void", tuple(arguments))


def _row_loop(name: str, signature: Signature) -> str:
    passed = ["p"] if signature.takes_parameters else []
    for item in signature.inputs:
        at = f"row * in_{item.name}_stride"
        passed.append(f"in_{item.name} + {at}" if item.shape else f"in_{item.name}[{at}]")
    passed += [f"out_{item.name} + row * {item.size}" for item in signature.outputs]
    head = row_loop(name, signature).declaration
    return "\n".join(
        [
            f"{head};",
            head,
            "{",
            "    size_t row;",
            "    for (row = 0; row < rows; row++) {",
            f"        {signature.symbol}({', '.join(passed)});",
            "    }",
            "}",
        ]
    )
