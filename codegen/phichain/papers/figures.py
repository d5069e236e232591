"""The figures of both papers, each from its scene to a picture: what `phichain figure` and `make figures` draw.

Chains, starts and weights are the papers'. Paper A: m = l = 1/N, masses at the middles of the links; Figs 3 to 6 start at
rest with theta = (0.4, 0, ..., 0) rad and have no torques. Paper B: five links of 0.1 kg and 0.1 m on a cart of 0.5 kg;
`FIG_2`, `FIG_3` and `FIG_4` hold its three runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from phichain.continuation import Branch, Options
from phichain.control import Gains, computed_torque, feedback, in_phase, lqr
from phichain.errors import UnsupportedError
from phichain.fractional import Propagation
from phichain.motion import Trajectory, simulate
from phichain.orbits import trace
from phichain.papers.climbing import climbed
from phichain.papers.families import conical, energies, exact_families, gap, network
from phichain.papers.signals import released, write_sheets, write_viewer
from phichain.pipeline import build
from phichain.report.papers import charts, paper_b
from phichain.report.papers.tracking import tracking
from phichain.report.style import save
from phichain.scene import scene_from_dict
from phichain.scene.library import find_scene
from phichain.system import System

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Vector = NDArray[np.float64]

START = 0.4
"""theta_1(0) of Figs 3 to 6, rad; the other angles and all rates are 0."""

SECONDS = 2.0
CHARTED, SETTLING = (1, 2, 3, 4), (1, 2, 4, 8, 16, 32)

CART, CART_RATE = (0.2, 0.1), (0.0, -0.1)
"""x(0), m, and x'(0), m/s, of paper B's runs, (23)."""


@dataclass(frozen=True)
class CartRun:
    """One run of paper B's chain; its cart starts at `CART` with `CART_RATE`, its links at rest.

    Attributes:
        links: Directions q_1 .. q_5 at the start, unit vectors along the rows (5, 3).
        seconds: How long it lasts.
        moments: Times of its snapshots, s.
        s: The equilibrium it is steadied at, or None without control.
        weights: Of the cart and of the links in Q, the same for positions and rates; R is the identity.
    """

    links: tuple[tuple[float, float, float], ...]
    seconds: float
    moments: tuple[float, ...]
    s: tuple[int, ...] | None = None
    weights: tuple[float, float] = (1.0, 1.0)

    @property
    def start(self) -> tuple[Vector, Vector]:
        """(q, v) at t = 0, both (17,)."""
        return np.concatenate([CART, np.ravel(self.links)]), np.concatenate([CART_RATE, np.zeros(15)])


def _sin(degrees: float) -> float:
    return float(np.sin(np.radians(degrees)))


def _cos(degrees: float) -> float:
    return float(np.cos(np.radians(degrees)))


_UP, _DOWN = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
_FOLDED = (_UP, _DOWN, _UP, _DOWN, (_sin(1), 0.0, -_cos(1)))

FIG_2 = CartRun(_FOLDED, 10.0, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0))
"""Left alone near the saddle (-1, 1, -1, 1, -1): the fifth link leans by one degree. E = 0.299285058894842 J.

The motion is chaotic: in double precision the cart is where it is shown to 1e-9 m at 2 s and to 1e-3 m at 4 s, no longer
after that, docs/theory.md, B7."""

FIG_3 = CartRun(
    _FOLDED, 20.0, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 20.0), (1, 1, 1, 1, 1), (8.0, 1.0)
)
"""The same start brought to hanging: slowest eigenvalue -1.07782602 1/s."""

FIG_4 = CartRun(
    (
        (-_sin(6), 0.0, -_cos(6)),
        (0.0, -_sin(4), -_cos(4)),
        (0.0, -_sin(4), -_cos(4)),
        (_sin(5) * _cos(4), -_sin(5) * _sin(4), _cos(5)),
        (-_sin(35), 0.0, _cos(35)),
    ),
    20.0,
    (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 2.0, 4.0, 20.0),
    (-1, -1, -1, 1, 1),
    (1.0, 8.0),
)
"""Steadied with three links up and two folded down: slowest eigenvalue -0.77136540 1/s.

q_2 and q_3 as their four printed entries mean them, docs/theory.md, B6."""


def draw(name: str, out: Path) -> list[Path]:
    """Draw one figure, A2 .. A7, B2 .. B4, E2 .. E4, G4, N2, C2 or U2, into a folder; returns the files written.

    Raises:
        UnsupportedError: There is no such figure.
        OutputError: The folder cannot be written.
    """
    return FIGURES[known(name)](out)


def known(name: str) -> str:
    """The name of a figure, in either case.

    Raises:
        UnsupportedError: There is no such figure.
    """
    if name.upper() not in FIGURES:
        raise UnsupportedError(
            "figure", name, "no figure has that name", f"choose of {', '.join(FIGURES)}, or all"
        )
    return name.upper()


def paper_a_chain(links: int, angles: str = "relative", actuated: str = "none") -> System:
    """Paper A's chain, compiled, in either reading of its angles."""
    scene = find_scene(f"paper_a_{links}").to_dict()
    scene["joints"] |= {"angles": angles, "actuated": actuated}
    scene["name"] = f"paper_a_{links}_{angles}_{actuated}"
    return build(scene_from_dict(scene))


def paper_a_wave(system: System) -> Propagation:
    """The signals of a chain released at rest with the first angle at `START`."""
    return released(system, SECONDS, q=START * np.eye(system.nq)[0], v=np.zeros(system.nv))


def _waves(links: int) -> Callable[[Path], list[Path]]:
    """Figs 3 to 6: N = 1 to 4, in one reading of the angles or, where they differ, in both.

    As in the paper, the surfaces of three and four links are those of link 1; the feedback's sheet and the page have all.
    """

    def write(out: Path) -> list[Path]:
        found, written, stem = {}, [], f"A{links + 2}"
        shown = links if links < 3 else 1
        for angles in ("relative",) if links < 3 else ("relative", "adjacent"):
            name = f"N = {links}, {angles} angles"
            found[name] = paper_a_wave(paper_a_chain(links, angles))
            mark = "" if angles == "relative" else f"_{angles}"
            written += write_sheets(stem, mark, f"Paper A, {name}", found[name], out, shown)
        lead = (
            f"Released at theta_1 = {START} rad, other angles zero; m = l = 1/{links}, masses at the middles."
        )
        return [*written, write_viewer(stem, f"Signal propagation, N = {links}", lead, found, out)]

    return write


def _tracking(out: Path) -> list[Path]:
    """Fig. 2: paper A's triple pendulum made to follow the in-phase motion (17)."""
    system, wanted = paper_a_chain(3, actuated="all"), in_phase([0.5, 0.3, -0.2], 3.0)
    start, grid = wanted(0.0)[:2], np.linspace(0.0, 6.0, 601)
    law = computed_torque(system, wanted, 5.0)
    runs = {
        "fed forward, tolerance 1e-12": simulate(
            system, start, grid, tol=1e-12, u=computed_torque(system, wanted)
        )
    }
    for tol in (1e-6, 1e-9, 1e-12):
        runs[f"computed torque, tolerance {tol:.0e}"] = simulate(system, start, grid, tol=tol, u=law)
    beside = simulate(system, (start[0] + 0.3, start[1]), grid, tol=1e-12, u=law)
    title = r"Paper A, Fig. 2: three links follow $\theta_k = A_k \cos \omega t$"
    return [save(tracking(wanted, runs, beside, title), out / "A2.png", of=[*runs.values(), beside])]


def families(links: int) -> list[Branch]:
    """The single-harmonic families of all modes of paper A's chain, followed until a link swings by pi."""
    system, options = paper_a_chain(links), Options(step_max=0.05, max_points=4000)
    return [cast(Branch, trace(system, mode, np.pi - 1e-3, options=options)) for mode in range(1, links + 1)]


def slowest_family(links: int) -> Branch:
    """The family of mode 1 of N links, m = l = 1/N, up to 1.5 rad."""
    chain = {"links": links, "mass": 1 / links, "length": 1 / links, "com": 0.5 / links}
    scene = scene_from_dict(
        {"name": f"long{links}", "chain": chain, "functions": {"want": ["phi", "phi_jacobian"]}}
    )
    return cast(Branch, trace(build(scene), 1, 1.5, options=Options(step_max=0.05, max_points=4000)))


def _charts(out: Path) -> list[Path]:
    """Fig. 7 with the exact families over it, and its remark that the charts settle as N grows."""
    long = {links: slowest_family(links) for links in SETTLING}
    exact = {links: exact_families(links) for links in CHARTED}
    found = {links: families(links) for links in CHARTED}
    sheet = charts.charts(found, long, float(np.sqrt(9.81 / 0.5)), exact)
    every = [branch for several in (*found.values(), *exact.values()) for branch in several]
    return [save(sheet, out / "A7.png", of=[*every, *long.values()])]


def run_on_cart(system: System, run: CartRun, tol: float = 1e-9) -> tuple[Trajectory, Gains | None]:
    """Simulate paper B's chain, with its regulator when the run has a target."""
    grid = np.linspace(0.0, run.seconds, 2001)
    if run.s is None:
        return simulate(system, run.start, grid, tol=tol), None
    cart, links = ([weight] * count for weight, count in zip(run.weights, (2, 10), strict=True))
    gains = lqr(system, run.s, [*cart, *links, *cart, *links])
    return simulate(system, run.start, grid, tol=tol, u=feedback(system, gains)), gains


def _on_cart(name: str, run: CartRun, words: str) -> Callable[[Path], list[Path]]:
    def write(out: Path) -> list[Path]:
        system = build(find_scene("paper_b"))
        title = f"Paper B, Fig. {name[1]}: {words}"
        motion, gains = run_on_cart(system, run, 1e-9 if run.s else 1e-12)
        sheet: Figure = (
            paper_b.left_alone(system, motion, title, run.moments)
            if gains is None
            else paper_b.steadied(system, motion, gains, title, run.moments)
        )
        return [save(sheet, out / f"{name}.png", of=[motion] if gains is None else [motion, gains])]

    return write


FIGURES: Mapping[str, Callable[[Path], list[Path]]] = {
    "A2": _tracking,
    **{f"A{links + 2}": _waves(links) for links in (1, 2, 3, 4)},
    "A7": _charts,
    "B2": _on_cart(
        "B2", FIG_2, "five links on a cart, left alone (one run; where it goes is determined up to 4 s)"
    ),
    "B3": _on_cart("B3", FIG_3, "brought to hanging"),
    "B4": _on_cart("B4", FIG_4, "steadied with three links up, two folded down"),
    **{f"E{links}": energies(links) for links in (2, 3, 4)},
    "G4": gap,
    "N2": network,
    "C2": conical,
    "U2": climbed,
}
"""Name -> what draws it into a folder."""
