"""The derivatives of the spatial accelerations along the unit vectors' spheres, and the accelerations themselves (theory, section 5)."""

from __future__ import annotations

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.dynamics import in_units_of_links
from phichain.lowering.parameters import Parameters
from phichain.lowering.spatial import mobilities, tension
from phichain.lowering.spatial.jacobian.columns import Columns
from phichain.lowering.spatial.jacobian.end_masses import EndMasses
from phichain.lowering.spatial.jacobian.free_masses import FreeMasses
from phichain.lowering.spatial.jacobian.response import Answers
from phichain.lowering.spatial.links import directions
from phichain.lowering.spatial.rates import AngularVelocities
from phichain.lowering.writers import writes
from phichain.scene import Scene

#: Up to this ratio of what hangs beyond a link to the link's own mass no digit is lost where the masses are at the ends.
_LARGEST_LOAD = 32


def suits(scene: Scene) -> bool:
    """Whether the forms here serve a scene without springs and dampers, and keep its digits.

    A disturbance of a link is answered by forces of the order of all that hangs beyond it, which a light link has to cancel; the
    differentiated tensions keep every digit whatever the masses are.
    """
    if scene.stiffness is not None or scene.damping is not None:
        return False
    if not scene.tip_masses:
        return mobilities.suits(scene) and _is_even(scene)
    return _is_even(scene)


def _is_even(scene: Scene) -> bool:
    """Whether no link is much lighter than what is beyond it; all masses must be known."""
    if isinstance(scene.mass, str):
        return False
    return all(sum(scene.mass[k + 1 :]) <= _LARGEST_LOAD * mass for k, mass in enumerate(scene.mass))


@writes("state_jacobian", space="spatial", own_units=in_units_of_links, suits=suits)
def state_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, dadq: ArrayRef, dadv: ArrayRef,
    u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The derivatives alone."""
    derivatives(builder, scene, parameters, q, v, u, builder.array("a_value", scene.nv), dadq, dadv, dadu)


@writes("dynamics_and_jacobian", space="spatial", own_units=in_units_of_links, suits=suits)
def dynamics_and_jacobian(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, a: ArrayRef, dadq: ArrayRef,
    dadv: ArrayRef, u: ArrayRef | None = None, dadu: ArrayRef | None = None,
) -> None:  # fmt: skip
    """The accelerations, and their derivatives."""
    derivatives(builder, scene, parameters, q, v, u, a, dadq, dadv, dadu)


def derivatives(
    builder: Builder, scene: Scene, parameters: Parameters, q: ArrayRef, v: ArrayRef, u: ArrayRef | None, a: ArrayRef,
    dadq: ArrayRef, dadv: ArrayRef, dadu: ArrayRef | None,
) -> None:  # fmt: skip
    """Write the accelerations and their derivatives."""
    rates = AngularVelocities(scene, v, a)
    answers: Answers
    if scene.tip_masses:
        found = tension.accelerations(builder, scene, parameters, q, rates, u)
        answers = EndMasses(builder, scene, parameters, q, found)
    else:
        answers = sweep = FreeMasses(builder, scene, parameters, q, rates)
        mobilities.solve(sweep, builder, scene, parameters, rates, u)
    base = answers.base(parameters.cart_mass) if scene.has_cart else None
    columns = Columns(
        builder, scene, answers, directions(scene, v), directions(scene, a), parameters, dadq, dadv, dadu
    )  # fmt: skip
    columns.write(base)
