"""Single-harmonic balance Phi (theory section 6) for any number of links, from the kernels that harmonic/ projects symbolically.

For x = X cos wt, theta = A cos wt, B = S A and D = B_i - B_j,

    Phi_i(phi) = w^2 sum_j c_ij (s(D) B_j^2 - a(D) B_j) - w^2 mu_i a(B_i) X + g mu_i h(B_i)
    Phi_0      = -w^2 (M00 X + sum_j mu_j (a(B_j) B_j + s(B_j) B_j^2)),      Phi(theta) = S^T Phi(phi) + stiffness - w^2 rotors

with the acceleration kernel a (even, a(0) = 1), the centripetal kernel s (odd) and the gravity kernel h. Pairs i < j serve
both rows.
"""

from __future__ import annotations

from phichain.harmonic import Kernels, kernels
from phichain.ir.builder import ArrayRef, Builder, Expr
from phichain.ir.from_sympy import from_sympy
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.joints import absolute, difference, to_generalised
from phichain.lowering.writers import writes
from phichain.scene import Scene


@writes("phi")
def phi(
    builder: Builder, scene: Scene, parameters: Parameters, amplitude: ArrayRef, omega: ArrayRef, out: ArrayRef
) -> None:
    """Write Phi (nv) of the amplitudes [X, A_1..A_N] at angular frequency omega."""
    projected = kernels()
    links, offset = scene.links, int(scene.has_cart)
    own = amplitude.shifted(offset)
    swing = absolute(builder, scene, "swing", own)
    squared = builder.let("omega_squared", omega[0] * omega[0])
    even, odd = _pair_kernels(builder, scene, projected, swing)
    mu, length = parameters.mu, parameters.length
    row = builder.array("row", links)
    with builder.loop("i", 0, links) as rows:
        i = rows.index
        with builder.loop("j", 0, i) as columns:
            j = columns.index
            inner = columns.carry("inner", 0)
            pair = j * links + i
            columns.follow(inner, inner - length[j] * (even[pair] * swing[j] + odd[pair] * (swing[j] * swing[j])))
        with builder.loop("j", i + 1, links) as columns:
            j = columns.index
            outer = columns.carry("outer", 0)
            pair = i * links + j
            columns.follow(outer, outer - mu[j] * (even[pair] * swing[j] - odd[pair] * (swing[j] * swing[j])))
        balance = mu[i] * inner + length[i] * outer - parameters.c_diagonal[i] * swing[i]
        if scene.has_cart:
            own_kernel = from_sympy(builder, projected.acceleration, {projected.difference: swing[i]})
            balance = balance - mu[i] * (own_kernel * amplitude[0])
        fall = from_sympy(builder, projected.gravity, {projected.amplitude: swing[i]})
        row[i] = squared * balance + parameters.gravity * mu[i] * fall
    to_generalised(builder, scene, _with_joints(builder, scene, parameters, squared, own, row), out.shifted(offset))
    if scene.has_cart:
        out[0] = squared * _cart_balance(builder, scene, parameters, projected, swing, amplitude[0])


def _pair_kernels(builder: Builder, scene: Scene, kernels: Kernels, swing: ArrayRef) -> tuple[ArrayRef, ArrayRef]:
    """Acceleration and centripetal kernels at B_i - B_j for i < j."""
    links = scene.links
    even, odd = builder.array("acceleration_kernel", links * links), builder.array("centripetal_kernel", links * links)
    with builder.loop("i", 0, links) as rows, builder.loop("j", rows.index + 1, links) as columns:
        i, j = rows.index, columns.index
        apart = builder.let("apart", swing[i] - swing[j])
        even[i * links + j] = from_sympy(builder, kernels.acceleration, {kernels.difference: apart})
        odd[i * links + j] = from_sympy(builder, kernels.centripetal, {kernels.difference: apart})
    return even, odd


def _with_joints(
    builder: Builder, scene: Scene, parameters: Parameters, squared: Expr, own: ArrayRef, row: ArrayRef
) -> ArrayRef:
    """Rows in phi with the moments of springs and rotors, (stiffness - w^2 armature) times the joints' amplitudes."""
    stiffness, armature = parameters.stiffness, parameters.armature
    if stiffness is None and armature is None:
        return row
    nothing = builder.lift(0)
    joint = difference(builder, scene, "joint_amplitude", own)
    total = builder.array("row_with_springs", scene.links)
    with builder.loop("k", scene.links - 1, -1, -1) as loop:
        k = loop.index
        beyond = loop.carry("spring_beyond", 0)
        held = nothing if stiffness is None else stiffness[k]
        if armature is not None:
            held = held - squared * armature[k]
        moment = builder.let("spring_moment", held * joint[k])
        total[k] = row[k] + (moment - beyond)
        loop.follow(beyond, moment)
    return total


def _cart_balance(
    builder: Builder, scene: Scene, parameters: Parameters, kernels: Kernels, swing: ArrayRef, cart: Expr
) -> Expr:
    start = -(parameters.total_mass * cart)
    with builder.loop("j", 0, scene.links) as loop:
        j = loop.index
        total = loop.carry("cart_balance", start)
        even = from_sympy(builder, kernels.acceleration, {kernels.difference: swing[j]})
        odd = from_sympy(builder, kernels.centripetal, {kernels.difference: swing[j]})
        lean = even * swing[j] + odd * (swing[j] * swing[j])
        loop.follow(total, total - parameters.mu[j] * lean)
    return total
