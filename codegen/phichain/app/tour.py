"""One trip through everything: two papers' chains from scene to running code, in motion, followed and controlled.

`make run` takes it. Every stop does one thing that a user would do, says what came out, and leaves a section with its
figure in the report.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from rich.console import Console

import phichain
from phichain.continuation import Branch
from phichain.control import errors, feedback, lqr
from phichain.files import write_file
from phichain.motion import Trajectory, simulate
from phichain.orbits import trace
from phichain.pipeline import build, generate, generate_controller
from phichain.proof import EXACTLY
from phichain.report import figures
from phichain.report.html import Section, page
from phichain.report.style import look, save
from phichain.scene.library import find_scene
from phichain.system import System
from phichain.system.starts import Vector, leaning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER_A, PAPER_B, RIG = "paper_a_4", "paper_b", "rig_cart_pole"
PERIOD = 0.002
SECONDS, FRAMES = 10.0, 1001
MOVING = "paper_a.gif"

Facts = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Stop:
    """What one stop of the tour found.

    Attributes:
        text: What was done, and how to read the figure.
        facts: What came out, as pairs of what and its value.
        figure: The figure, or None.
        caption: What the figure shows.
        file: The figure's file name.
        title: The stop's heading.
        seconds: How long it took.
        shows: The records that the figure shows.
    """

    text: str
    facts: Facts
    figure: Figure | None = None
    caption: str = ""
    file: str = ""
    title: str = ""
    seconds: float = 0.0
    shows: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Steadied:
    """A closed loop's motion and the errors (paper B: e_q, e_omega in rad/s) that it brings to zero."""

    trajectory: Trajectory
    direction_error: Vector
    rate_error: Vector


def tour(out: Path) -> Path:
    """Take the whole trip and return the report it left, OUT/report/index.html.

    Args:
        out: Where the generated folders and the report go.

    Raises:
        PhichainError: A stop could not be made.
    """
    with look():  # without a way to draw there is no report, and that is said before any work
        guide = _Guide(Console(highlight=False))
    chain = guide.visit("Paper A: four links in a plane", lambda: _code(PAPER_A, out))
    cart = guide.visit("Paper B: five links in space, on a cart", lambda: _code(PAPER_B, out))
    swing = guide.visit("Paper A's chain in motion", lambda: _motion(chain, leaning(chain, 1.0), "paper_a.png"))
    wave = guide.visit("Paper B's chain in motion", lambda: _motion(cart, corkscrew(cart), "paper_b.png"))
    family = guide.visit("A family of limit cycles", lambda: _family(chain))
    steadied = guide.visit("A controller", lambda: _control(cart))
    guide.visit("A rig: from its data sheet to a controller in C", lambda: _rig(out))
    report = out / "report"
    sheet = figures.overview((chain, swing), (cart, wave), family, steadied.trajectory)
    save(sheet, report / "tour.png", of=[swing, wave, family, steadied.trajectory])
    swing.animate(report / MOVING, seconds=4.0, fps=12)
    return _write(report, guide.stops)


class _Guide:
    """Leads from stop to stop, and says at each what came out."""

    def __init__(self, console: Console) -> None:
        self.console = console
        self.stops: list[Stop] = []

    def visit(self, title: str, work: Callable[[], tuple[Any, Stop]]) -> Any:
        """Do the work of one stop and return what it made."""
        start = time.perf_counter()
        with self.console.status(f"{title} ..."):
            found, stop = work()
        stop = replace(stop, title=title, seconds=time.perf_counter() - start)
        self.console.print(f"[bold]{title}[/bold]  [dim]{stop.seconds:.1f} s[/dim]")
        for what, value in stop.facts:
            self.console.print(f"  [dim]{what:<18}[/dim] {value}", soft_wrap=True)
        self.stops.append(stop)
        return found


def _code(name: str, out: Path) -> tuple[System, Stop]:
    """Scene -> folder of C and CasADi -> compiled System."""
    scene = find_scene(name)
    folder = generate(scene, out)
    system = build(scene)
    manifest = json.loads((folder / "manifest.json").read_bytes())
    operations = manifest["functions"]["forward_dynamics"]["operations"]["total"]
    facts = (
        ("written", f"{out / scene.name} (C99, CasADi, self-test)"),
        ("functions", ", ".join(manifest["scene"]["functions"]["want"])),
        ("proven", _proof(manifest["proof"])),
        ("forward dynamics", f"{operations} operations, exact to round-off in O(N)"),
        ("one evaluation", f"{_nanoseconds(system):.0f} ns in compiled C"),
    )
    text = f"The scene {scene.name} was derived from its Lagrangian, emitted, compiled and loaded."
    return system, Stop(text, facts)


def _proof(how: dict[str, str]) -> str:
    """What was proven of a scene's functions, in one line, and what was not."""
    proven = [name for name, words in how.items() if words == EXACTLY]
    others = [f"{name} by {words}" for name, words in how.items() if words != EXACTLY]
    return "; ".join([f"{len(proven)} functions against the Lagrangian, exactly ({EXACTLY})", *others])


def _nanoseconds(system: System, rows: int = 4096) -> float:
    """Least time of one forward dynamics within a batch of random states."""
    draw = np.random.default_rng(0)
    rest = leaning(system, 0.5)
    arguments = [np.tile(part, (rows, 1)) for part in (*rest, np.zeros(system.nu))]
    arguments[1] = arguments[1] + draw.normal(size=arguments[1].shape) * 0.1
    best = float("inf")
    for _ in range(20):
        start = time.perf_counter_ns()
        system.forward_dynamics(*arguments[: 3 if system.nu else 2])
        best = min(best, (time.perf_counter_ns() - start) / rows)
    return best


def corkscrew(system: System) -> tuple[Vector, Vector]:
    """A spatial chain at rest whose links lean by 1 rad, each an eighth of a turn further round than the last."""
    around = np.pi / 4 * np.arange(system.links)
    links = [np.array([np.sin(1.0) * np.cos(a), np.sin(1.0) * np.sin(a), np.cos(1.0)]) for a in around]
    return np.concatenate([np.zeros(system.cart_size), *links]), np.zeros(system.nv)


def _motion(system: System, start: tuple[Vector, Vector], file: str) -> tuple[Trajectory, Stop]:
    """Simulate ten seconds."""
    trajectory = simulate(system, start, np.linspace(0.0, SECONDS, FRAMES), tol=1e-10)
    facts = (
        ("simulated", f"{SECONDS:g} s by {trajectory.method}, {trajectory.counts['steps']} steps"),
        ("energy drift", f"{trajectory.energy_drift:.1e} J"),
    )
    text = f"Released from rest and left alone for {SECONDS:g} s. The integrator: {trajectory.reason}."
    caption = "Left: the chain at fourteen moments, pale to dark, over the path of its tip. Right: every link's angle"
    caption += " from the vertical, and how far the total energy moved. A chain in space is seen from three sides and in perspective."
    return trajectory, Stop(text, facts, figures.motion(system, trajectory), caption, file, shows=(trajectory,))


def _family(system: System) -> tuple[Branch, Stop]:
    """Follow the family of the slowest mode."""
    branch = cast("Branch", trace(system, mode=1, amplitude_max=3.0))
    omega = branch.column("omega")
    folds = sum(event.kind.startswith("fold") for event in branch.events)
    facts = (
        ("family", f"{len(branch)} points by arclength, {folds} folds located"),
        ("frequency", f"{omega[0]:.4f} rad/s for small motions, down to {omega.min():.4f}"),
        ("residual", f"at most {branch.residual.max():.1e}"),
    )
    text = (
        "In-phase oscillations theta_k = A_k cos(omega t) that balance the equations of motion on their first harmonic"
        " (paper A, equations (16) to (22)), followed from the hanging rest. The unforced chain is conservative, so these are"
        " families of periodic orbits; one harmonic is a good description while amplitudes stay moderate."
    )
    caption = "Left: frequency over the amplitude of every joint, folds marked. Right: frequency over energy."
    return branch, Stop(text, facts, figures.family(branch), caption, "family.png", shows=(branch,))


def _control(system: System) -> tuple[Steadied, Stop]:
    """Balance all links upright."""
    gains = lqr(system, [-1] * system.links)
    grid = np.linspace(0.0, 2 * SECONDS, 2 * FRAMES - 1)
    trajectory = simulate(system, leaning(system, 0.2, gains.s), grid, tol=1e-9, u=feedback(system, gains))
    found = Steadied(trajectory, *errors(system, gains, trajectory.x))
    facts = (
        ("equilibrium", f"all {system.links} links upright, released {0.2:g} rad off"),
        ("slowest pole", f"{gains.poles[0].real:.4f} 1/s, controllability margin {gains.margin:.2g}"),
        ("brought back", f"e_q from {found.direction_error[0]:.2g} to {found.direction_error[-1]:.1e}"),
        ("largest force", f"{np.max(np.abs(np.asarray(trajectory.u))):.2f} N"),
    )
    text = (
        f"The linear quadratic regulator (paper B, equation (22)) of one of the {2**system.links} equilibria, made from"
        " the emitted linearisation and tried on the emitted nonlinear chain."
    )
    caption = "Left: the chain at fourteen moments. Right: the sums over the links of |q_i - s_i e_3| and |omega_i|,"
    caption += " the cart's place and the force on it."
    drawing = figures.closed_loop(system, trajectory, found.direction_error, found.rate_error)
    return found, Stop(text, facts, drawing, caption, "controlled.png", shows=(trajectory, gains))


def _rig(out: Path) -> tuple[Steadied, Stop]:
    """Balance a rod on a cart as a microcontroller would, and write what it runs."""
    system = build(find_scene(RIG))
    gains = lqr(system, sample=PERIOD, Q=[100, 100, 1, 1])
    law = gains.law(limit=8.0)
    folder = generate_controller(law, out, "float")
    grid = np.linspace(0.0, SECONDS, FRAMES)
    trajectory = simulate(system, leaning(system, 0.15, gains.s), grid, u=law, sample=PERIOD)
    found = Steadied(trajectory, *errors(system, gains, trajectory.x))
    facts = (
        ("rig", "a rod with inertia and friction on a cart that a motor drives (docs/rigs.md)"),
        ("sampled", f"every {PERIOD * 1e3:g} ms, input held; slowest pole {gains.poles[0].real:.4f} 1/s"),
        ("written", f"{out / folder.name} (C99 in float, CasADi, self-test)"),
        ("brought back", f"e_q from {found.direction_error[0]:.2g} to {found.direction_error[-1]:.1e}"),
        ("energy", trajectory.energy_words),
    )
    text = (
        "A rig's scene holds its inertia, its friction and what its motor adds; docs/rigs.md says how they follow from a data sheet."
        f" The regulator is designed for an input that is held for {PERIOD * 1e3:g} ms, and tried so."
    )
    caption = "Left: the rig at fourteen moments. Right: how far the rod is from upright, the cart's place and the force on it."
    drawing = figures.closed_loop(system, trajectory, found.direction_error, found.rate_error)
    return found, Stop(text, facts, drawing, caption, "rig.png", shows=(trajectory, law))


def _write(report: Path, stops: list[Stop]) -> Path:
    """The figures, and the page around them."""
    for stop in stops:
        if stop.figure is not None:
            save(stop.figure, report / stop.file, of=stop.shows)
    sections = [
        Section(s.title, s.text, (*s.facts, ("time", f"{s.seconds:.1f} s")), s.file or None, s.caption) for s in stops
    ]
    sections.insert(3, Section("The same, moving", f"{SECONDS:g} s in four.", (), MOVING, "Paper A's chain as it moves, its tip leaving its path."))
    lead = "Two pendulum chains from their Lagrangian to compiled code, in motion, followed and controlled."
    text = page("A tour of phichain", lead, sections, f"phichain {phichain.__version__}")
    write_file(report / "index.html", text)
    return report / "index.html"
