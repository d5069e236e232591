"""The variational integrator of Lee, Leok & McClamroch (2009) for chains of unit vectors, in (q, v) form: theory section 8.

The discrete Lagrangian of z = [x, q_1 .. q_N] (unit vectors in the plane, too) with the constant inertia M on vectors,

    L_d = |z_1 - z_0|_M^2 / (2 h) - h/2 (V(z_0) + V(z_1)),   forces h/2 F at either end,

gives a map (z_0, z_0') -> (z_1, z_1') through both discrete Legendre transforms:

    w = z_0' + h/2 a,          M a = F_0 - dV_0 + lambda q_0,    |q_0 + h w|^2 = 1       (N unknown lambda: Newton)
    z_1 = z_0 + h w
    z_1' = w + h/2 a_1,      M a_1 = F_1 - dV_1 + kappa q_1,     q_1.z_1' = 0            (linear)

Both lines of multipliers are one call of `constrained_accelerations` an iteration; the second asks for q_1.a_1 = -|w|^2. Newton's method
on q.a + |w|^2 = 0, w = z_0' + h/2 a, asks for (q + h w).a_next = h w.a - |w|^2. Dampers and dry friction act through the
rates at either end, z_0' and 2 w - z_0' = z_1' + O(h^2).

Rotors at the joints of a planar chain turn with the angles themselves: sum_k A_k (d phi_k - d phi_{k-1})^2 / (2 h) in L_d, d phi_k the
angle that link k turns by over the step, found from its vectors and never as a difference of two angles. Their couples are those of
accelerations 2 (d phi - h phi') / h^2 at the start and 2 (h phi_1' - d phi) / h^2 at the end, which differ from the tangential ones of
the vectors by a lead of order h; Newton's method has the lead of its guess, whose derivative along the tangent is zero.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from phichain.ir.builder import ArrayRef, Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.lowering.algebra.unit_vectors import ambient_size, cart_size, dimension
from phichain.lowering.algebra.vector import add, dot, multiple, named
from phichain.lowering.chain.base import carried
from phichain.lowering.chain.losses import brakes_cart, slows_joints
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar import joints as planar_joints
from phichain.lowering.steps.ambient import Ambient, has_couples, has_push, tangent
from phichain.lowering.steps.articulated_links import sweep
from phichain.lowering.steps.geared_links import geared_sweep
from phichain.lowering.steps.link_multipliers import Links, tensions
from phichain.lowering.writers import helps, writes
from phichain.scene import Scene

#: Newton steps: their errors go as a^(2^n - 1) with a = h^2 |q''| / 4, small however fast a link turns steadily.
ITERATIONS = 5
#: Added to the squared residual so that its root has a derivative at rest; far below round-off, in single precision too.
_LEAST = Fraction(1, 2**126)
_HALF = Fraction(1, 2)


@writes("step_variational", calls=("constrained_accelerations",))
def step(
    builder: Builder, scene: Scene, parameters: Parameters, solver: Program, **arguments: ArrayRef
) -> None:
    """Write q_next, v_next and residual."""
    _Step(builder, scene, parameters, solver, arguments).run()


@helps(
    "constrained_accelerations", "Accelerations with prescribed components, by multipliers along the unit vectors.", lumped=True
)
def constrained_accelerations(builder: Builder, scene: Scene, parameters: Parameters) -> None:
    """Declare the arguments of one Newton step, linearise the links' lengths, and solve for its accelerations."""
    size, links = ambient_size(scene), scene.links
    h = builder.input("step", (1,), "step, s")[0]
    place = builder.input(
        "place", (size,), "position of the cart and unit vectors, along which the multipliers act"
    )
    rate = builder.input("rate", (size,), "their rates")
    guess = builder.input("guess", (size,), "accelerations to linearise at")
    lead = couple = None
    if scene.armature is not None:
        lead = builder.input("lead", (links,), "what the joints' rotors are accelerated by beside the vectors")
    if has_couples(scene):
        couple = builder.input("force", (dimension(scene) * links,), "forces conjugate to the unit vectors")
    push = moved = None
    if has_push(scene):
        own = ("push", cart_size(scene), "horizontal force on the cart") if brakes_cart(scene) else ("u", scene.nu, "inputs")
        u = builder.input(own[0], (own[1],), own[2])
        push = tuple(u[i] for i in range(cart_size(scene)))
    elif scene.base_inputs:
        moved = builder.input("u", (scene.nu,), "inputs")
    out = builder.output("acceleration", (size,), "accelerations of the cart and of the unit vectors")
    vectors = Ambient(builder, scene, parameters)
    normal, along = builder.array("normal", size), builder.array("along", links)
    with builder.loop("k", 0, links) as loop:
        k = loop.index
        turning = vectors.at(guess, k)
        speed = named(builder, "speed", add(vectors.at(rate, k), multiple(_HALF * h, turning)))
        vectors.put(normal, k, add(vectors.at(place, k), multiple(h, speed)))
        along[k] = h * dot(speed, turning) - dot(speed, speed)
    base = carried(builder, scene, parameters, moved)
    base.write_cart(out)
    place, normal, out = (base.seen(array) for array in (place, normal, out))
    solve = sweep if scene.armature is None else geared_sweep
    (tensions if scene.tip_masses and scene.armature is None else solve)(
        Links(builder, base.scene, base.parameters, place, normal, along, couple, push, out, lead)
    )


class _Step:
    """The step being written: `run` is the whole of it."""

    def __init__(
        self,
        builder: Builder,
        scene: Scene,
        parameters: Parameters,
        solver: Program,
        arguments: dict[str, ArrayRef],
    ) -> None:
        self.builder, self.scene, self.solver, self.arguments = builder, scene, solver, arguments
        self.u, self.h = arguments.get("u"), arguments["h"][0]
        self.vectors = Ambient(builder, scene, parameters)
        self.place = self.vectors.place("", arguments["q"])
        self.rate = self.vectors.rate(self.place, arguments["v"])
        if scene.armature is not None:
            self.spin = planar_joints.absolute(builder, scene, "spin_before", arguments["v"].shifted(self.vectors.cart))
        self.half, self.moved = (builder.array(name, ambient_size(scene)) for name in ("half_rate", "moved"))

    def run(self) -> None:
        """Write q_next, v_next and residual."""
        builder, vectors, arguments = self.builder, self.vectors, self.arguments
        force = vectors.couple(arguments["q"], arguments["v"], self.place, self.u, "force")
        push = vectors.push(arguments["v"], self.u, "push")
        step, acceleration = self._scalar("step", self.h), builder.array("guess", ambient_size(self.scene))
        with builder.loop("i", 0, ambient_size(self.scene)) as loop:
            acceleration[loop.index] = 0
        for _ in range(ITERATIONS):
            lead = self._lead_at(acceleration)
            acceleration = self._solve((step, self.place, self.rate, acceleration), lead, force, push)
        self._drift(acceleration)
        way = self._way()
        arrived = builder.array("arrived", self.scene.nq)
        turned = vectors.arrive(arguments["q"], self.place, self.moved, arrived, way)
        with builder.loop("i", 0, self.scene.nq) as loop:
            arguments["q_next"][loop.index] = arrived[loop.index]
        place = vectors.place("_next", arrived)
        predicted = self._predicted(place)
        force = vectors.couple(arrived, predicted, place, self.u, "force_next")
        push = vectors.push(predicted, self.u, "push_next")
        # Newton's step of no length asks for q.a = -|w|^2: the links' rates shall be tangent.
        still = (self._scalar("no_step", 0), place, self.half, acceleration)
        acceleration = self._solve(still, self._lead_of(place, turned), force, push)
        rate = builder.array("rate_next", ambient_size(self.scene))
        with builder.loop("i", 0, ambient_size(self.scene)) as loop:
            rate[loop.index] = self.half[loop.index] + _HALF * self.h * acceleration[loop.index]
        vectors.write_rates(rate, place, arguments["v_next"], "next")

    def _scalar(self, name: str, value: Expr | int) -> ArrayRef:
        array = self.builder.array(name, 1)
        array[0] = value
        return array

    def _solve(
        self, start: tuple[ArrayRef, ...], lead: ArrayRef | None, force: ArrayRef | None, push: ArrayRef | None
    ) -> ArrayRef:
        """Accelerations for the step, the place, the rate and the guess of `start`."""
        moved = self.u if push is None and self.scene.base_inputs else None
        given = [*start, *(array for array in (lead, force, push, moved) if array is not None)]
        (acceleration,) = self.builder.call(self.solver, given, {"acceleration": ambient_size(self.scene)})
        return acceleration

    def _lead_at(self, guess: ArrayRef) -> ArrayRef | None:
        """Of a guess: 2 (d phi - h phi') / h^2, less what its vectors are accelerated by along the tangent where they end."""
        if self.scene.armature is None:
            return None
        builder, h, vectors = self.builder, self.h, self.vectors
        reached, way = (builder.array(name, ambient_size(self.scene)) for name in ("reached", "way"))
        beta = builder.array("beta_guess", self.scene.links)
        with builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            turning = vectors.at(guess, k)
            speed = add(vectors.at(self.rate, k), multiple(_HALF * h, turning))
            onwards = named(builder, "onwards", multiple(h, speed))
            there = named(builder, "there", add(vectors.at(self.place, k), onwards))
            vectors.put(way, k, onwards)
            vectors.put(reached, k, there)
            beta[k] = dot(tangent(there), turning) / dot(there, there)
        turned = vectors.turned(self.place, reached, way)
        spin = self.spin
        return self._against(lambda k: self._per_square() * (turned[k] - h * spin[k]) - beta[k])

    def _way(self) -> ArrayRef | None:
        """h w, where rotors ask for the digits of small turns."""
        if self.scene.armature is None:
            return None
        way = self.builder.array("way", ambient_size(self.scene))
        with self.builder.loop("i", 0, ambient_size(self.scene)) as loop:
            way[loop.index] = self.h * self.half[loop.index]
        return way

    def _lead_of(self, place: ArrayRef, turned: ArrayRef | None) -> ArrayRef | None:
        """At the end: 2 (h t.w - d phi) / h^2."""
        if turned is None or self.scene.armature is None:
            return None
        half, vectors = self.half, self.vectors
        return self._against(
            lambda k: self._per_square() * (self.h * dot(tangent(vectors.at(place, k)), vectors.at(half, k)) - turned[k])
        )

    def _per_square(self) -> Expr:
        """2 / h^2."""
        return 2 / (self.h * self.h + _LEAST)

    def _against(self, own: Callable[[Index], Expr]) -> ArrayRef:
        """What every link has beyond the one before it."""
        lead = self.builder.array("lead", self.scene.links)
        with self.builder.loop("k", 0, self.scene.links) as loop:
            before = loop.carry("lead_before", 0)
            value = self.builder.let("link_lead", own(loop.index))
            lead[loop.index] = value - before
            loop.follow(before, value)
        return lead

    def _drift(self, acceleration: ArrayRef) -> None:
        """Write w, z_0 + h w, and the norm of |q_k + h w_k|^2 - 1 = h^2 (q_k.a_k + |w_k|^2), formed without subtracting the one."""
        builder, h, vectors = self.builder, self.h, self.vectors
        for i in range(vectors.cart):
            slide = self.rate[i] + _HALF * h * acceleration[i]
            self.half[i] = slide
            self.moved[i] = self.place[i] + h * slide
        with builder.loop("k", 0, self.scene.links) as loop:
            k = loop.index
            total = loop.carry("squared_error", 0)
            here, turning = vectors.at(self.place, k), vectors.at(acceleration, k)
            speed = named(builder, "speed", add(vectors.at(self.rate, k), multiple(_HALF * h, turning)))
            vectors.put(self.half, k, speed)
            vectors.put(self.moved, k, add(here, multiple(h, speed)))
            error = builder.let("length_error", h * h * (dot(here, turning) + dot(speed, speed)))
            loop.follow(total, total + error * error)
        self.arguments["residual"][0] = builder.sqrt(total + _LEAST)

    def _predicted(self, place: ArrayRef) -> ArrayRef:
        """v at the end to second order, which dampers look at."""
        builder, size = self.builder, ambient_size(self.scene)
        if not (slows_joints(self.scene) or brakes_cart(self.scene)):
            return self.arguments["v"]
        ahead = builder.array("rate_ahead", size)
        with builder.loop("i", 0, size) as loop:
            ahead[loop.index] = 2 * self.half[loop.index] - self.rate[loop.index]
        predicted = builder.array("v_predicted", self.scene.nv)
        self.vectors.write_rates(ahead, place, predicted, "predicted")
        return predicted
