"""Taylor recurrences: the Lagrangian's residual along the coefficients that they give vanishes as a truncated power series.

The recurrences are run in the field, sums formed exactly, 1/(n + 1) modular, in time scaled by a random rho. With
q(t), q'(t), q''(t) the series that come out, T, V and R are evaluated in power-series arithmetic with nilpotent directions
(`proof.lagrange`), and every coefficient of

    [d/dt dT/dx' - dT/dx + dV/dx].dx + dR/drate.eta - u.eta

must vanish, with q' the derivative of q and in space q.q = 1. Columns must be the derivatives of the recurrences themselves, which
run once more on dual numbers.

What rounding took from the state (`lost`) enters to first order. In the plane coefficients must change with it as they change with
the angles themselves, by dual numbers; where springs see a joint's own rounded angle, what a step holds must. In space springs alone look at it: with any `lost`, the residual must be that of springs bent by
q_{k-1} - q_k + r_k, r_k = lost_{k-1} - lost_k, which over a step is a constant force k_k r_k on link k and its opposite on the one before.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from phichain.ir.interpret import run
from phichain.lowering.planar.joint_state import loses_bends
from phichain.lowering.series.run import Expanded, expand_along, expand_column
from phichain.lowering.series.series import HELD, LEFT, RIGHT, ROWS
from phichain.lowering.series.spatial.side_by_side import expand_shared
from phichain.lowering.series.varied import varied_parameters
from phichain.proof.case import Wrong
from phichain.proof.identities.expansion import ORDERS, Recurrences, Start
from phichain.proof.lagrange import ENERGIES, Judge
from phichain.proof.modular.field import PRIME, Vector, dot, exact, inverse, plus
from phichain.proof.modular.points import Point
from phichain.proof.modular.power_series import Coefficients, Jet, PowerSeries


def recurrences(made: Recurrences, judge: Judge, point: Point) -> None:
    """Hold the recurrences at a point.

    Raises:
        Wrong: the motion they expand is not the Lagrangian's, that of trajectories side by side another one, or a column no derivative
            of it.
    """
    start = Start(made, judge, point)
    found = start.expanded(start.values())
    _consistent(judge, point, found)
    _no_residual(judge, point, found, start)
    if made.series.order_shared is not None:
        _shared(start, found)
    if made.series.outright is not None:
        _outright(start, found)
    if start.takes_lost:
        _lost(start)
    if made.columns is not None:
        _columns(start, found)
    if made.series.order_along is not None:
        _along(start, found)


def _consistent(judge: Judge, point: Point, found: Expanded) -> None:
    """q' is the derivative of q; unit vectors stay unit vectors."""
    size = point.scene.nq
    for n in range(ORDERS):
        for i in range(size):
            if ((n + 1) * found.state[n + 1][i] - found.state[n][size + i]) % PRIME:
                raise Wrong(f"next[{i}] at order {n}")
    if judge.scene.is_planar:
        return
    for first in range(point.carts, size, 3):
        links = [row[first : first + 3] for row in found.state]
        for n in range(1, ORDERS + 1):
            if sum(dot(links[j], links[n - j]) for j in range(n + 1)) % PRIME:
                raise Wrong(f"the length of next[{first}] to [{first + 2}] at order {n - 1}")


def _no_residual(judge: Judge, point: Point, found: Expanded, start: Start) -> None:
    """Lagrange and d'Alembert's principle along the series, in true time."""
    ring, size, over, (view, inputs) = PowerSeries(ORDERS, point.tanh, point.root), point.scene.nq, inverse(start.rho), start.inputs
    rows = [[row[i] for row in found.state] for i in range(2 * size)]
    q = [row[:ORDERS] for row in rows[:size]]
    rate = [[over * entry % PRIME for entry in row[:ORDERS]] for row in rows[size:]]
    square = over * over % PRIME
    second = [[square * (n + 1) % PRIME * row[n + 1] % PRIME for n in range(ORDERS)] for row in rows[size:]]
    told = point.carts if judge.scene.is_driven else 0
    turn = [*[0] * told, *point.tangent("turn")[told:]]
    still = [[entry, *[0] * (ORDERS - 1)] for entry in turn]
    shift, omega = still, rate
    if not judge.scene.is_planar:
        carts = point.carts
        shift = [*still[:carts], *_crossed(ring, still[carts:], q[carts:])]
        omega = [*rate[:carts], *_crossed(ring, q[carts:], rate[carts:])]
        # Dampers work along what stays across the links.
        still = [*still[:carts], *_crossed(ring, q[carts:], shift[carts:])]

    # Along time (a), along the virtual displacement as rates (b) and as a change of place (c).
    directions = {
        "a": {"q": rate, judge.rate: second},
        "b": {"v": still, judge.rate: shift},
        "c": {"q": shift},
    }
    held = [0] * (ORDERS - 1)
    base = {name: [[entry, *held] for entry in rates] for name, rates in judge.drift(point).items()}
    directions["a"] |= {name: inputs[: view.base_inputs] for name in base}
    arguments = {name: [ring.constant(entry) for entry in entries] for name, entries in point.parameters.items()}
    for name, series in {"q": q, "v": omega, judge.rate: rate, **base}.items():
        arguments[name] = []
        for i, entry in enumerate(series):
            parts = {"": entry} | {mark: rows[name][i] for mark, rows in directions.items() if name in rows}
            circle = point.circles[i] if judge.scene.is_planar and name == "q" else None
            arguments[name].append(Jet(parts, circle))
    energies = run(judge.energy_program, ring.algebra, arguments)
    kinetic, potential, dissipation = (energies[name][0].parts for name in ENERGIES)
    zeros = [0] * ORDERS
    work = [
        kinetic.get("m", zeros), [-x for x in kinetic.get("c", zeros)], potential.get("c", zeros), dissipation.get("b", zeros),
        *([_bent_further(start, shift[point.carts :])] if start.lost else []),
    ]  # fmt: skip
    _told(judge, point, second, inputs)
    push = [(inputs[view.base_accelerations + i], turn[at]) for i, at in enumerate(view.driven)]
    for n, entries in enumerate(zip(*work, strict=True)):
        if (sum(entries) - sum(force[n] * along for force, along in push)) % PRIME:
            raise Wrong(f"the accelerations of order {n}")


def _lost(start: Start) -> None:
    """What rounding took counts to first order: as a change of the angles, or of the bends of springs in space."""
    point = start.point
    size, lost = point.scene.nq, point.free("lost", 2 * point.scene.nq)
    if not point.scene.is_planar:
        bent = replace(start, lost=lost)
        found = bent.expanded(bent.values())
        _no_residual(bent.judge, point, found, bent)
        if start.made.series.order_shared is not None:
            _shared(bent, found)
        return

    def along(slopes: dict[str, Vector]) -> Expanded:
        return start.expanded(start.duals(), lambda name, values: list(zip(values, slopes.get(name, [0] * len(values)), strict=True)))

    # Of the rates nothing that rounding took is looked at.
    ours, true = along({"lost": lost}), along({"q": lost[:size]})
    named = {f"next[{{}}] at order {n}": (ours.state[n + 1], true.state[n + 1]) for n in range(ORDERS)}
    if point.scene.stiffness is not None and not loses_bends(point.scene):
        # Springs see a joint's angle as it is rounded: its last digit is theirs. What a step holds is left, the rows 0 with it.
        named = {"held[{}]": (ours.held, true.held), "left[{}]": (ours.left[0], true.left[0]), "right[{}]": (ours.right[0], true.right[0])}
    for name, (changed, known) in named.items():
        for i, ((_, entry), (_, slope)) in enumerate(zip(changed, known, strict=True)):
            if (entry - slope) % PRIME:
                raise Wrong(f"{name.format(i)} with what rounding took")


def _bent_further(start: Start, shift: list[Coefficients]) -> Coefficients:
    """Minus the work of k_k r_k along the displacement of both links of every joint, order by order."""
    scene, lost = start.point.scene, start.lost[start.point.carts :]
    numbers = scene.stiffness
    assert numbers is not None
    stiffness = start.point.parameters["stiffness"] if numbers == "runtime" else [exact(Fraction(entry)) for entry in numbers]
    work = [0] * ORDERS
    for i in range(3 * scene.links):
        before = i - 3
        rest = (lost[before] if before >= 0 else 0) - lost[i]
        moved = plus(shift[i], shift[before], -1) if before >= 0 else shift[i]
        work = plus(work, moved, -(stiffness[i // 3] * rest))
    return work


def _told(judge: Judge, point: Point, second: list[Coefficients], inputs: list[Coefficients]) -> None:
    """A cart that is driven by its acceleration has x'' = u."""
    for axis in range(point.carts if judge.scene.is_driven else 0):
        for n, entry in enumerate(second[axis]):
            if (entry - inputs[axis][n]) % PRIME:
                raise Wrong(f"the cart's acceleration of order {n}")


def _crossed(ring: PowerSeries, a: list[Coefficients], b: list[Coefficients]) -> list[Coefficients]:
    """a_k x b_k for every link."""
    found: list[Coefficients] = []
    for k in range(0, len(a), 3):
        for i in range(3):
            one, other = (i + 1) % 3 + k, (i + 2) % 3 + k
            found.append(plus(ring.times(a[one], b[other]), ring.times(a[other], b[one]), -1))
    return found


def _shared(start: Start, base: Expanded) -> None:
    """Trajectories side by side have the coefficients of one."""
    found = expand_shared(start.made.series, start.values(), ORDERS, rho=Fraction(start.rho), **start.given)
    for n, (row, true) in enumerate(zip(found, base.state, strict=True)):
        for i, (entry, known) in enumerate(zip(row, true, strict=True)):
            if (entry - known) % PRIME:
                raise Wrong(f"next[{i}] at order {n - 1} of trajectories side by side")


def _outright(start: Start, base: Expanded) -> None:
    """Orders that come all at once are those that come one by one."""
    assert start.made.series.outright is not None
    size = len(base.state[0])
    highest = start.made.series.outright.outputs[-1].size // size - 1
    long = start.expanded(start.values(), orders=highest)
    given = {HELD: long.held, RIGHT: long.right[0], "slope": long.state[1]}
    made = start.values().run(start.made.series.outright, given)
    for name, rows in ((LEFT, long.left), ("rates", long.right)):
        width = len(rows[0])
        for i, entry in enumerate(made.get(name, ())):
            if (entry - rows[i // width][i % width]) % PRIME:
                raise Wrong(f"{name}[{i % width}] of order {i // width}, all at once")
    found = made[ROWS]
    for n, true in enumerate(long.state):
        for i, known in enumerate(true):
            moved = 0 if n == 0 and i < start.point.scene.nq else known
            if (found[size * n + i] - moved) % PRIME:
                raise Wrong(f"rows[{i}] of order {n}, all at once")


def _columns(start: Start, base: Expanded) -> None:
    """Along a variation that is tangent to the states, columns are what dual numbers give."""
    point = start.point
    dq, dv = _tangent(start)
    found = expand_column(start.made.series, start.values(), base, dq, dv, **point.parameters)
    slopes = {"q": dq, "v": dv}
    true = start.expanded(
        start.duals(),
        lambda name, values: list(zip(values, slopes.get(name, [0] * len(values)), strict=True)),
    )
    for n, (row, pairs) in enumerate(zip(found.state, true.state, strict=True)):
        for i, (entry, (_, slope)) in enumerate(zip(row, pairs, strict=True)):
            if (entry - slope) % PRIME:
                raise Wrong(f"a column's next[{i}] at order {n - 1}")


def _along(start: Start, base: Expanded) -> None:
    """Along a variation of state, parameters and forcing, columns are what dual numbers give."""
    point = start.point
    (dq, dv), varied = _tangent(start), varied_parameters(point.scene)
    moved = {name: point.free(f"d_{name}", len(point.parameters[name])) for name in varied}
    d_force = point.free("d_force", ORDERS) if start.made.series.is_forced else []
    found = expand_along(start.made.series, start.values(), base, dq, dv, moved, d_force, **point.parameters)
    slopes = {"q": dq, "v": dv, "force": d_force, **moved}
    true = start.expanded(
        start.duals(),
        lambda name, values: list(zip(values, slopes.get(name, [0] * len(values)), strict=True)),
    )
    for n, (row, pairs) in enumerate(zip(found.state, true.state, strict=True)):
        for i, (entry, (_, slope)) in enumerate(zip(row, pairs, strict=True)):
            if (entry - slope) % PRIME:
                raise Wrong(f"next[{i}] at order {n - 1} of a derivative by parameters")


def _tangent(start: Start) -> tuple[Vector, Vector]:
    """(dq, dv) with q.dq = 0 and q.dv + v.dq = 0 for every link."""
    point, judge, rate = start.point, start.judge, start.rate
    dq, dv = judge.turned(point, point.free("dq")), judge.turned(point, point.free("dv"))
    if judge.scene.is_planar:
        return dq, dv
    for k in range(point.carts, point.scene.nq, 3):
        at = slice(k, k + 3)
        dv[at] = plus(dv[at], point.q[at], -dot(rate[at], dq[at]))
    return dq, dv
