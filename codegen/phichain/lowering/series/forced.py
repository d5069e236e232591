"""Taylor recurrences under a forcing f(t) = A cos(omega t), whose own Taylor coefficients f_n are known.

f drives what inputs drive. Inputs enter the recurrences at order 0 alone, since they are constant in time as gravity is: in some
numbers of `held`, each of which the order weighs by whether n = 0, all of them affine in the inputs. So with f_0 among the inputs

    held(f_0), weighed by 1, at n = 0;    later, weighed by f_n, at n > 0

`later` being d held / df where a number of `held` is constant in time and `held` elsewhere, and the same back substitution serves
every order of a forced chain. The derivative is that of the factorisation as it stands, so that no recurrence knows of forcing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import replace
from fractions import Fraction
from itertools import groupby, product

from phichain.ir.nodes import (
    Affine,
    Array,
    Cell,
    Const,
    For,
    Local,
    Op,
    Operand,
    Program,
    Statement,
    Store,
    walk,
)
from phichain.ir.passes import prune, unroll
from phichain.ir.reads import reading
from phichain.ir.short_loops import without_short_loops
from phichain.lowering.series.series import FORCE, HELD, LATER, NOW, Series
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian

_BY_FORCE, _DRIVEN = "by_force", "applied"
#: The cell of `now` that says whether n = 0.
_IS_FIRST = Cell(NOW, Affine(3))
#: Runs of so many cells and more are copied by a loop.
_LONG = 5


def with_inputs(scene: Scene) -> Scene:
    """The chain with an input where it is forced, beside those that it has."""
    if scene.forced == "cart" and scene.actuated == "none":
        return _actuated(scene, "cart")
    if not isinstance(scene.forced, int):
        return scene
    joints = tuple(sorted({*scene.actuated_joints, scene.forced}))
    return _actuated(scene, joints if scene.angles == "relative" and len(joints) < scene.links else "all")


def _actuated(scene: Scene, actuated: str | tuple[int, ...]) -> Scene:
    view = copy(scene)
    object.__setattr__(view, "actuated", actuated)
    return view


def push_of(scene: Scene, view: Scene) -> dict[int, int]:
    """What one unit of f adds to which inputs of `with_inputs`.

    The torque at joint j turns link j one way and the link before it the other; absolute and adjacent angles see of that pair
    tau_theta = S^T tau_phi.
    """
    if not isinstance(scene.forced, int):
        axes = scene.told_axes or range(view.base_inputs)
        return {axes.index(int(scene.axis or 1) - 1): 1}
    lag = {"relative": 0, "absolute": 1, "adjacent": 2}[str(scene.angles)]
    pair = {scene.forced: 1} | ({scene.forced - lag: -1} if lag and scene.forced > lag else {})
    return {view.base_inputs + view.actuated_joints.index(joint): sign for joint, sign in pair.items()}


def forced(made: Series, scene: Scene, view: Scene) -> Series:
    """The recurrences of a forced scene.

    Args:
        made: those of the chain with an input where it is forced.
        scene: the scene.
        view: the chain that `made` is of.
    """
    factor = _factor(made.factor, scene, view, _steady(made.order))
    shared = None if made.order_shared is None else _weighed(made.order_shared)
    return replace(made, factor=factor, order=_weighed(made.order), tangent=made.order, order_shared=shared, is_forced=True)


def _steady(order: Program) -> frozenset[int]:
    """The numbers of `held` that an order multiplies by whether n = 0: what is constant in time, all in all."""
    found: set[int] = set()
    hulls = {loop.variable: range(loop.hull[0], loop.hull[1] + 1) for loop in walk(order.body) if isinstance(loop, For)}
    for statement in walk(order.body):
        if isinstance(statement, Op) and statement.kind == "mul" and _IS_FIRST in statement.args:
            found.update(*(_cells(cell, hulls) for cell in statement.args if isinstance(cell, Cell) and cell.array == HELD))
    return frozenset(found)


def _cells(cell: Cell, hulls: Mapping[str, range]) -> set[int]:
    """The cells that are meant over all turns of the loops."""
    variables = [variable for variable, _ in cell.index.terms]
    return {cell.index.at(dict(zip(variables, turn, strict=True))) for turn in product(*(hulls[name] for name in variables))}


def _weighed(order: Program) -> Program:
    """An order that weighs what is constant in time by a number that it is given."""
    force = Array(FORCE, (1,), "what counts as constant in time: 1 at n = 0, later the forcing's coefficient")
    weight = Cell(FORCE, Affine(0))
    weighed = reading(order, lambda operand: weight if operand == _IS_FIRST else operand)
    return replace(weighed, inputs=(*order.inputs, force))


def _factor(program: Program, scene: Scene, view: Scene, steady: frozenset[int]) -> Program:
    """`held` with f_0 among the inputs, and `later`."""
    driven = jacobian(_driven(program, scene, view), program.name, program.doc, [Block(HELD, FORCE, _BY_FORCE)], keep_outputs=True)
    size = next(array.size for array in driven.outputs if array.name == HELD)
    held, *rows = (array for array in driven.outputs if array.name != _BY_FORCE)
    later = Array(LATER, (size,), "the same at later orders: by a unit of the forcing where a number is constant in time")
    slopes = tuple(_wanted(driven.body, steady))
    made = replace(
        driven, outputs=(held, later, *rows), work=(*driven.work, Array(_BY_FORCE, (size,))),
        body=(*slopes, *_copies(steady, size, program.is_straight_line)),
    )  # fmt: skip
    return unroll(made) if program.is_straight_line else without_short_loops(prune(made))


def _wanted(statements: Iterable[Statement], steady: frozenset[int], hull: range = range(1)) -> Iterator[Statement]:
    """The statements without the slopes that nobody reads: of what is not constant in time they are zero."""
    for statement in statements:
        if isinstance(statement, For):
            low, high = statement.hull
            yield replace(statement, body=tuple(_wanted(statement.body, steady, range(low, high + 1))))
        elif not isinstance(statement, Store) or statement.cell.array != _BY_FORCE:
            yield statement
        else:
            index = statement.cell.index
            turns = [index.at({variable: k for variable, _ in index.terms}) for k in hull]
            if steady.intersection(turns):
                yield statement


def _copies(steady: frozenset[int], size: int, is_flat: bool) -> Iterator[Statement]:
    """`later`, run by run."""
    for is_steady, run in groupby(range(size), steady.__contains__):
        cells, source = list(run), _BY_FORCE if is_steady else HELD
        if is_flat or len(cells) < _LONG:
            yield from (Store(Cell(LATER, Affine(at)), Cell(source, Affine(at))) for at in cells)
            continue
        turn = Affine(cells[0], (("k", 1),))
        yield For("k", Affine(0), Affine(len(cells)), 1, (), (Store(Cell(LATER, turn), Cell(source, turn)),), (0, len(cells) - 1))


def _driven(program: Program, scene: Scene, view: Scene) -> Program:
    """The factorisation with its inputs made of the scene's own and of f_0."""
    places, push = {name: i for i, name in enumerate(scene.u_names)}, push_of(scene, view)
    body: list[Statement] = []
    for i, name in enumerate(view.u_names):
        value: Operand = Cell("u", Affine(places[name])) if name in places else Const(Fraction(0))
        if i in push:
            body.append(Op(f"{_DRIVEN}_{i}", "add" if push[i] > 0 else "sub", (value, Cell(FORCE, Affine(0)))))
            value = Local(f"{_DRIVEN}_{i}")
        body.append(Store(Cell(_DRIVEN, Affine(i)), value))

    def read(operand: Operand) -> Operand:
        return Cell(_DRIVEN, operand.index) if isinstance(operand, Cell) and operand.array == "u" else operand

    q, v, *others = (array for array in program.inputs if array.name != "u")
    given = [Array("u", (scene.nu,), "inputs")] if scene.nu else []
    force = Array(FORCE, (1,), "the forcing at the step's start")
    return replace(
        program, inputs=(q, v, *given, force, *others), work=(*program.work, Array(_DRIVEN, (view.nu,))),
        body=(*body, *reading(program, read).body),
    )  # fmt: skip
