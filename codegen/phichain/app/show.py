"""What `phichain show` prints of a scene: its sketch, its Lagrangian and equations, its balance, its programs."""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from phichain.errors import UnsupportedError
from phichain.harmonic import phi_latex, phi_text
from phichain.lowering import lower_function
from phichain.mechanics import Model, derive, with_symbols
from phichain.mechanics.display import plain
from phichain.mechanics.symbols import expression
from phichain.scene import Scene

LONGEST_WRITTEN_OUT = 3
"""Chains of up to so many links are written out without being asked."""


def equations(
    scene: Scene, *, latex: bool = False, phi: bool = False, symbols: bool = False, full: bool = False
) -> str:
    """Return a scene's mechanics as text or LaTeX.

    Args:
        scene: The chain.
        latex: LaTeX instead of text.
        phi: The single-harmonic balance Phi_k too, (21)-(22) of paper A.
        symbols: Letters (m_k, l_k, ...) instead of the scene's numbers.
        full: Write everything out however long the chain is.

    Raises:
        UnsupportedError: Phi was asked of a spatial or damped scene.
    """
    shown = with_symbols(scene) if symbols else scene
    balance = (phi_latex if latex else phi_text)(shown) if phi else ""
    written = (_latex if latex else _text)(derive(shown), full or scene.links <= LONGEST_WRITTEN_OUT)
    head = [] if latex else [str(scene), ""]
    return "\n".join([*head, *written, *(["", balance] if phi else [])])


def operations(scene: Scene, function: str) -> str:
    """Return the Program of one wanted function as a list of operations.

    Raises:
        UnsupportedError: The scene does not want that function.
    """
    if function not in scene.want:
        remedy = f"choose one of {', '.join(scene.want)}, or add it to [functions] want"
        raise UnsupportedError("program", function, f"scene '{scene.name}' does not want this function", remedy)
    return str(lower_function(derive(scene), function, scene.code))


def _text(model: Model, written_out: bool) -> Iterator[str]:
    yield str(model)
    if not written_out:
        yield f"\n(more than {LONGEST_WRITTEN_OUT} links: --full writes the Lagrangian and the equations out)"
        return
    if model.scene.links > LONGEST_WRITTEN_OUT:  # else the model's own text holds them
        yield f"\nT = {plain(model.kinetic)}\nV = {plain(model.potential)}\n"
        yield from (f"{plain(equation.lhs)} = {plain(equation.rhs)}" for equation in model.equations)
    yield "\nmass matrix"
    for i in range(model.mass_matrix.shape[0]):
        yield f"[{', '.join(plain(entry) for entry in model.mass_matrix.row(i))}]"


def _latex(model: Model, written_out: bool) -> Iterator[str]:
    rows = [("T", expression(model.kinetic)), ("V", expression(model.potential))]
    if written_out:
        rows += [("I", model.mass_matrix)]
        rows += [(sympy.latex(equation.lhs), equation.rhs) for equation in model.equations]
    body = " \\\\\n".join(f"{left} &= {sympy.latex(right)}" for left, right in rows)
    yield f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"
