"""The Taylor flow of a scene as C: ``NAME_propagate``, its types, and what it is made of."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from phichain.contract.flows import PROPAGATE
from phichain.contract.functions import ROWS
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.flow.columns import columns_at_once, rows_kept, vector_bytes
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.header import declarations
from phichain.emit.flow.instance import (
    LOG_TWO,
    Called,
    c_names,
    ends_of_a_call,
    features,
    positions_symbol,
    printed,
    sizes,
    spelling,
    steps_stencils,
    turns,
)
from phichain.emit.flow.pairs import knows_rounding, pair_functions
from phichain.emit.render import render
from phichain.emit.stencil import instance
from phichain.ir.nodes import Program
from phichain.lowering.rates import scales_program
from phichain.lowering.series import series
from phichain.lowering.series.series import HELD, LEFT, NOW, RIGHT, Series
from phichain.mechanics import Model
from phichain.scene import Scene

#: Order 1 - share * log(local error). One half is the optimum where sums cost most (Jorba & Zou 2005); what a step costs
#: whatever its order, and the sweep along the chain, favour fewer and longer steps.
ORDER_SHARE: Final = Fraction(4, 5)
#: The local error aimed at, in units of the tolerance: over steps errors add up.
MARGIN: Final = Fraction(1, 256)
#: The same for a single link: its phase alone takes up what every step leaves, always of one sign.
SINGLE_MARGIN: Final = Fraction(1, 512)
#: Sums an order up to which what newest rows add to them is not worth a vector: it would wait for the rows' numbers.
SINGLY: Final = 8
#: The local error of derivatives aimed at, in units of that of the state: nothing feeds it back into the motion, and
#: their last terms are larger by the order and more, which would shorten every step. Measured, their relative error is then
#: that of the motion.
LEEWAY: Final = 64
#: Of several blocks of columns the later ones accept steps longer than theirs by this, an error four times the goal.
SLACK: Final = Fraction(15, 16)
#: How far a neighbour is put from the path: in its tangent, and far above round-off.
NEIGHBOUR: Final = Fraction(1, 2**27)


@dataclass(frozen=True)
class TaylorFlow(FlowText):
    """The Taylor flow of a scene as text, with the recurrences that were printed."""

    recurrences: Series


@prints("propagate")
def flow(model: Model, known: Collection[str] = ()) -> TaylorFlow:
    """Print the Taylor flow of a scene.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before the flow and that it may call.
    """
    scene, made = model.scene, series(model)
    stem, tangent = f"{scene.name}_flow", f"{scene.name}_tangent"
    positions, others = positions_symbol(model, stem, known)
    called = [Called(f"{stem}_factor", made.factor), Called(f"{stem}_order", made.order)]
    if made.outright is not None:
        called.append(Called(f"{stem}_outright", made.outright))
    called += ends_of_a_call(scene, stem, columns=made.columns is not None)
    if made.columns is not None:
        called += [
            Called(f"{tangent}_order", made.order_of_columns, tangent, frozenset({HELD, NOW})),
            Called(f"{tangent}_rows", made.columns, tangent, frozenset({HELD, LEFT, RIGHT})),
        ]
    for name, program in (("factor_along", made.factor_along), ("order_along", made.order_along)):
        if program is not None:
            still = frozenset(array.name for array in program.inputs if not array.name.startswith("d_"))
            called.append(Called(f"{tangent}_{name}", program, tangent, still))
    if scene.runtime:
        others = [*others, Called(f"{stem}_scales", scales_program(model))]
    called += others
    names = c_names(scene, stem, (one.program for one in called))
    parts, uses = printed(scene, names, called)
    width = columns_at_once(scene)
    number = 8 if scene.real == "double" else 4
    definitions = render(
        "flow/flow.c.j2", upper=scene.name.upper(), tangent=tangent if scene.variational else "", width=width,
        vectors=vector_bytes(scene), number_bytes=number, **rows_kept(scene, made), functions=parts, is_scalar=True,
        singly=_singly(made) and made.outright is None,
        stencils="\n".join(_stencils(model, made, names, positions)).rstrip("\n"), **sizes(scene, stem, made, names),
    )  # fmt: skip
    return TaylorFlow(
        declarations=laid_out_text(declarations(scene, made)),
        definitions=laid_out_text(definitions),
        includes=("math.h", "stdint.h", "string.h"),
        uses=uses,
        recurrences=made,
        beside=laid_out_text(_beside(model, made, names, positions)) if watches(scene) else "",
    )


def _singly(made: Series) -> bool:
    """Whether rows are too short for vectors."""
    return made.lanes * made.rights <= SINGLY


def watches(scene: Scene) -> bool:
    """Whether a compiled System can fly neighbours beside its flow, which say how large its errors are."""
    return scene.real == "double" and scene.forced is None


def _beside(model: Model, made: Series, names: CNames, positions: str) -> str:
    """The flow once more, which leaves its steps, and neighbours beside these: two stencils that lean on those of NAME.c."""
    scene, stem, real = model.scene, f"{model.scene.name}_flow", f"{model.scene.name}_real"
    inputs = f"const {real} u[{scene.nu}], " if scene.nu else ""
    is_paired = knows_rounding(scene, made)
    spelt, wanted = _spelt(model, made, names, positions), features(scene, made, made.columns is not None) | {"WITH_BESIDE": True, "WITH_PAIRS": is_paired}
    spelt |= {
        "PHI_NEIGHBOUR": names.number(NEIGHBOUR).text, "STEM_IN_PLACE": "inline",
        "ARGUMENTS": f"{spelt['ARGUMENTS']}, const int goes_on, {stem}_stop *stop, {real} *steps", "PASS_ALL": f"{spelt['PASS_ALL']}, goes_on, stop, steps",
        "stem_run": f"{stem}_noted", "stem_run_on_stack": f"{stem}_noted_on_stack", "phi_propagate": f"{scene.name}_propagate_noted",
        "JUDGED": f"{spelt['CONTEXT']}{inputs}const unsigned long count, const {real} *steps, const {real} tolerance, {stem}_beside *room, {real} *errors",
        "PROPAGATE_DOC": "The same, which leaves its steps; where these fill their room it stops for the budget, and goes on as if it had not.",
    }  # fmt: skip
    declared = f"int {scene.name}_propagate_noted({spelt['ARGUMENTS']});"
    bytes_of = ", ".join(f"sizeof({stem}_{what})" for what in ("stop", "step", "beside"))
    size = f"extern const unsigned long {scene.name}_beside_sizes[4];\nconst unsigned long {scene.name}_beside_sizes[4] = {{{bytes_of}, {stem}_highest}};"
    pairs = [] if turns(scene) or not is_paired else ["flow/fused"]
    first = [*pairs, "beside/pairs"] if is_paired else []
    then = ["beside/steps", *(["beside/defects"] if is_paired else []), "beside/neighbours"]
    programs = [render("flow/functions.c.j2", functions=pair_functions(scene, made, names, stem))] if is_paired else []
    before, behind = ([instance(name, spelt, wanted) for name in part] for part in (first, then))
    return "\n".join((*before, *programs, *behind, size, declared, "", instance("flow/run", spelt, wanted)))


def _spelt(model: Model, made: Series, names: CNames, positions: str) -> dict[str, str]:
    """What stands for the names of the flow's stencils."""
    scene, stem = model.scene, f"{model.scene.name}_flow"
    own = {
        "STEM_ZERO": "0", "stem_words": f"uint{64 if scene.real == 'double' else 32}_t", "STEM_OF": f"{stem.upper()}_OF", "STEM_AT": f"{stem.upper()}_AT",
        "stem_lanes": f"{scene.name}_real", "stem_jets": f"{scene.name}_workspace", "stem_start": f"{scene.name}_start",
        "stem_event": f"{scene.name}_event", **{f"STEM_OF_{what}": f"{scene.name.upper()}_OF_{what}" for what in ("DEPTH", "V")},
    }  # fmt: skip
    return spelling(model, made, stem, PROPAGATE, names, positions) | own | ({} if _singly(made) else {"STEM_SINGLY": ""}) | {
        "PHI_MARGIN": names.number(SINGLE_MARGIN if scene.links == 1 else MARGIN).text, "PHI_SHARE": names.number(ORDER_SHARE * LOG_TWO).text,
        "VARIES": "given" if made.order_along is not None else "", "PHI_SLACK": names.number(SLACK).text, "PHI_LEEWAY": str(LEEWAY),
    }  # fmt: skip


def _stencils(model: Model, made: Series, names: CNames, positions: str) -> list[str]:
    """The stencils of the flow, in the order in which they lean on each other."""
    scene, stem = model.scene, f"{model.scene.name}_flow"
    spelt, wanted = _spelt(model, made, names, positions), features(scene, made, made.columns is not None)
    files = [*steps_stencils(scene, made), "flow/length", "flow/event"]
    texts = [instance(name, spelt, wanted) for name in files]
    if made.columns is not None:
        tangent = f"{scene.name}_tangent"
        wide = {
            "WIDE_ZERO": f"{tangent.upper()}_EVERY(0)", "wide_": f"{tangent}_", "WIDE_": f"{tangent.upper()}_",
            **{f"ALONG_{part}": _directions(scene, program) for part, program in (("FACTOR", made.factor_along), ("ORDER", made.order_along))},
            "ROWS_0": "".join(f"{_FIRST_ROWS[array.name]}, " for array in made.columns.inputs),
        }  # fmt: skip
        norms = {name: value for name, value in spelt.items() if not name.startswith(("stem_", "STEM_"))}
        norms |= {
            "STEM_ZERO": f"{tangent.upper()}_EVERY(0)",
            "stem_cart": f"{stem}_cart", "stem_q": f"{stem}_q", "stem_x": f"{stem}_x", "stem_": f"{tangent}_",
            "STEM_": f"{tangent.upper()}_",
        }  # fmt: skip
        files = [*(["columns/parameters"] if made.order_along is not None else []), "columns/links" if made.by_links else "columns/products", "columns/sums", "columns/series"]
        texts += [instance("flow/norms", norms, wanted), *(instance(name, spelt | wide, wanted) for name in files)]
    texts.append(instance("flow/run", spelt | {"PROPAGATE_DOC": ROWS["propagate"].doc}, wanted))
    return texts


def _directions(scene: Scene, program: Program | None) -> str:
    """Where a Program finds how the parameters that it knows move, in the order of its inputs."""
    first, places = 0, {}
    for name, size in scene.varied.items():
        places[f"d_{name}"] = first
        first += size
    inputs = () if program is None else program.inputs
    return "".join(f"wide->along{f' + {places[array.name]}' if places[array.name] else ''}, " for array in inputs if array.name in places)


_FIRST_ROWS: Final = {
    HELD: "jet->start->held", LEFT: "jet->start->left[0]", RIGHT: "jet->start->right[0]", "dq": "wide->x[0]",
    "dv": "wide->x[0] + stem_q",
}  # fmt: skip
