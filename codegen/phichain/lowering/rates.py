"""The fastest linear mode of the hanging chain, by which angles and rates are weighed against each other.

Small motions about hanging obey M x'' + G x = 0, M_ij = c_ij, G_ii = g mu_i, and springs add k_k (x_k - x_{k-1})^2; their
largest frequency bounds how fast a chain swings without being driven. Where parameters come at run time

    omega^2 <~ 4 max_k (g outer_k + k_k / r_k) / (m_k r_k) (1 + sum_k (l_k - r_k) / (2 r_k))^2,   outer_k = sum_{a >= k} m_a

serves. For r = l it is Gershgorin's bound on the tridiagonal inverse of M, for masses that do not grow outwards; the last
factor is an estimate: with masses half-way zigzags of N links hardly move them, and frequencies grow by as much as N
(checked on uniform chains). The largest of the terms is replaced by their 4-norm, which a Program can compute.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from phichain.ir.builder import Builder, Expr, Index
from phichain.ir.nodes import Program
from phichain.ir.passes import prune
from phichain.lowering.parameters import Parameters
from phichain.mechanics import Model
from phichain.scene import Scene

#: Digits kept of a frequency: the text must not depend on the last bits of an eigenvalue solver.
_DIGITS = 3


@lru_cache(maxsize=8)
def fastest_rate(scene: Scene) -> Fraction | None:
    """Largest linear frequency of the hanging chain, rad/s, rounded up; None where parameters come at run time."""
    if scene.runtime:
        return None
    mass, length = (np.array(values, dtype=float) for values in (scene.mass, scene.length))
    com = length if scene.com is None else np.array(scene.com, dtype=float)
    outer = np.append(np.cumsum(mass[::-1])[::-1][1:], 0.0)
    mu = mass * com + length * outer
    links = np.arange(scene.links)
    inner = np.minimum.outer(links, links)
    inertia = length[inner] * mu[np.maximum.outer(links, links)]
    inertia[links, links] = mass * com**2 + length**2 * outer
    if scene.has_cart:
        # On a cart that moves freely: its coordinate eliminated.
        inertia -= np.outer(mu, mu) / (float(scene.cart_mass) + mass.sum())  # type: ignore[arg-type]
    stiff = np.diag(float(scene.gravity) * mu)
    if scene.stiffness is not None:
        difference = np.eye(scene.links) - np.eye(scene.links, k=-1)
        stiff = stiff + difference.T @ np.diag(np.array(scene.stiffness, dtype=float)) @ difference
    try:
        square = float(np.max(scipy.linalg.eigh(stiff, inertia, eigvals_only=True)))
    except scipy.linalg.LinAlgError:  # masses spread so far that the inertia is singular in double precision
        square = _bound(scene, mass, com)
    return _rounded_up(max(square, 0.0) ** 0.5)


def _bound(scene: Scene, mass: NDArray[np.float64], com: NDArray[np.float64]) -> float:
    """The bound of omega^2 above, with the lighter of two neighbours."""
    outer = np.cumsum(mass[::-1])[::-1]
    lighter = np.minimum(mass, np.append(mass[0], mass[:-1]))
    spring = 0.0 if scene.stiffness is None else np.array(scene.stiffness, dtype=float) / com
    gravity = float(scene.gravity)
    slack = 1 + np.sum((np.array(scene.length, dtype=float) - com) / (2 * com))
    return float(np.max(4 * (gravity * outer + spring) / (lighter * com)) * slack**2)


def reach(scene: Scene) -> Fraction | None:
    """Length of the chain, m; None where lengths come at run time."""
    return None if scene.length == "runtime" else sum(map(Fraction, scene.length), Fraction(0))


def scales_program(model: Model) -> Program:
    """The bound above, rad/s, and the chain's length, m, from the runtime parameters."""
    builder = Builder("flow_scales", "Fastest linear rate, and length of the chain.")
    scene, parameters = model.scene, Parameters(builder, model)
    scales = builder.output("scales", (2,))

    def term(k: Index) -> Expr:
        mass, com = parameters.mass[k], parameters.com[k]
        outer = parameters.outer_mass[k] + mass
        pull = parameters.gravity * outer
        if parameters.stiffness is not None:
            pull = pull + parameters.stiffness[k] / com
        return pull / (mass * com)

    with builder.loop("k", 0, scene.links) as loop:
        total, length, slack = loop.carry("total", 0), loop.carry("length_before", 0), loop.carry("slack", 1)
        square = builder.let("square", 4 * term(loop.index))
        square = square * square
        loop.follow(total, total + square * square)
        arm, com = parameters.length[loop.index], parameters.com[loop.index]
        loop.follow(length, length + arm)
        loop.follow(slack, slack if scene.com is None else slack + Fraction(1, 2) * ((arm - com) / com))
    scales[0] = slack * builder.sqrt(builder.sqrt(builder.sqrt(total)))
    scales[1] = length
    return prune(builder.finish())


def _rounded_up(rate: float) -> Fraction:
    digits = f"{rate * (1 + 0.5 * 10.0**-_DIGITS):.{_DIGITS - 1}e}"
    return Fraction(digits)
