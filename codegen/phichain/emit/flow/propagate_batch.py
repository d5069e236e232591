"""The Taylor flow of many trajectories as C: ``NAME_propagate_batch``, vectorised across trajectories.

The recurrences are those of the scalar flow (`emit.flow.propagate`), printed for lanes: the sums S_n of a product run over its own
orders, side by side in memory, in every lane at once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from phichain.contract.flows import BATCH_EVENT, FLOW_BATCH, PROPAGATE_BATCH
from phichain.contract.functions import ROWS
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import CFunction, c_function
from phichain.emit.c.lanes import lane_declaration, lane_function, lanes_kernel
from phichain.emit.c.layout import laid_out_text
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration, words
from phichain.emit.flow.declared import arguments, documented, outcome_lines, scalar_constants, struct_lines
from phichain.emit.flow.flows import FlowText, prints
from phichain.emit.flow.propagate import (
    EPSILON,
    HIGHEST,
    MARGIN,
    NOISE,
    ROOM,
    Tables,
    libm_names,
    positions_read_parameters,
    scales_literals,
)
from phichain.emit.render import render
from phichain.ir.nodes import Program
from phichain.ir.passes import total_operations, unroll
from phichain.ir.varying import varying
from phichain.lowering.field import vector_field
from phichain.lowering.lower import lower_function
from phichain.lowering.rates import scales_program
from phichain.mechanics import Model
from phichain.scene import Scene
from phichain.transform.factors import FACTORS, Factored, factored
from phichain.transform.jets import jets
from phichain.transform.lanes import FIRST, INVERSE_ORDER, ORDER, SUMS

#: Order 1 - share * log(local error): lanes make sums cheap and steps dear.
ORDER_SHARE: Final = Fraction(3, 5)
#: Above this many operations loops are kept. Straight-line code keeps each factor once.
UNROLL_LIMIT: Final = 1500
#: Bytes of a vector, on every machine.
VECTOR: Final = 64

#: What `start` gives back that is no held value.
_ROWS: Final = {FACTORS, "a", "q_dot"}


@dataclass(frozen=True)
class FlowBatch(FlowText):
    """The batch flow of a scene as text, with the recurrences that were printed."""

    recurrences: Factored


@dataclass(frozen=True)
class _Part:
    """One static function as the template sees it."""

    comment: tuple[str, ...]
    symbol: str
    definition: str
    ignored: tuple[str, ...]
    lines: tuple[str, ...]


def batch_program(model: Model) -> Program:
    """The vector field in the form that the batch flow differentiates."""
    scene, loops = model.scene, vector_field(model)
    if scene.code == "loops" or (scene.code == "auto" and total_operations(loops) > UNROLL_LIMIT):
        return loops
    return unroll(loops)


@prints("propagate_batch")
def flow_batch(model: Model, known: Collection[str] = ()) -> FlowBatch:
    """Print the batch flow of a scene.

    Args:
        model: the scene's mechanics.
        known: functions of NAME.c that stand before it and that it may call.
    """
    return _Printer(model, "positions" in known).text()


class _Printer:
    def __init__(self, model: Model, positions_known: bool) -> None:
        scene = model.scene
        self.model, self.scene, self.stem = model, scene, f"{scene.name}_flows"
        self.recurrences = factored(jets(batch_program(model)), HIGHEST[scene.real])
        start, follow = self.recurrences.start, self.recurrences.follow
        moving = varying(start, {array.name for array in start.inputs})
        #: Held values that are the same in every lane, and the order.
        self.uniform = {array.name for array in start.outputs if array.name not in moving | _ROWS}
        self.lane_programs = {f"{self.stem}_start": start, f"{self.stem}_follow": follow}
        self.programs: dict[str, Program] = {}
        if scene.runtime:
            self.programs[f"{self.stem}_scales"] = scales_program(model)
        self.positions = f"{scene.name}_positions"
        if not positions_known:
            self.positions = f"{self.stem}_positions"
            self.programs[self.positions] = lower_function(model, "positions", "loops")
        tables: Tables = {}
        for program in (*self.lane_programs.values(), *self.programs.values()):
            for key in program.tables.items():
                tables.setdefault(key, f"{self.stem}_{key[0]}_{len(tables) + 1}")
        self.names = CNames(scene.name, scene.real, tables)

    def text(self) -> FlowBatch:
        bodies = {
            symbol: lane_function(program, self.names, self.stem, self._uniform_arguments(program))
            for symbol, program in self.lane_programs.items()
        }
        bodies |= {symbol: c_function(program, self.names, {}) for symbol, program in self.programs.items()}
        uses = frozenset({"math"}).union(*(body.uses for body in bodies.values()))
        return FlowBatch(
            declarations=laid_out_text(_declarations(self.scene, self._work())),
            definitions=laid_out_text(
                self._definitions(bodies, lanes_kernel(self.scene, self.stem, uses, None))
            ),
            includes=("math.h", "stddef.h", "stdint.h", "string.h"),
            uses=uses,
            recurrences=self.recurrences,
        )

    def _uniform_arguments(self, program: Program) -> set[str]:
        named = {array.name for array in (*program.inputs, *program.outputs)}
        return named & (self.uniform | {ORDER, INVERSE_ORDER})

    def _parts(self, bodies: dict[str, CFunction]) -> Iterator[_Part]:
        prefix, comments = self.scene.name, Comments(self.scene)
        for symbol, body in bodies.items():
            program = (self.lane_programs | self.programs)[symbol]
            declared = [f"const {prefix}_params *p"] if program.params else []
            if symbol in self.lane_programs:
                uniform = self._uniform_arguments(program)
                arrays = [(array, False) for array in program.inputs] + [
                    (array, True) for array in program.outputs
                ]
                declared += [
                    lane_declaration(array, prefix, self.stem, is_output, array.name in uniform)
                    for array, is_output in arrays
                ]
            else:
                declared += [declaration(array, prefix, False, True) for array in program.inputs]
                declared += [declaration(array, prefix, True, True) for array in program.outputs]
            used = words("\n".join(body.lines))
            given = [*(["p"] if program.params else []), *(array.name for array in program.inputs)]
            ignored = tuple(name for name in given if name not in used)
            comment = comments.above(program.name, program.doc, body.lines)
            yield _Part(comment, symbol, ", ".join(declared), ignored, body.lines)

    def _call(self, symbol: str, order: str) -> str:
        """The call of a sweep at an order, on the arrays of the jets."""
        real, program = f"{self.scene.name}_real", self.lane_programs[symbol]
        row = {
            "q": f"jet->x[{order}]", "v": f"jet->x[{order}] + {self.scene.nq}", "u": "jet->u",
            FACTORS + FIRST: "jet->factor", FACTORS: f"jet->factor + {order}" if order != "0" else "jet->factor", SUMS: "sums",
            ORDER: f"({real}){order}", INVERSE_ORDER: f"1 / ({real}){order}",
            "a": f"slope + {self.scene.nq}", "q_dot": "slope",
        }  # fmt: skip
        given = ["p"] if program.params else []
        given += [row.get(array.name, f"jet->{array.name}") for array in (*program.inputs, *program.outputs)]
        return f"{symbol}({', '.join(given)})"

    def _pairs(self) -> list[tuple[str, str]]:
        """The factors of each product as tables; none where their numbers follow from the product's."""
        made = self.recurrences
        if made.left is None or made.right is None:
            return []
        fill, stride = (0,) * (_even(made.products) - made.products), HIGHEST[self.scene.real]
        sides = (("left", made.left + fill), ("right", made.right + fill))
        return [(side, ", ".join(str(number * stride) for number in numbers)) for side, numbers in sides]

    def _held(self) -> list[tuple[str, int, str]]:
        """What `start` computes once for all orders: (array, size, C type)."""
        real, lanes = f"{self.scene.name}_real", f"{self.stem}_lanes"
        outputs = (array for array in self.recurrences.start.outputs if array.name not in _ROWS)
        return [(array.name, array.size, real if array.name in self.uniform else lanes) for array in outputs]

    def _work(self) -> int:
        """Numbers the jets take, and room to put them on the boundary of a vector."""
        scene, highest, made = self.scene, HIGHEST[self.scene.real], self.recurrences
        lanes = VECTOR // (8 if scene.real == "double" else 4)
        numbers = (
            (scene.nq + scene.nv) * (highest + 3)
            + scene.nu
            + 4 * _even(made.products)
            + (made.count + 2) * highest
        )
        # Held values that are one number are counted as lanes: with what aligns them, they take less.
        return (numbers + sum(size for _, size, _ in self._held()) + 2) * lanes

    def _definitions(self, bodies: dict[str, CFunction], kernel: str) -> str:
        scene, names, real = self.scene, self.names, f"{self.scene.name}_real"
        of_q = f"jet->x[n][{scene.nq} + i]" if scene.is_planar else "slope[i]"
        numbers = {
            table: ", ".join(names.number(value).text for value in values)
            for (_, values), table in names.tables.items()
        }
        return render(
            "flow_batch.c.j2", name=scene.name, doc=ROWS["propagate_batch"].doc, stem=self.stem, upper=scene.name.upper(), real=real,
            const_real=f"const {real}", kernel=kernel, nq=scene.nq, nv=scene.nv, nu=scene.nu,
            highest=HIGHEST[scene.real], products=_even(self.recurrences.products), factors=self.recurrences.count + 2, pairs=self._pairs(), count=max(self.recurrences.products, 1), held=self._held(),
            tables=[(table, len(values), numbers[table]) for (_, values), table in names.tables.items()],
            functions=list(self._parts(bodies)), parameter=f"const {scene.name}_params *p, " if scene.runtime else "",
            pass_parameter="p, " if scene.runtime else "",
            start_call=self._call(f"{self.stem}_start", "0"), follow_call=self._call(f"{self.stem}_follow", "n"),
            slopes=[(0, scene.nq, of_q), (scene.nq, scene.nq + scene.nv, "slope[i]")],
            cart=(1 if scene.is_planar else 2) if scene.has_cart else 0, scales=scales_literals(scene, names),
            positions=self.positions, masses=scene.links, axes=2 if scene.is_planar else 3,
            positions_parameter="p, " if scene.runtime and positions_read_parameters(self.model) else "",
            margin=names.number(MARGIN).text, room=ROOM,
            noise=names.number(NOISE[scene.real]).text, planar=scene.is_planar, epsilon=names.number(EPSILON[scene.real]).text,
            order_share=names.number(ORDER_SHARE).text, huge="700" if scene.real == "double" else "80",
            definition=", ".join(arguments(PROPAGATE_BATCH, scene, definition=True)), **libm_names(names),
        )  # fmt: skip


def _even(count: int) -> int:
    """Products are summed two at a time."""
    return max(count + count % 2, 2)


def _declarations(scene: Scene, work: int) -> str:
    return render(
        "flow_batch.h.j2", name=scene.name, doc=ROWS["propagate_batch"].doc, upper=scene.name.upper(), outcomes=outcome_lines(PROPAGATE_BATCH, scene),
        scalars=scalar_constants(PROPAGATE_BATCH, scene), event=struct_lines(BATCH_EVENT, scene),
        flow=struct_lines(FLOW_BATCH, scene), returns=PROPAGATE_BATCH.returns,
        prototype=", ".join(arguments(PROPAGATE_BATCH, scene, definition=False)), work=work,
        arguments=documented(PROPAGATE_BATCH, scene),
    )  # fmt: skip
