"""One Program without a scene, printed as C and compiled under strict flags: what callers of one need to run it."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from phichain.emit.c.function import c_function
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration
from phichain.emit.c.text import restrict_macro
from phichain.ir import Program

STRICT = (
    "-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-O2",
    "-ffp-contract=off", "-fPIC", "-shared",
)  # fmt: skip


def c_text(program: Program, real: str = "double") -> str:
    """A translation unit with the Program as `one_NAME`."""
    body = c_function(program, CNames("one", real, {}), {})
    assert body.uses <= {"math"}, body.uses
    arguments = [declaration(array, "one", False, True) for array in program.inputs]
    arguments += [declaration(array, "one", True, True) for array in program.outputs]
    head = f"void one_{program.name}({', '.join(arguments)})"
    macro = restrict_macro("one")
    return "\n".join(["#include <math.h>", macro, f"typedef {real} one_real;", f"{head};", head, "{", *body.lines, "}", ""])


def compiled(program: Program, folder: Path, real: str = "double") -> Callable[..., dict[str, np.ndarray]]:
    """The Program as a function of arrays, by compiled C."""
    source, library = folder / f"one_{program.name}.c", folder / f"one_{program.name}_{real}.so"
    source.write_text(c_text(program, real))
    done = subprocess.run(
        ["cc", *STRICT, str(source), "-o", str(library), "-lm"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    function = ctypes.CDLL(str(library))[f"one_{program.name}"]
    function.restype = None
    kind = np.float32 if real == "float" else np.float64

    def call(*given: object) -> dict[str, np.ndarray]:
        inputs = [np.ascontiguousarray(value, kind) for value in given]
        assert [array.size for array in inputs] == [array.size for array in program.inputs]
        outputs = [np.empty(array.size, kind) for array in program.outputs]
        function(*(ctypes.c_void_p(array.ctypes.data) for array in (*inputs, *outputs)))
        return {array.name: values for array, values in zip(program.outputs, outputs, strict=True)}

    return call
