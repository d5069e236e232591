"""Each link's own units in the articulated sweeps: m (r / l)^2 of mass and l of length, which leave the fewest factors.

What link k passes on to link k - 1 changes units on the way; the conversion is folded into factors that are there anyway
and vanishes where links are alike. Link 0 keeps its own units.

Of a rigid link m r^2 is its second moment b and m r its first one, a (`body`): lambda = a l / b is then any number, zero too, and
lambda - 1 = (a l - b) / b.
"""

from __future__ import annotations

from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.chain.body import Bodies
from phichain.lowering.chain.parameters import Parameters
from phichain.scene import Scene


@dataclass(frozen=True)
class Factors:
    """What takes the results of a link into the units of the link before."""

    mass: ArrayRef
    axial: ArrayRef
    skew: ArrayRef
    lever: ArrayRef
    determinant: ArrayRef
    force: ArrayRef
    minor: ArrayRef
    minor_x: ArrayRef
    minor_force: ArrayRef


class LinkUnits:
    """Per-link numbers of the articulated sweeps.

    Attributes:
        leverage: lambda = l / r.
        overhang: lambda - 1 = (l - r) / r, structurally zero where every mass sits at its link's end.
        shortening: r / l, of points alone.
        mass_unit: m (r / l)^2, kg.
        inverse_mass_unit: 1 / mass_unit.
        inverse_torque: 1 / (m r^2), takes a couple into the link's units.
        mass: takes a mass from link k to link k - 1.
        length: takes a length or an acceleration from link k to link k - 1.
        leverage_step: lambda_k / lambda_{k-1}.
        outward: takes a length or an acceleration from link k - 1 to link k.
        torque_unit: m r^2.
        is_rigid: whether links are known by their moments.
    """

    def __init__(self, builder: Builder, scene: Scene, parameters: Parameters) -> None:
        self._parameters, self._builder = parameters, builder
        self.is_rigid = parameters.bodies is not None
        if parameters.bodies is not None:
            self._of_bodies(parameters.bodies)
        else:
            self._of_points(scene)

    @property
    def torque_unit(self) -> ArrayRef:
        bodies, mass, com = self._parameters.bodies, self._parameters.mass, self._parameters.com
        if bodies is not None:
            return bodies.second
        return self._parameters.derived("torque_unit", lambda k: mass[k] * com[k] * com[k])

    def _of_bodies(self, bodies: Bodies) -> None:
        parameters, length, over = self._parameters, self._parameters.length, bodies.over_second
        derived = parameters.derived
        of_length = derived("inverse_length", lambda k: 1 / length[k])
        self.leverage = derived("leverage", lambda k: length[k] * bodies.first[k] * over[k])
        self.overhang = derived("overhang", lambda k: bodies.lever[k] * over[k])
        self.inverse_torque = over
        self.mass_unit = mass_unit = derived("mass_unit", lambda k: bodies.second[k] * (of_length[k] * of_length[k]))
        self.inverse_mass_unit = of_mass_unit = derived("inverse_mass_unit", lambda k: over[k] * (length[k] * length[k]))
        self.mass = parameters.steps("mass_step", lambda k: mass_unit[k], lambda k: of_mass_unit[k])
        self.length = parameters.steps("length_step", lambda k: length[k], lambda k: of_length[k])
        self.outward = parameters.steps("outward_step", lambda k: of_length[k], lambda k: length[k])

    def _of_points(self, scene: Scene) -> None:
        parameters, builder = self._parameters, self._builder
        mass, length, com = parameters.mass, parameters.length, parameters.com
        derived, one = parameters.derived, builder.lift(1)
        # Of runtime parameters these three are all that is divided by: divisions are what such tables cost.
        of_mass = derived("inverse_mass", lambda k: 1 / mass[k])
        of_length = derived("inverse_length", lambda k: 1 / length[k])
        of_com = of_length if scene.com is None else derived("inverse_com", lambda k: 1 / com[k])
        self.leverage = leverage = derived("leverage", lambda k: one if scene.tip_masses else length[k] * of_com[k])
        self.shortening = shortening = derived("shortening", lambda k: one if scene.tip_masses else com[k] * of_length[k])
        self.overhang = derived("overhang", lambda k: (length[k] - com[k]) * of_com[k])
        self.inverse_torque = derived("inverse_torque", lambda k: of_mass[k] * of_com[k] * of_com[k])
        self.mass_unit = mass_unit = derived("mass_unit", lambda k: mass[k] * (shortening[k] * shortening[k]))
        self.inverse_mass_unit = of_mass_unit = derived("inverse_mass_unit", lambda k: of_mass[k] * (leverage[k] * leverage[k]))
        self.mass = parameters.steps("mass_step", lambda k: mass_unit[k], lambda k: of_mass_unit[k])
        self.length = parameters.steps("length_step", lambda k: length[k], lambda k: of_length[k])
        self.leverage_step = parameters.steps("leverage_step", lambda k: leverage[k], lambda k: shortening[k])
        self.outward = parameters.steps("outward_step", lambda k: of_length[k], lambda k: length[k])

    def product(self, name: str, *factors: ArrayRef) -> ArrayRef:
        """The product of per-link numbers."""
        first, *others = factors
        if not others:
            return first
        rest = self.product(f"{name}_rest", *others) if len(others) > 1 else others[0]
        return self._parameters.derived(name, lambda k: first[k] * rest[k])

    def factors(self) -> Factors:
        """Of all links."""
        product, levers = self.product, [self.leverage]
        skew = product("skew_step", self.mass, self.overhang)
        force = product("force_step", self.mass, self.length)
        if self.is_rigid:
            determinant = product("determinant_step", self.mass, self.mass)
            levers.append(self.leverage)
        else:
            determinant = product("determinant_step", self.mass, self.mass, self.leverage_step)
        minor = product("minor_step", determinant, self.length)
        return Factors(
            mass=self.mass,
            axial=product("axial_step", self.mass, self.leverage, self.leverage),
            skew=skew,
            lever=product("lever_step", skew, self.overhang),
            determinant=product("determinant_lever", determinant, self.overhang, self.overhang),
            force=force,
            minor=minor,
            minor_x=product("minor_lever", minor, self.overhang),
            minor_force=product("minor_leverage", minor, *levers),
        )
