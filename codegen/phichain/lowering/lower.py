"""Model -> Programs: which lowering serves which function of which scene, and whether it becomes loops or straight-line code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal

from phichain.contract.functions import FLOWS
from phichain.harmonic import kernels
from phichain.ir.builder import ArrayRef, Builder
from phichain.ir.nodes import Array, Program
from phichain.ir.passes import prune, total_operations, unroll
from phichain.lowering import harmonic_balance
from phichain.lowering.parameters import Parameters
from phichain.lowering.planar import (
    articulated as planar_articulated,
)
from phichain.lowering.planar import (
    functions as planar_functions,
)
from phichain.lowering.planar import (
    tension as planar_tension,
)
from phichain.lowering.planar.joints import planar_state
from phichain.lowering.spatial import (
    articulated as spatial_articulated,
)
from phichain.lowering.spatial import (
    functions as spatial_functions,
)
from phichain.lowering.spatial import (
    rates as spatial_rates,
)
from phichain.lowering.spatial import (
    tension as spatial_tension,
)
from phichain.lowering.steps import lie4 as step_lie4
from phichain.lowering.steps import rosenbrock
from phichain.lowering.steps import variational as step_variational
from phichain.lowering.steps.runge_kutta import runge_kutta
from phichain.scene import Scene, given_scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian

#: What the sweeps compute, in units of their own where they solve for tensions.
_BY_SWEEPS = ("forward_dynamics", "direction_dynamics")
#: Above this many operations `auto` keeps loops: beyond it compilers do better with loops that they can vectorise.
UNROLL_LIMIT = 600
#: The same for Jacobians: straight-line code leaves out the zeros that loops compute, but takes longer to compile.
JACOBIAN_UNROLL_LIMIT = 2500


@dataclass(frozen=True)
class Lowered:
    """The Programs of a scene: the wanted functions, the helpers they call, and the runtime parameters of all.

    What runs over many steps (`FLOWS`) is no Program: `emit.flows` writes it around Programs of its own.
    """

    wanted: MappingProxyType[str, Program]
    helpers: MappingProxyType[str, Program]
    params: tuple[Array, ...]

    def __str__(self) -> str:
        return "\n\n".join(str(program) for program in (*self.wanted.values(), *self.helpers.values()))


def lower(scene: Scene) -> Lowered:
    """Lower every wanted function, and what those call.

    Raises:
        SceneError: What is given is no `Scene`.
    """
    lowering = _Lowering(given_scene(scene))
    wanted = {name: lowering.program(name) for name in scene.want if name not in FLOWS}
    called = {callee for program in wanted.values() for callee in program.callees}
    helpers = {name: lowering.program(name) for name in sorted(called - set(wanted))}
    return Lowered(MappingProxyType(wanted), MappingProxyType(helpers), lowering.params)


def lower_function(scene: Scene, name: str, code: Literal["auto", "unrolled", "loops"] = "auto") -> Program:
    """One function alone; `code` is "auto", "unrolled" or "loops"."""
    return _Lowering(replace(scene, code=code)).program(name)


class _Lowering:
    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._made: dict[str, Program] = {}

    @property
    def params(self) -> tuple[Array, ...]:
        """Fields of the struct of runtime parameters, the same for every function."""
        builder = Builder("params", "")
        Parameters(builder, self.scene)
        return builder.finish().params

    def program(self, name: str) -> Program:
        if name not in self._made:
            self._made[name] = self.shaped(name, self.scene.code)
        return self._made[name]

    def shaped(self, name: str, code: str) -> Program:
        """Straight-line code or loops, by wish or by operation count."""
        if name in ("state_jacobian", "phi_jacobian"):
            return self._shaped_jacobian(name, code)
        loops = self.loops(name)
        if code == "loops" or (code == "auto" and total_operations(loops) > 2 * UNROLL_LIMIT):
            return loops
        flat = unroll(loops)
        if code == "unrolled" or total_operations(flat) <= UNROLL_LIMIT:
            return flat
        return loops

    def _shaped_jacobian(self, name: str, code: str) -> Program:
        function, blocks, doc = self._jacobian_blocks(name)
        with_loops = jacobian(self.loops(function), name, doc, blocks)
        if code == "loops" or (code == "auto" and total_operations(with_loops) > 4 * JACOBIAN_UNROLL_LIMIT):
            return with_loops
        flat = jacobian(unroll(self.loops(function)), name, doc, blocks)
        return flat if code == "unrolled" or total_operations(flat) <= JACOBIAN_UNROLL_LIMIT else with_loops

    def _jacobian_blocks(self, name: str) -> tuple[str, list[Block], str]:
        scene = self.scene
        if name == "phi_jacobian":
            columns = scene.nv + 1
            blocks = [Block("out", "amplitude", "out", 0, columns), Block("out", "omega", "out", scene.nv, columns)]
            return "phi", blocks, _DOC[name]
        arguments = ["q", "v", *(["u"] if scene.nu else [])]
        return "forward_dynamics", [Block("a", argument, f"dad{argument}") for argument in arguments], _DOC[name]

    def loops(self, name: str) -> Program:
        """The structured form of a function."""
        builder = Builder(name, _DOC[name])
        parameters = Parameters(builder, self.scene, own_units=name in _BY_SWEEPS and self._by_tensions)
        writer: Callable[[Builder, Parameters], None] = getattr(self, f"_{name}")
        writer(builder, parameters)
        return prune(builder.finish())

    @cached_property
    def _by_tensions(self) -> bool:
        """Whether forward dynamics solves for tensions; the articulated sweeps have units of their own."""
        return planar_tension.suits(self.scene) if self.scene.is_planar else self.scene.tip_masses

    # --- arguments ----------------------------------------------------------------------------------------------------

    def _q(self, builder: Builder) -> ArrayRef:
        return builder.input("q", (self.scene.nq,), "configuration")

    def _v(self, builder: Builder) -> ArrayRef:
        return builder.input("v", (self.scene.nv,), "rates")

    def _u(self, builder: Builder) -> ArrayRef | None:
        return builder.input("u", (self.scene.nu,), "inputs") if self.scene.nu else None

    @cached_property
    def _functions(self):  # type: ignore[no-untyped-def]
        return planar_functions if self.scene.is_planar else spatial_functions

    # --- one writer a function -----------------------------------------------------------------------------------------

    def _forward_dynamics(self, builder: Builder, parameters: Parameters) -> None:
        scene = self.scene
        q, v, u = self._q(builder), self._v(builder), self._u(builder)
        a = builder.output("a", (scene.nv,), "accelerations")
        if scene.is_planar:
            planar = planar_tension if self._by_tensions else planar_articulated
            planar.accelerations(builder, scene, parameters, planar_state(builder, scene, q, v), u, a)
        else:
            self._sweep(builder, parameters, q, spatial_rates.AngularVelocities(scene, v, a), u)

    def _direction_dynamics(self, builder: Builder, parameters: Parameters) -> None:
        scene, q = self.scene, self._q(builder)
        q_dot, u = builder.input("q_dot", (scene.nq,), "rate of q"), self._u(builder)
        q_ddot = builder.output("q_ddot", (scene.nq,), "second derivative of q")
        self._sweep(builder, parameters, q, spatial_rates.DirectionRates(builder, scene, q, q_dot, q_ddot), u)

    def _sweep(
        self, builder: Builder, parameters: Parameters, q: ArrayRef, rates: spatial_rates.Rates, u: ArrayRef | None
    ) -> None:
        """Either form of a spatial scene's accelerations."""
        spatial = spatial_tension if self._by_tensions else spatial_articulated
        spatial.accelerations(builder, self.scene, parameters, q, rates, u)

    def _inverse_dynamics(self, builder: Builder, parameters: Parameters) -> None:
        q, v = self._q(builder), self._v(builder)
        a = builder.input("a", (self.scene.nv,), "accelerations")
        u = builder.output("u", (self.scene.nv,), "full generalised force")
        planar_functions.inverse_dynamics(builder, self.scene, parameters, q, v, a, u)

    def _mass_matrix(self, builder: Builder, parameters: Parameters) -> None:
        q = self._q(builder)
        out = builder.output("out", (self.scene.nv, self.scene.nv), "mass matrix, row-major")
        self._functions.mass_matrix(builder, self.scene, parameters, q, out)

    def _coriolis(self, builder: Builder, parameters: Parameters) -> None:
        q, v = self._q(builder), self._v(builder)
        out = builder.output("out", (self.scene.nv,), "velocity terms")
        self._functions.coriolis(builder, self.scene, parameters, q, v, out)

    def _gravity_torque(self, builder: Builder, parameters: Parameters) -> None:
        q = self._q(builder)
        out = builder.output("out", (self.scene.nv,), "gravity terms")
        self._functions.gravity_torque(builder, self.scene, parameters, q, out)

    def _energy(self, builder: Builder, parameters: Parameters) -> None:
        q, v = self._q(builder), self._v(builder)
        kinetic = builder.output("kinetic", (), "kinetic energy, J")
        potential = builder.output("potential", (), "potential energy, J, springs included")
        self._functions.energy(builder, self.scene, parameters, q, v, kinetic, potential)

    def _positions(self, builder: Builder, parameters: Parameters) -> None:
        q = self._q(builder)
        extent = 2 if self.scene.is_planar else 3
        out = builder.output("out", (self.scene.links, extent), "mass positions, m, last component along gravity")
        self._functions.positions(builder, self.scene, parameters, q, out)

    def _linearization(self, builder: Builder, parameters: Parameters) -> None:
        scene = self.scene
        size = scene.nv if scene.is_planar else 2 * scene.links + (2 if scene.has_cart else 0)
        s = builder.input("s", (scene.links,), "+1 for a link hanging down, -1 for one pointing up")
        outputs = {
            "M": builder.output("M", (size, size), "inertia"),
            "G": builder.output("G", (size, size), "stiffness of gravity and springs"),
        }
        if scene.damping is not None:
            outputs["D"] = builder.output("D", (size, size), "damping")
        if scene.nu:
            outputs["B"] = builder.output("B", (size, scene.nu), "input matrix")
        self._functions.linearization(builder, scene, parameters, s, outputs)

    def _phi(self, builder: Builder, parameters: Parameters) -> None:
        amplitude = builder.input("amplitude", (self.scene.nv,), "amplitudes of [x,] theta")
        omega = builder.input("omega", (), "angular frequency, rad/s")
        out = builder.output("out", (self.scene.nv,), "residuals of the balance")
        harmonic_balance.phi(builder, self.scene, parameters, kernels(), amplitude, omega[0], out)

    def _step(self, builder: Builder, parameters: Parameters) -> None:
        arguments = self._step_arguments(builder)
        runge_kutta(builder, self.scene, self.program("forward_dynamics"), arguments)

    def _step_arguments(self, builder: Builder) -> dict[str, ArrayRef]:
        """h, q, v[, u] and q_next, v_next, those of every step."""
        scene = self.scene
        arguments = {"h": builder.input("h", (), "step, s"), "q": self._q(builder), "v": self._v(builder)}
        u = self._u(builder)
        if u is not None:
            arguments["u"] = u
        arguments["q_next"] = builder.output("q_next", (scene.nq,), "configuration after the step")
        arguments["v_next"] = builder.output("v_next", (scene.nv,), "rates after the step")
        return arguments

    def _step_lie4(self, builder: Builder, parameters: Parameters) -> None:
        arguments, forward = self._step_arguments(builder), self.program("forward_dynamics")
        if self.scene.is_planar:  # turns of the plane commute: the method is Runge-Kutta on the angles
            runge_kutta(builder, self.scene, forward, arguments)
        else:
            step_lie4.Step(builder, self.scene, forward, arguments).run()

    def _step_variational(self, builder: Builder, parameters: Parameters) -> None:
        arguments = self._step_arguments(builder)
        arguments["residual"] = builder.output("residual", (), "what the iteration left of the links' lengths")
        solver = self.program("constrained_accelerations")
        step_variational.Step(builder, self.scene, parameters, solver, arguments).run()

    def _constrained_accelerations(self, builder: Builder, parameters: Parameters) -> None:
        step_variational.constrained_accelerations(builder, self.scene, parameters)

    def _step_rosenbrock(self, builder: Builder, parameters: Parameters) -> None:
        arguments = self._step_arguments(builder)
        for name, size in (("q_error", self.scene.nq), ("v_error", self.scene.nv)):
            arguments[name] = builder.output(name, (size,), "estimated error of the step")
        rosenbrock.step(builder, self.scene, self._implicit_callees, arguments)

    def _rosenbrock_increment(self, builder: Builder, parameters: Parameters) -> None:
        rosenbrock.write_increment(builder, self.scene, self._implicit_callees)

    @property
    def _implicit_callees(self) -> rosenbrock.Callees:
        return rosenbrock.Callees(*map(self.program, rosenbrock.CALLEES))

    def _implicit_factors(self, builder: Builder, parameters: Parameters) -> None:
        rosenbrock.write_factors(builder, self.scene, parameters)

    def _implicit_solution(self, builder: Builder, parameters: Parameters) -> None:
        rosenbrock.write_solution(builder, self.scene, parameters)

    def _project(self, builder: Builder, parameters: Parameters) -> None:
        scene = self.scene
        q, v = self._q(builder), self._v(builder)
        q_out = builder.output("q_out", (scene.nq,), "configuration with unit vectors")
        v_out = builder.output("v_out", (scene.nv,), "rates with tangent angular velocities")
        spatial_functions.project(builder, scene, q, v, q_out, v_out)


_DOC = {
    "forward_dynamics": "Accelerations: the equations of motion solved.",
    "direction_dynamics": "Accelerations of the unit vectors themselves: the equations of motion without angular velocities.",
    "inverse_dynamics": "Generalised force that produces given accelerations.",
    "mass_matrix": "Mass matrix of the equations of motion.",
    "coriolis": "Velocity terms of the equations of motion.",
    "gravity_torque": "Gravity terms of the equations of motion, without springs.",
    "energy": "Kinetic and potential energy.",
    "positions": "Positions of the point masses.",
    "linearization": "Linear equations of motion about an equilibrium, M x'' + D x' + G x = B u.",
    "state_jacobian": "Exact partial derivatives of forward_dynamics.",
    "phi": "Residuals of the single-harmonic balance.",
    "phi_jacobian": "Exact derivatives of phi, columns [amplitude, omega].",
    "step": "One Runge-Kutta step of order 4.",
    "step_rosenbrock": "One L-stable Rosenbrock step of order 5 (Rodas5P), with an error estimate.",
    "rosenbrock_increment": "What one Rosenbrock step of order 5 adds to the state, and its error estimate.",
    "implicit_factors": "The linearised chain of an implicit step, eliminated from the tip to the base.",
    "implicit_solution": "One right side of an implicit step: forces inwards, motions outwards.",
    "step_lie4": "One Runge-Kutta-Munthe-Kaas step of order 4: unit vectors turn, and stay unit.",
    "step_variational": "One step of the variational integrator of order 2, symplectic and reversible.",
    "constrained_accelerations": "Accelerations with prescribed components, by multipliers along the unit vectors.",
    "project": "Unit vectors made unit, angular velocities made tangent.",
}
