"""The peers' formulas against the dense Lagrangian in 40 digits: no peer is held back by a wrong one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import chains
from benchmarks.flows.cases import motions, references
from benchmarks.harness import Arena
from benchmarks.ours import from_c
from benchmarks.peers import recursions
from benchmarks.reference import accelerations, jacobian, relative_error

KINDS = (
    chains.planar_chain, chains.tip_chain, chains.absolute_chain, chains.cart_chain, chains.runtime_chain,
    chains.spread_chain, chains.spatial_chain, chains.inner_spatial_chain,
)  # fmt: skip


@pytest.mark.parametrize("links", [1, 2, 3, 4])
@pytest.mark.parametrize("make", KINDS)
def test_every_form_of_every_kind_of_chain(make: object, links: int) -> None:
    chain = make(links)  # type: ignore[operator]
    states = chains.random_states(chain, 2)
    exact = np.array([accelerations(chain, state) for state in states])
    for form in recursions.forms(chain):
        found = []
        for state in states.tolist():
            q, v, u = state[: chain.nq], state[chain.nq : 2 * chain.nq], state[2 * chain.nq :]
            found.append(recursions.accelerations(chain, form, q, v, u, math.sin, math.cos))
        assert relative_error(np.array(found), exact) < 2e-14, form


@pytest.mark.parametrize("angles", ["relative", "absolute"])
def test_torques_and_a_cart_in_absolute_angles(angles: str) -> None:
    for chain in (chains.planar_chain(3), chains.cart_chain(3)):
        chain = replace(chain, angles=angles)
        state = chains.random_states(chain, 1)[0]
        exact = accelerations(chain, state)
        row = state.tolist()
        for form in ("link frame", "closed form"):
            found = recursions.accelerations(
                chain, form, row[: chain.nq], row[chain.nq : 2 * chain.nq], row[2 * chain.nq :], math.sin, math.cos
            )
            assert np.max(np.abs(np.array(found) - exact)) < 1e-13 * np.max(np.abs(exact))


def test_unit_vectors_without_angular_velocities() -> None:
    chain = replace(chains.spatial_chain(3, forced=False), mass=(0.1, 0.3, 0.2), length=(0.1, 0.2, 0.15), com=(0.1, 0.2, 0.15))
    state = chains.random_states(chain, 1)[0]
    q, v = state[: chain.nq], state[chain.nq :]
    a = accelerations(chain, state)
    rates, exact = v.copy(), a.copy()
    for k in range(2, chain.nq, 3):
        part = slice(k, k + 3)
        rates[part] = np.cross(v[part], q[part])
        exact[part] = np.cross(a[part], q[part]) + np.cross(v[part], rates[part])
    found = recursions.spatial_tension_direct(chain, q.tolist(), rates.tolist(), ())
    assert np.max(np.abs(np.array(found) - exact)) < 1e-13 * np.max(np.abs(exact))


def test_the_reference_jacobian_of_one_link() -> None:
    chain = replace(chains.planar_chain(1, forced=False), length=(1.0,), com=(1.0,), mass=(1.0,))
    assert jacobian(chain, np.array([0.3, 0.7])) == pytest.approx([-9.81 * math.cos(0.3), 0.0], abs=1e-12)


def test_the_motions_have_references() -> None:
    for motion in motions():
        q, v = motion.starts()
        assert references()[motion.name].shape == q.shape == v.shape
        assert np.max(np.abs(references()[motion.name] - q)) > 1e-2  # they have moved


def test_a_chained_evaluation_gives_what_an_independent_one_gives(tmp_path: object) -> None:
    """0 x result adds a dependence and no value: a function that kept its last state finds the same states."""
    text = """
    static double seen[64]; static int count;
    void probe(double *out, const double *state, const double *p, const double *time)
    { (void)p, (void)time; seen[count++ % 64] = state[0]; out[0] = 3.0 * state[0]; }
    void tell(double *out, const double *state, const double *p, const double *time)
    { (void)state, (void)p, (void)time; for (int i = 0; i < 64; ++i) out[i] = seen[i]; }
    """
    chain = chains.planar_chain(1, forced=False)
    states = np.array([[float(k), 0.0] for k in range(4)])
    candidate = from_c(text, "probe", "probe", tmp_path)  # type: ignore[arg-type]
    arena = Arena(chain, [candidate], states)
    assert arena.measure(3, chained=True).shape == (3, 1)
    told = Arena(chain, [replace(candidate, symbol="tell")], states, outputs=64).evaluate(0, 1)[0]
    assert set(told) <= {0.0, 1.0, 2.0, 3.0} and len(set(told)) == 4
