"""One step of Rodas5P (`contract.rodas5p`) on a chain: stages on the emitted accelerations, linear solves in O(N).

The matrix of the stages is that of the linearised chain; `planar.implicit` and `spatial.implicit` factor it once a step and
solve once a stage. Spatial states are stepped in a chart of their own (see there), so that links keep their length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from phichain.contract.rodas5p import GAMMA, STAGES, A, C, M
from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.nodes import Program
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar import implicit as planar_implicit
from phichain.lowering.planar import solution as planar_solution
from phichain.lowering.spatial import implicit as spatial_implicit
from phichain.lowering.spatial import solution as spatial_solution
from phichain.lowering.spatial.chart import bends_at_start, bends_moved, displacement, on_manifold, slope
from phichain.lowering.spatial.functions import project
from phichain.lowering.writers import helps, writes
from phichain.scene import Scene

Pair = tuple[ArrayRef, ArrayRef]

#: What rounding took from q, an argument.
LOST = "lost"

#: What a step calls, in the order of `_Callees`, and where it is given what rounding took from unit vectors that springs tie.
CALLEES = ("forward_dynamics", "implicit_factors", "implicit_solution")
BENT_CALLEES = ("bent_dynamics", *CALLEES[1:])


@dataclass(frozen=True)
class _Callees:
    forward: Program
    factors: Program
    solution: Program


@helps("implicit_factors", "The linearised chain of an implicit step, eliminated from the tip to the base.", lumped=True)
def write_factors(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """The Program `implicit_factors`: gain, q, v, a[, u] -> what one step's solves need."""
    gain = builder.input("gain", (1,), "gamma h, s")
    state = [builder.input(name, (scene.nv,), name) for name in ("q", "v", "a")]
    u = builder.input("u", (scene.nu,), "inputs") if scene.is_moving else None
    b = () if u is None else tuple(u[i] for i in range(scene.base_inputs))
    out = {name: builder.output(name, (size,), name) for name, size in factor_arrays(scene).items()}
    factors = planar_implicit.factors if scene.is_planar else spatial_implicit.factors
    factors(builder, scene, parameters, (gain[0], state[0], state[1], state[2]), out, b)


@helps("implicit_solution", "One right side of an implicit step: forces inwards, motions outwards.", lumped=True)
def write_solution(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """The Program `implicit_solution`: gain, factors, right side -> k_q, k_v."""
    gain = builder.input("gain", (1,), "gamma h, s")
    known = {name: builder.input(name, (size,), name) for name, size in factor_arrays(scene).items()}
    right = [builder.input(name, (scene.nv,), name) for name in ("right_q", "right_v")]
    result = [builder.output(name, (scene.nv,), name) for name in ("k_q", "k_v")]
    solution = planar_solution.solution if scene.is_planar else spatial_solution.solution
    solution(builder, scene, parameters, gain[0], known, (right[0], right[1]), (result[0], result[1]))


@helps(
    "rosenbrock_increment", "What one Rosenbrock step of order 5 adds to the state, and its error estimate.", CALLEES, lumped=True
)
def write_increment(builder: Builder, scene: Scene, parameters: Parameters, *callees: Program) -> None:
    """The Program `rosenbrock_increment`: h, q, v[, u] -> q_1 - q_0, v_1 - v_0 and the error estimate."""
    _write_increment(builder, scene, callees, {"q": scene.nq, "v": scene.nv})


@helps("bent_increment", "The same from unit vectors and what rounding took from them.", BENT_CALLEES, lumped=True)
def write_bent_increment(builder: Builder, scene: Scene, parameters: Parameters, *callees: Program) -> None:
    """The Program `bent_increment`: h, q, v, lost[, u] -> the same, of the state q + lost, v."""
    _write_increment(builder, scene, callees, {"q": scene.nq, "v": scene.nv, LOST: scene.nq})


def increment_of(scene: Scene) -> str:
    """The Program that steps a scene: springs in space see what rounding takes from unit vectors, k times as large."""
    return "rosenbrock_increment" if scene.is_planar or scene.stiffness is None else "bent_increment"


def _write_increment(builder: Builder, scene: Scene, callees: tuple[Program, ...], state: dict[str, int]) -> None:
    arguments = {"h": builder.input("h", (), "step, s")}
    for name, size in (state | ({"u": scene.nu} if scene.nu else {})).items():
        arguments[name] = builder.input(name, (size,), name)
    names = ("q_increment", "v_increment", "q_error", "v_error")
    moved_q, moved_v, error_q, error_v = (builder.output(name, (scene.nv,), name) for name in names)
    _increments(builder, scene, _Callees(*callees), arguments, ((moved_q, moved_v), (error_q, error_v)))


@writes("step_rosenbrock", calls=CALLEES, lumped=True)
def step(
    builder: Builder, scene: Scene, parameters: Parameters, *callees: Program, **arguments: ArrayRef
) -> None:
    """Write the state after a step of size h, and the error estimate; unit vectors are made unit once more."""
    moved = builder.array("q_increment", scene.nq), builder.array("v_increment", scene.nv)
    _increments(builder, scene, _Callees(*callees), arguments, (moved, (arguments["q_error"], arguments["v_error"])))
    ends = arguments["q_next"], arguments["v_next"]
    if not scene.is_planar:
        ends = builder.array("q_free", scene.nq), builder.array("v_free", scene.nv)
    for target, start, shift in zip(ends, (arguments["q"], arguments["v"]), moved, strict=True):
        with builder.loop("i", 0, scene.nv) as loop:
            target[loop.index] = start[loop.index] + shift[loop.index]
    if not scene.is_planar:
        project(builder, scene, *ends, arguments["q_next"], arguments["v_next"])


def factor_arrays(scene: Scene) -> dict[str, int]:
    """Names and sizes of what one step's factorisation hands to its solves."""
    return planar_implicit.factor_sizes(scene) if scene.is_planar else spatial_implicit.factor_sizes(scene)


def _increments(
    builder: Builder, scene: Scene, callees: _Callees, arguments: dict[str, ArrayRef], out: tuple[Pair, Pair]
) -> None:
    """Write (q_1 - q_0, v_1 - v_0) and the error estimate.

    Args:
        builder: where the Program is recorded.
        scene: the chain.
        callees: what it calls.
        arguments: h, q, v, with inputs u, and what rounding took from q where the dynamics are given bends.
        out: the arrays of the increments and of the error estimate.
    """
    step = _Step(builder, scene, callees, arguments)
    stages = step.stages()
    moved = out[0] if scene.is_planar else (builder.array("shift", scene.nv), builder.array("turn", scene.nv))
    for part, (increment, error) in enumerate(zip(moved, out[1], strict=True)):
        with builder.loop("i", 0, scene.nv) as loop:
            terms = [(weight, stage[part][loop.index]) for weight, stage in zip(M, stages, strict=True)]
            increment[loop.index] = _combined(builder, terms)
            error[loop.index] = stages[-1][part][loop.index]
    if not scene.is_planar:
        displacement(builder, scene, (step.q, step.v), moved, out[0])


class _Step:
    def __init__(
        self, builder: Builder, scene: Scene, callees: _Callees, arguments: dict[str, ArrayRef]
    ) -> None:
        self.builder, self.scene, self.callees = builder, scene, callees
        self.h, self.q, self.v = arguments["h"][0], arguments["q"], arguments["v"]
        self.inputs = [arguments["u"]] if scene.nu else []
        self.bend = bends_at_start(builder, scene, self.q, arguments[LOST]) if LOST in arguments else None

    def stages(self) -> list[Pair]:
        """U_1 .. U_8, each as (angles, rates)."""
        builder, scene = self.builder, self.scene
        gain = builder.array("gain", 1)
        gain[0] = self.h * GAMMA
        acceleration = self._acceleration(self.q, self.v, self.bend)
        given = [gain, self.q, self.v, acceleration, *(self.inputs if scene.is_moving else [])]
        known = builder.call(self.callees.factors, given, factor_arrays(scene))
        first = self._slope(self.q, self.v, acceleration)
        found: list[Pair] = []
        for stage in range(STAGES):
            slope = first if stage == 0 else self._slope_at(found, A[stage])
            right = self._right_side(slope, found, C[stage])
            names = {f"{name}_{stage + 1}": scene.nv for name in ("angles", "rates")}
            angles, rates = builder.call(self.callees.solution, [gain, *known, *right], names)
            found.append((angles, rates))
        return found

    def _slope(self, q: ArrayRef, v: ArrayRef, acceleration: ArrayRef) -> Pair:
        """f at the start of the step, in the chart."""
        if self.scene.is_planar:
            return v, acceleration
        out = self.builder.array("slope_q", self.scene.nq), self.builder.array("slope_v", self.scene.nv)
        slope(self.builder, self.scene, self.q, (q, v, acceleration), out)
        return out

    def _slope_at(self, found: list[Pair], weights: tuple[Fraction, ...]) -> Pair:
        """f at y_0 + sum a_ij U_j."""
        builder, scene = self.builder, self.scene
        moved = []
        for part, name in enumerate(("stage_angles", "stage_rates")):
            target = builder.array(name, scene.nv)
            with builder.loop("i", 0, scene.nv) as loop:
                terms = [
                    (weight, stage[part][loop.index]) for weight, stage in zip(weights, found, strict=True)
                ]
                shift = _combined(builder, terms)
                start = (self.q, self.v)[part][loop.index] if scene.is_planar else None
                target[loop.index] = shift if start is None else start + shift
            moved.append(target)
        q, v = moved[0], moved[1]
        if not scene.is_planar:
            q, v = builder.array("stage_q", scene.nq), builder.array("stage_v", scene.nv)
            on_manifold(builder, scene, (self.q, self.v), (moved[0], moved[1]), (q, v))
        bend = None if self.bend is None else bends_moved(builder, scene, self.q, self.bend, moved[0])
        return self._slope(q, v, self._acceleration(q, v, bend))

    def _acceleration(self, q: ArrayRef, v: ArrayRef, bend: ArrayRef | None) -> ArrayRef:
        given = [q, v, *([] if bend is None else [bend]), *self.inputs]
        (acceleration,) = self.builder.call(self.callees.forward, given, {"acceleration": self.scene.nv})
        return acceleration

    def _right_side(self, slope: Pair, found: list[Pair], weights: tuple[Fraction, ...]) -> Pair:
        """gamma (h f + sum c_ij U_j)."""
        builder, scene, right = self.builder, self.scene, []
        for part, name in enumerate(("right_q", "right_v")):
            target = builder.array(name, scene.nv)
            with builder.loop("i", 0, scene.nv) as loop:
                total = self.h * slope[part][loop.index]
                terms = [
                    (weight, stage[part][loop.index]) for weight, stage in zip(weights, found, strict=True)
                ]
                if terms:
                    total = total + _combined(builder, terms)
                target[loop.index] = total * GAMMA
            right.append(target)
        return right[0], right[1]


def _combined(builder: Builder, terms: Sequence[tuple[Fraction, Expr]]) -> Expr:
    total = builder.lift(0)
    for weight, value in terms:
        total = total + value * weight
    return total
