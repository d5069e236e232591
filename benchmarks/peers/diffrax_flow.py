"""diffrax on the CPU: the chain's equations in JAX, double precision, compiled ahead of the race."""

from __future__ import annotations

from collections.abc import Callable

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from benchmarks.chains import Chain
from benchmarks.peers import recursions

jax.config.update("jax_platforms", "cpu")
jax.config.update("jax_enable_x64", True)
SOLVERS = {"Dopri8": diffrax.Dopri8, "Tsit5": diffrax.Tsit5}
Array = NDArray[np.float64]


def flow(chain: Chain, q: Array, v: Array, end: float, solver: str, tolerance: float) -> Callable[[], Array]:
    """q at `end` by an adaptive solver of its own; the scene's coordinates."""

    def rate(t: float, x: jax.Array, args: None) -> jax.Array:
        entries = [x[k] for k in range(chain.nq + chain.nv)]
        a, w = entries[: chain.nq], entries[chain.nq :]
        moving = list(w)
        if chain.space == "spatial":
            for k in range(2, chain.nq, 3):
                (p1, p2, p3), (x1, x2, x3) = w[k : k + 3], a[k : k + 3]
                moving[k : k + 3] = [p2 * x3 - p3 * x2, p3 * x1 - p1 * x3, p1 * x2 - p2 * x1]
        found = recursions.accelerations(chain, recursions.forms(chain)[0], a, w, [], jnp.sin, jnp.cos)
        return jnp.stack([*moving, *found])

    control = diffrax.PIDController(rtol=tolerance, atol=tolerance / 100, pcoeff=0.3, icoeff=0.4)
    term, method = diffrax.ODETerm(rate), SOLVERS[solver]()

    @jax.jit
    def solve(x: jax.Array) -> jax.Array:
        found = diffrax.diffeqsolve(
            term, method, t0=0.0, t1=end, dt0=None, y0=x, stepsize_controller=control,
            saveat=diffrax.SaveAt(t1=True), max_steps=None,
        )  # fmt: skip
        return found.ys[-1]

    x0 = jnp.asarray(np.concatenate([q, v]))
    return lambda: np.asarray(solve(x0).block_until_ready())[: chain.nq]
