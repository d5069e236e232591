"""Brake orbits in C: each number that it tells against NumPy on the emitted flow, Newton against plain Newton, and what is asked of the flow on the way."""

from __future__ import annotations

import ctypes
import gc
import subprocess
from dataclasses import replace
from threading import Thread
from typing import Any

import numpy as np
import pytest

from phichain.continuation import Point, Problem
from phichain.continuation.osculating import osculating
from phichain.continuation.problem import Extra
from phichain.emit.stencil import stencils_folder
from phichain.errors import ArrayError, UnsupportedError
from phichain.native.flows import desk
from phichain.native.glue import brake as glue
from phichain.orbits import linear_modes, quarter_problem, trace
from phichain.system import System
from tests.emit.test_stencil import COMPILERS, STRICT
from tests.generated.compiling import need
from tests.orbits.shot import uniform

CART = {"base": "cart", "cart_mass": 0.4}
CHAINS = {"one link": (1, {}), "two": (2, {}), "three": (3, {}), "one on a cart": (1, CART), "two on a cart": (2, CART)}
FLOW = 256 * float(np.finfo(float).eps)


def chain(name: str) -> tuple[System, Problem, np.ndarray]:
    """A chain, its problem, and unknowns that close no orbit: at rest beyond the shape of its slowest mode."""
    links, more = CHAINS[name]
    system = uniform(links, **more)
    modes = linear_modes(system)
    shape = modes.shapes[:, 0] + 0.3 * np.cos(np.arange(system.nq))
    return system, quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0]), np.append(0.5 * shape, 0.97 * modes.omega[0])


def canonical(system: System, z: np.ndarray) -> dict[str, Any]:
    """Residual, Jacobian and quarter map of unknowns, by NumPy on one propagation."""
    nq, carts, links = system.nq, system.cart_size, system.links
    quarter, masses = np.pi / (2 * z[-1]), [np.asarray(system.mass_matrix(q)) for q in (z[:-1], np.zeros(nq))]
    # Rates of a cart that keep its momentum at zero.
    lifts = [np.vstack([-mass[:carts, carts:] / mass[:carts, :carts], np.eye(links)]) if carts else np.eye(links) for mass in masses]
    moving = np.zeros((2 * nq, 2 * links))
    moving[carts:nq, :links], moving[nq:, links:] = np.eye(links), lifts[0]
    found = system.propagate(z[:-1], np.zeros(nq), 0.0, quarter, FLOW, transition=moving)
    jacobian = np.zeros((nq, nq + 1))
    jacobian[:carts, :carts] = np.eye(carts)
    jacobian[:, carts:nq], jacobian[:, nq] = found.transition[:nq, :links], -quarter / z[-1] * found.v
    first, last = (np.linalg.cholesky(lift.T @ mass @ lift) for lift, mass in zip(lifts, masses, strict=True))
    rows = found.transition[carts:nq], found.transition[nq + carts :]
    a, b, c, d = (last.T @ part @ np.linalg.inv(first).T for row in rows for part in (row[:, :links], row[:, links:]))
    rate = last.T @ found.v[carts:]
    force = c.T @ rate
    noise = np.abs(jacobian) @ np.abs(z) * (np.finfo(float).eps * (1 + found.steps))
    return {
        "residual": found.q, "jacobian": jacobian, "a": a, "b": b, "c": c, "d": d, "rate": rate / np.linalg.norm(rate),
        "force": force / np.linalg.norm(force), "slope": first @ force, "noise": noise,
    }  # fmt: skip


def least(matrix: np.ndarray) -> float:
    """+- the smallest singular value, its sign the determinant's."""
    return float(np.sign(np.linalg.det(matrix)) * np.linalg.svd(matrix, compute_uv=False)[-1])


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
def test_what_c_tells_is_what_numpy_finds(name: str) -> None:
    system, problem, z = chain(name)
    wanted, found = canonical(system, z), problem.evaluate(z)
    blocks = found.extra.found
    assert found.residual == pytest.approx(wanted["residual"], abs=1e-13)
    assert found.jacobian == pytest.approx(wanted["jacobian"], rel=1e-12, abs=1e-12)
    for part in ("a", "b", "c", "d", "rate", "force", "slope"):
        assert getattr(blocks, part) == pytest.approx(wanted[part], rel=1e-11, abs=1e-11), part
    assert blocks.noise == pytest.approx(wanted["noise"], rel=1e-10)
    # All eigenvalues but the one that belongs to the force: those of the map on what is across it.
    across = np.linalg.svd(wanted["force"][None])[2][1:].T
    kappa = np.sort_complex(np.linalg.eigvals(np.eye(system.links - 1) - 2 * (wanted["d"] @ across).T @ (wanted["a"] @ across)).astype(complex))
    assert np.sort_complex(found.extra.multipliers) == pytest.approx(kappa, abs=1e-10)
    loss = np.block([[wanted["d"], wanted["rate"][:, None]], [wanted["force"][None], np.zeros((1, 1))]])
    for test, matrix in (("brake loss", loss), ("odd loss", wanted["b"]), ("unequal brakes", wanted["c"])):
        assert blocks.test(test, None) == pytest.approx(least(matrix), rel=1e-10, abs=1e-11), test


@pytest.mark.parametrize("name", CHAINS)
def test_tangent_sigma_error_and_energy(name: str) -> None:
    system, problem, z = chain(name)
    towards = np.arange(1.0, len(z) + 1)
    told = problem.compiled.at(z / problem.sizes, -towards)
    jacobian, tangent = told["jacobian"], told["tangent"]
    assert jacobian @ tangent == pytest.approx(0, abs=1e-13) and np.linalg.norm(tangent) == pytest.approx(1, abs=1e-15) and tangent @ towards < 0
    whole = np.vstack([jacobian, tangent])
    assert told["sigma"] == pytest.approx(least(whole), rel=1e-10)
    row = np.linalg.solve(whole.T, np.eye(len(z))[-1])[:-1]
    assert told["extra"].found.test("error", None) == pytest.approx(np.abs(row) @ told["extra"].found.noise / (z / problem.sizes)[-1], rel=1e-9)
    still = np.zeros(system.nq)
    assert told["energy"] == pytest.approx(system.energy(z[:-1], still)[1] - system.energy(still, still)[1], rel=1e-12)


def plain_newton(problem: Problem, guess: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """y where Newton ends up in the plane across a normal, every evaluation a whole one."""
    y = guess.copy()
    for _ in range(8):
        residual, jacobian, _ = problem.at(y)
        y = y - np.linalg.solve(np.vstack([jacobian, normal]), np.append(residual, normal @ (y - guess)))
    return y


def near_an_orbit(name: str) -> tuple[Problem, np.ndarray, np.ndarray]:
    """A problem, an orbit of its first mode's family with theta_1 = 0.2, and the direction of theta_1."""
    links, more = CHAINS[name]
    system = uniform(links, **more)
    modes = linear_modes(system)
    problem = quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])
    first = np.eye(system.nq + 1)[system.cart_size]
    return problem, plain_newton(problem, np.append(0.2 * modes.shapes[:, 0], modes.omega[0]) / problem.sizes, first), first


@pytest.mark.parametrize("off", [1e-2, 1e-4, 1e-6, 1e-9, 0.0])
@pytest.mark.parametrize("name", ["one link", "two", "two on a cart"])
def test_newton_ends_where_plain_newton_does(name: str, off: float) -> None:
    """From near and far; its last evaluation is a whole one at the very place that it tells, which another one there repeats to the last bit."""
    problem, orbit, normal = near_an_orbit(name)
    guess = orbit + off * np.cos(np.arange(len(orbit)) + 1.0)
    told, brake = problem.compiled.corrected(guess, normal, 1e-9, 0.0, 7), problem.compiled._brake
    *_, tolerance, columns = brake.asked[-1]
    assert told["converged"] and told["is_settled"] and tolerance == FLOW and columns == 2 * (len(brake.desk["rates"]) - (name == "two on a cart"))
    assert np.array_equal(brake.asked[-1][:-2], told["y"] * problem.sizes)
    assert normal @ (told["y"] - guess) == pytest.approx(0, abs=1e-16)
    assert told["y"] == pytest.approx(plain_newton(problem, guess, normal), abs=4e-15)
    again = problem.compiled.at(told["y"], normal)
    for part in ("tangent", "jacobian", "residual", "sigma", "energy"):
        assert np.array_equal(told[part], again[part]), part
    assert np.array_equal(told["extra"].multipliers, again["extra"].multipliers)


def test_an_orbit_costs_one_whole_evaluation() -> None:
    """Rough columns, the state alone, and all of it once at the end; where small corrections are trusted not even that."""
    problem, orbit, normal = near_an_orbit("two")
    guess = orbit + 1e-6 * np.array([1.0, 0.0, -1.0])
    braking = problem.compiled
    braking.corrected(guess, normal, 1e-9, 0.0, 7)
    kinds = [(tolerance > FLOW, columns) for *_, tolerance, columns in braking._brake.asked]
    assert kinds[0] == (True, 2) and kinds[-1] == (False, 4) and set(kinds[1:-1]) == {(False, 0)} and len(kinds) <= 4
    told = braking.corrected(guess, normal, 1e-9, 1e-5, 7)
    assert [columns for *_, columns in braking._brake.asked] == [4] and told["converged"] and not told["is_settled"]
    settled = braking.settled(told["y"], normal)
    assert settled["y"] == pytest.approx(plain_newton(problem, told["y"], normal), abs=1e-11) and settled["is_settled"]


def test_a_step_is_its_guess_corrected() -> None:
    """Hermite's polynomial through orbits of a family, as `osculating` has it; and a step as guess, correction and change one by one."""
    problem, orbit, first = near_an_orbit("two")
    at = [problem.compiled.at(plain_newton(problem, orbit + further * np.array([1.0, 0.3, -0.1]), first), first) for further in (0.0, 0.04, 0.09, 0.15, 0.22)]
    points = [Point(told["y"], told["tangent"], 0.0, told["jacobian"], 0.0, 0, (), Extra()) for told in at]
    known, last, step = [(point.y, point.tangent) for point in points], points[-1], 0.05
    place = float(last.tangent @ last.y) + step
    guess = osculating(points, last.tangent, place)
    assert problem.compiled.touched(known, last.tangent, place) == pytest.approx(guess, abs=1e-12)
    assert problem.compiled.touched(known, -last.tangent, -place) is None
    guess = problem.compiled.touched(known, last.tangent, place)
    way = problem.compiled.ahead(known, last.jacobian, step, 1e-9, 7)
    apart = plain_newton(problem, guess, last.tangent)
    assert way.told["y"] == pytest.approx(apart, abs=1e-14) and way.moved == pytest.approx(np.linalg.norm(apart - last.y), rel=1e-13)
    assert way.shifted == pytest.approx(np.linalg.norm(apart - guess), rel=1e-3, abs=1e-13) and way.turned == pytest.approx(way.told["tangent"] @ last.tangent)
    change = np.linalg.solve(np.vstack([last.jacobian, last.tangent]), np.vstack([way.told["jacobian"], last.tangent]))
    assert way.change() == pytest.approx(change, abs=1e-11) and way.changed == pytest.approx(np.linalg.norm(change - np.eye(3)), rel=1e-9)


def test_threads_share_a_problem() -> None:
    """What one thread was told of a step another one's step leaves alone, and their flows work in rooms of their own."""
    problem, orbit, first = near_an_orbit("two")
    told = problem.compiled.at(orbit, first)
    known = [(told["y"], told["tangent"])]
    way = problem.compiled.ahead(known, told["jacobian"], 0.05, 1e-9, 7)
    change = way.change()
    rooms = []

    def of_another() -> None:
        problem.compiled.ahead(known, told["jacobian"], 0.1, 1e-9, 7)
        rooms.append(room(problem))

    def room(of: Problem) -> int:
        return ctypes.cast(of.compiled._brake._table.bound._frame.flow.work, ctypes.c_void_p).value

    other = Thread(target=of_another)
    other.start()
    other.join()
    assert np.array_equal(way.change(), change) and rooms[0] != room(problem)


def test_desks_are_used_again_by_one_problem_at_a_time() -> None:
    """What was told on one stays when the next problem computes there, which finds it as if it were new."""
    system, *_, z = chain("two")
    modes, along = linear_modes(system), np.eye(3)[0]

    def another() -> Problem:
        return quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0])

    def place(of: Problem) -> int:
        return of.compiled._brake._table.at.value

    first, second = another(), another()
    where, y = place(first), z / first.sizes
    told = first.compiled.at(y, along)
    kept = {name: told[name].copy() for name in ("y", "tangent", "jacobian")}
    assert where != place(second)
    del first
    gc.collect()
    third = another()
    assert place(third) == where and place(second) != where and not third.compiled._brake.desk["asked"].any()
    assert not np.array_equal(third.compiled.at(1.1 * y, along)["jacobian"], kept["jacobian"])
    assert all(np.array_equal(told[name], own) for name, own in kept.items())
    again = third.compiled.at(y, along)
    assert all(np.array_equal(again[name], own) for name, own in kept.items())


def test_more_places_than_there_is_room_for_are_refused() -> None:
    problem, orbit, first = near_an_orbit("two")
    told = problem.compiled.at(orbit, first)
    known = [(told["y"], told["tangent"])] * (desk.KNOWN + 1)
    with pytest.raises(ArrayError, match="known: must be at most 8 places"):
        problem.compiled.touched(known, first, 0.0)
    with pytest.raises(ArrayError, match="known: must be at most 8 places"):
        problem.compiled.ahead(known, told["jacobian"], 0.05, 1e-9, 7)


def test_what_cannot_be_followed_is_no_number() -> None:
    _, problem, z = chain("two")
    for bad in (np.append(z[:-1], -z[-1]), np.append(z[:-1], np.nan), np.append(z[:-1], 1e-9)):
        assert np.all(np.isnan(problem.evaluate(bad).residual)) and problem.compiled.at(bad / problem.sizes, z) is None
        told = problem.compiled.corrected(bad / problem.sizes, z, 1e-9, 0.0, 7)
        assert not told["converged"] and told["residual"] == np.inf


def test_a_flow_that_was_not_compiled_is_refused() -> None:
    system = uniform(2)
    flow = system.function("propagate")
    unbound = replace(system, functions={**system.functions, "propagate": lambda *words, **more: flow(*words, **more)})
    with pytest.raises(UnsupportedError, match="has no brake orbits compiled in"):
        trace(unbound, until="theta_1=0.1")


@pytest.mark.long
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_stencils_compile_alone(compiler: str, tmp_path: Any) -> None:
    need(compiler)
    alone = str(stencils_folder() / "orbits" / "alone.c")
    for nq, cart in ((1, 0), (2, 1), (4, 0)):
        words = [compiler, *STRICT, f"-I{stencils_folder()}", f"-DPHI_Q={nq}", f"-DPHI_CART={cart}", "-O2", "-c", alone, "-o", str(tmp_path / "alone.o")]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and not done.stderr, done.stderr


def test_a_desk_that_lies_otherwise_does_not_compile(tmp_path: Any) -> None:
    """The fields as Python says them, checked against the C: whole as they are, and with two of one size exchanged."""
    alone = (stencils_folder() / "orbits" / "alone.c").read_text()
    fields = desk.desk_fields(3, 2)
    names = list(fields)
    k = names.index("tol")
    names[k], names[k + 1] = names[k + 1], names[k]
    for wanted, is_right in ((fields, True), ({name: fields[name] for name in names}, False)):
        checks = "\n".join(line.replace("phi_real", "double") for line in glue._checks("phi", "brake_desk", wanted))
        (tmp_path / "desk.c").write_text(f"{alone}\n{checks}\n")
        words = ["cc", f"-I{stencils_folder()}", "-fsyntax-only", str(tmp_path / "desk.c")]
        assert (subprocess.run(words, capture_output=True, check=False).returncode == 0) is is_right


def test_a_guess_that_the_rough_flow_calls_exact_is_looked_at_all_the_same() -> None:
    """Where rounding leaves nothing at all to correct, no correction is taken on trust that nobody gave: the columns are those of the whole flow."""
    system = uniform(1)
    modes = linear_modes(system)
    fine, rough = (quarter_problem(system, omega=modes.omega[0], shape=modes.shapes[:, 0], **more) for more in ({}, {"tol": 1e-9}))
    normal, exact = np.array([1.0, 0.0]), 0
    assert fine.compiled is not None and rough.compiled is not None
    for angle in np.linspace(0.1, 1.5, 200):
        guess = rough.compiled.corrected(np.array([angle, 1.0]), normal, 1e-9, 0.0, 7)["y"]
        exact += rough.evaluate(guess * rough.sizes).residual[0] == 0
        told = fine.compiled.corrected(guess, normal, 1e-9, 0.0, 7)
        assert told["converged"] and told["extra"].found.c[0, 0] < -1
    assert exact > 10
