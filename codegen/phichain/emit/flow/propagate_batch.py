"""The Taylor flow of many trajectories as C: ``NAME_propagate_batch``, the stencils of the flow on vectors."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from phichain.contract.flows import BATCH_EVENT, FLOW_BATCH, PROPAGATE_BATCH
from phichain.contract.functions import ROWS
from phichain.emit.c.lanes import lanes_kernel
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.flow.declared import arguments, documented, outcome_lines, scalar_constants, struct_lines
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.instance import (
    LOG_TWO,
    Called,
    at_once,
    c_names,
    ends_of_a_call,
    features,
    positions_symbol,
    printed,
    shares,
    sizes,
    spelling,
    steps_stencils,
    turns,
)
from phichain.emit.render import render
from phichain.emit.stencil import instance
from phichain.lowering.rates import scales_program
from phichain.lowering.series import series
from phichain.lowering.series.series import HIGHEST, NOW, Series
from phichain.mechanics import Model
from phichain.scene import Scene

#: Order 1 - share * log(local error): vectors make sums cheap and steps dear.
ORDER_SHARE: Final = Fraction(3, 5)
#: The local error aimed at, in units of the tolerance: over steps errors add up.
MARGIN: Final = Fraction(1, 256)
#: Vector registers a value takes: vectors that a processor does not have are taken apart in memory, six times as slow.
REGISTERS: Final = 1
#: Bytes of a vector at most.
VECTOR: Final = 64


@dataclass(frozen=True)
class FlowBatch(FlowText):
    """The batch flow of a scene as text, with the recurrences that were printed."""

    recurrences: Series


@prints("propagate_batch")
def flow_batch(model: Model, known: Collection[str] = ()) -> FlowBatch:
    """Print the batch flow of a scene.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before it and that it may call.
    """
    scene, made = model.scene, series(model)
    stem, outright = f"{scene.name}_flows", at_once(made, lanes=True)
    positions, others = positions_symbol(model, stem, known)
    called = [
        Called(f"{stem}_factor", made.factor, stem),
        Called(f"{stem}_order", made.order if made.order_shared is None else made.order_shared, stem, frozenset({NOW})),
        *([] if outright is None else [Called(f"{stem}_outright", outright, stem)]),
        *ends_of_a_call(scene, stem, stem),
        *others,
    ]
    if scene.runtime:
        called.append(Called(f"{stem}_scales", scales_program(model)))
    names = c_names(scene, stem, (one.program for one in called))
    parts, uses = printed(scene, names, called)
    definitions = render(
        "flow/batch.c.j2", upper=scene.name.upper(), kernel=lanes_kernel(scene, stem, uses | {"lanes_choose"}, REGISTERS), functions=parts, is_scalar=False,
        stencils=_stencils(model, made, names, positions), **_sizes(scene, stem, made, names),
    )  # fmt: skip
    return FlowBatch(
        declarations=laid_out_text(_declarations(scene, _work(scene, made))),
        definitions=laid_out_text(definitions),
        includes=("math.h", "stddef.h", "stdint.h", "string.h"),
        uses=uses,
        recurrences=made,
    )


def _stencils(model: Model, made: Series, names: CNames, positions: str) -> str:
    """The stencils of the flow, in the order in which they lean on each other."""
    scene = model.scene
    stem, upper = f"{scene.name}_flows", scene.name.upper()
    spelt = spelling(model, made, stem, PROPAGATE_BATCH, names, positions) | {
        "STEM_SINGLY": "", "PROPAGATE_DOC": ROWS["propagate_batch"].doc, "PHI_MARGIN": names.number(MARGIN).text, "PHI_SHARE": names.number(ORDER_SHARE * LOG_TWO).text,
        "stem_event": f"{scene.name}_batch_event", **{f"STEM_OF_{what}": f"{upper}_BATCH_OF_{what}" for what in ("DEPTH", "V")},
    }  # fmt: skip
    wanted = features(scene, made, columns=False, lanes=True)
    files = [*steps_stencils(scene, made, lanes=True), "flow/length", "flow/event", "flow/batch"]
    return "\n".join(instance(name, spelt, wanted) for name in files).rstrip("\n")


def _sizes(scene: Scene, stem: str, made: Series, names: CNames) -> dict[str, object]:
    """What the template of the constants wants to know, with the rows that trajectories share."""
    own = {"row": _row(scene, made), "right": made.shared_right, "all": made.shared_sums, "squares": 0}
    return sizes(scene, stem, made, names) | (own if shares(scene, True) else {})


def _row(scene: Scene, made: Series) -> int:
    """Numbers of a row of the configuration where trajectories share rows, with those of dry friction behind; else none."""
    return scene.nq + made.width - made.lanes if shares(scene, True) else 0


def _work(scene: Scene, made: Series) -> int:
    """Numbers the jets take, and room to put them on the boundary of a vector."""
    size, highest = 2 * scene.nq, HIGHEST[scene.real]
    start = 2 + made.held + (made.held + 2 if made.is_forced else 0) + (highest + 2) * made.rubs
    if row := _row(scene, made):
        right = made.shared_right
        start += 2 * row + right
        rows = (highest + 2) * row + (highest + 1) * right
    else:
        factors = made.width + made.lanes * made.rights
        start += size + 2 * factors
        rows = (highest + 1) * (size + factors)
    rows += highest * highest * made.rubs
    others = 4 * (made.shared_sums if row else made.sums) + 4 * size + scene.nu + (scene.nq if turns(scene) else 0)
    forcing = 4 if made.is_forced else 0
    return (2 * start + 1 + rows + others + forcing + 1) * VECTOR // (8 if scene.real == "double" else 4)


def _declarations(scene: Scene, work: int) -> str:
    return render(
        "flow/batch.h.j2", name=scene.name, doc=ROWS["propagate_batch"].doc, upper=scene.name.upper(), outcomes=outcome_lines(PROPAGATE_BATCH, scene),
        scalars=scalar_constants(PROPAGATE_BATCH, scene), event=struct_lines(BATCH_EVENT, scene),
        flow=struct_lines(FLOW_BATCH, scene), returns=PROPAGATE_BATCH.returns,
        prototype=", ".join(arguments(PROPAGATE_BATCH, scene, definition=False)), work=work,
        arguments=documented(PROPAGATE_BATCH, scene),
    )  # fmt: skip
