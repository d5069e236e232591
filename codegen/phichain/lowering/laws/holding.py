"""How a chain is held at the target of a trajectory by an observer that has found out its parameters, as a Program."""

from __future__ import annotations

from fractions import Fraction

from phichain.ir.builder import Builder, Expr
from phichain.ir.handles import ArrayRef
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.ir.piecewise import maximum, minimum, wrapped
from phichain.laws import TrajectoryLaw
from phichain.lowering.laws.state_feedback import full_turn, limited
from phichain.lowering.laws.still import pulled


def held_sizes(law: TrajectoryLaw) -> dict[str, int]:
    """What `held` is made of, in its order: name and count of numbers."""
    nx, nu, nq = law.states.shape[1], law.inputs.shape[1], law.measured
    learning = law.observer.learning if law.observer else None
    count = learning.count if learning else 0
    return {
        "target": nq, "rest": nu, "K": nu * nx, "half": nq, "inside": nx * nq, "outside": nx * nq, "F": nq * nx, "G": nq * nu,
        "bends": count * nq * (nx + nu),
    }  # fmt: skip


def holding(law: TrajectoryLaw) -> Program:
    """`holding(y_meas, expected, held) -> u, off, following`: one call at the target.

    With e = w(y_meas - q_target - C expected), c = clip(e, -q/2, q/2) and theta the end of `expected`,

        z   = expected + L_in c + L_out (e - c),    u = clip(u_target - K z, low, high),
        z_v' = z_v + (F + sum_k theta_k F_k) z + (G + sum_k theta_k G_k) (u - u_target),    z_q' = z_q + T (z_v + z_v') / 2.

    `held` is what `held_sizes` names, matrices row by row and `half` the halves of the steps. Readings that stay count in `off` too, see `still`.
    """
    catch = law.catch
    nx, nu, nq = law.states.shape[1], law.inputs.shape[1], law.measured
    builder = Builder("holding", f"Inputs of {law.name} at its target, and how far off its angles are.")
    measured = builder.input("y_meas", (nq,), "measured positions, q")
    expected = builder.input("expected", (law.remembered,), "deviation that was expected, and errors of parameters")
    sizes = held_sizes(law)
    held = builder.input("held", (sum(sizes.values()),), "target, gains and observer")
    inputs, off = builder.output("u", (nu,), "inputs"), builder.output("off", (), "squares of the angles' deviations, rad^2")
    kept = builder.output("following", (law.remembered,), "what is expected at the next call")
    starts = dict(zip(sizes, (sum(list(sizes.values())[:k]) for k in range(len(sizes))), strict=True))

    def at(part: str, i: int) -> Expr:
        return held[starts[part] + i]

    square, inner, outer = builder.lift(Fraction(0)), [], []
    for i in range(nq):
        name = catch.state_names[i]
        away = _less_turns(builder, f"{name}_away", measured[i] - at("target", i), catch.wraps[i])
        square = square + away * away if catch.wraps[i] else square
        apart = _less_turns(builder, f"{name}_apart", away - expected[i], catch.wraps[i])
        half = at("half", i)
        inner.append(builder.let(f"{name}_within", minimum(maximum(apart, -half), half)))
        outer.append(builder.let(f"{name}_beyond", apart - inner[i]))
    z = [
        builder.let(f"{catch.state_names[i]}_off", _sum(expected[i], [(at("inside", i * nq + j), inner[j]) for j in range(nq)] + [(at("outside", i * nq + j), outer[j]) for j in range(nq)]))
        for i in range(nx)
    ]  # fmt: skip
    pushed = []
    for row in range(nu):
        rest = at("rest", row)
        wanted = rest
        for i in range(nx):
            wanted = wanted - at("K", row * nx + i) * z[i]
        inputs[row] = u = builder.let(f"{catch.input_names[row]}_held", limited(wanted, catch.low[row], catch.high[row]))
        pushed.append(builder.let(f"{catch.input_names[row]}_pushed", u - rest))
    still, strain = pulled(builder, law, measured, expected, z)
    off[0] = square + strain
    for i, value in enumerate([*_following(builder, law, z, pushed, expected, at), *still]):
        kept[i] = value
    return prune(builder.finish())


def _following(builder: Builder, law: TrajectoryLaw, z: list[Expr], pushed: list[Expr], expected: ArrayRef, at: object) -> list[Expr]:
    """What is expected at the next call: places, rates, and the errors of parameters as they are."""
    assert callable(at)
    nx, nu, nq = law.states.shape[1], law.inputs.shape[1], law.measured
    assert law.observer is not None
    theta = [expected[k] for k in range(nx, law.observer.estimated)]
    rates = []
    for i in range(nq):
        rate = _sum(z[nq + i], [(at("F", i * nx + j), z[j]) for j in range(nx)] + [(at("G", i * nu + j), pushed[j]) for j in range(nu)])
        for k, error in enumerate(theta):
            row = (k * nq + i) * (nx + nu)
            bent = _sum(at("bends", row) * z[0], [(at("bends", row + j), value) for j, value in enumerate([*z, *pushed]) if j])
            rate = rate + error * bent
        rates.append(builder.let(f"{law.catch.state_names[nq + i]}_next", rate))
    half = Fraction(law.catch.sample) / 2
    return [*(z[i] + half * (z[nq + i] + rates[i]) for i in range(nq)), *rates, *theta]


def _less_turns(builder: Builder, name: str, value: Expr, turns: bool) -> Expr:
    return builder.let(name, wrapped(value, full_turn()) if turns else value)


def _sum(first: Expr, products: list[tuple[Expr, Expr]]) -> Expr:
    for gain, value in products:
        first = first + gain * value
    return first
