"""A motion as a moving picture: the chain at equal steps of time, over the path that its tip leaves."""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from phichain.errors import OutputError, UnsupportedError
from phichain.files import write_file
from phichain.report.geometry import Outline, joints
from phichain.report.origins import in_gif, in_page, told
from phichain.report.panels import VIEWS
from phichain.report.style import ACCENT, INK, SOFT, figure, look
from phichain.system.arrays import positive, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS: Final = (".gif", ".html", ".mp4")
MOST_FRAMES: Final = 1500
FINER: Final = 8
"""Points of the tip's path for every frame."""
TAIL: Final = 0.15
"""Part of the motion during which the tip's path fades."""


class Moving(Protocol):
    """A motion that can be sampled at will."""

    @property
    def name(self) -> str: ...
    @property
    def t(self) -> np.ndarray: ...
    @property
    def q(self) -> np.ndarray: ...
    def resample(self, points: int, /) -> Moving: ...


def write_motion(chain: Outline, motion: Moving, path: Path, seconds: float | None, fps: int, of: Any = None) -> Path:
    """Write a motion as GIF, HTML or MP4.

    Args:
        chain: The chain.
        motion: How it moves.
        path: The file.
        seconds: How long it plays; as long as it lasted unless given.
        fps: Frames a second.
        of: The record that it shows; the motion itself unless given.

    Raises:
        OutputError: The name does not say which, or it cannot be written.
        UnsupportedError: matplotlib or ffmpeg is not installed.
        ToleranceError: seconds or fps are not positive, or make too many frames.
    """
    if path.suffix not in KINDS:
        raise OutputError("path", str(path), "has no suffix that says what to write", f"name it {', '.join(KINDS[:-1])} or {KINDS[-1]}")
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise UnsupportedError("path", str(path), "needs ffmpeg, which is not installed", "install it, or name the file .gif or .html")
    fps = whole("fps", fps, 1, 60, "use 1 to 60 frames a second")
    lasted = abs(float(motion.t[-1] - motion.t[0]))
    plays = lasted if seconds is None else positive("seconds", seconds, "use a time in s")
    frames = whole("frames", max(2, round(plays * fps)), 2, MOST_FRAMES, f"play it in fewer seconds: fps times seconds is at most {MOST_FRAMES}")
    points = joints(chain, motion.resample((frames - 1) * FINER + 1).q)
    with look():
        from matplotlib.animation import FuncAnimation

        drawing = figure(6.4, 6.0) if points.shape[-1] == 3 else figure(4.8, 4.8)
        speed = lasted / plays
        pace = "" if abs(speed - 1.0) < 1e-9 else f", {speed:.3g} x"
        drawing.suptitle(f"{motion.name}{pace}", fontsize=10)
        clock = drawing.text(0.99, 0.01, "", ha="right", fontsize=8, color=SOFT)
        panels = _panels(drawing, chain, points)
        times = np.linspace(motion.t[0], motion.t[-1], frames)

        def show(k: int) -> list[Any]:
            clock.set_text(f"t = {times[k]:.2f} s")
            return [artist for panel in panels for artist in panel.at(FINER * k)]

        # Places are found once: finding them anew for every frame takes most of the time, and makes panels tremble.
        drawing.draw_without_rendering()
        drawing.set_layout_engine("none")
        moving = FuncAnimation(drawing, show, frames=frames, interval=1000 / fps, blit=False, cache_frame_data=False)
        return write_file(path, _encoded(moving, path.suffix, fps, told(motion if of is None else of)))


def _encoded(moving: Any, kind: str, fps: int, origin: str) -> bytes:
    """The bytes of the moving picture, with where it comes from."""
    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if kind == ".html":
        with rc_context({"animation.embed_limit": 200.0}):
            text: str = moving.to_jshtml(fps=fps, default_mode="loop")
        return f"{in_page(origin)}\n{_alone(text)}".encode()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, f"motion{kind}")
        writer = PillowWriter(fps=fps) if kind == ".gif" else FFMpegWriter(fps=fps, metadata={"comment": origin})
        moving.save(file, writer=writer, dpi=100)
        return in_gif(file.read_bytes(), origin) if kind == ".gif" else file.read_bytes()


def _alone(text: str) -> str:
    """The page without the font of icons that it would fetch from a network: signs stand on its buttons."""
    plain = re.sub(r"<link[^>]*font-awesome[^>]*>", "", text)
    return re.sub(r'<i class="fa fa-([\w-]+)( fa-flip-horizontal)?"></i>', lambda icon: _SIGNS.get(icon[1] + "-back" * bool(icon[2]), icon[1]), plain)


_SIGNS: Final = {
    "minus": "-", "plus": "+", "fast-backward": "|&lt;", "step-backward": "&lt;", "play-back": "&#9664;", "pause": "||", "play": "&#9654;",
    "step-forward": "&gt;", "fast-forward": "&gt;|",
}  # fmt: skip


class _Panel:
    """One view: chain, path of the tip, cart."""

    def __init__(self, axes: Any, across: np.ndarray, up: np.ndarray, has_cart: bool) -> None:
        self.across, self.up = across, up
        self.tail = max(1, int(TAIL * len(across)))
        (self.path,) = axes.plot([], [], color=ACCENT, linewidth=0.9, alpha=0.7)
        dots = 4.0 if across.shape[1] <= 17 else 0.0
        (self.chain,) = axes.plot([], [], "-o", color=INK, linewidth=1.8, markersize=dots)
        self.cart = axes.plot([], [], "s", color=INK, markersize=10)[0] if has_cart else None
        if has_cart:
            axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=0)
        spread = 0.06 * max(float(np.ptp(across)), float(np.ptp(up)), 1e-9)
        middle, half = (across.max() + across.min()) / 2, max(np.ptp(across), 0.6 * np.ptp(up)) / 2 + spread
        axes.set(xlim=(middle - half, middle + half), ylim=(up.min() - spread, max(up.max(), 0.0) + spread))
        axes.set_aspect("equal", adjustable="box")

    def at(self, k: int) -> list[Any]:
        """The artists at a frame."""
        self.chain.set_data(self.across[k], self.up[k])
        behind = slice(max(0, k - self.tail), k + 1)
        self.path.set_data(self.across[behind, -1], self.up[behind, -1])
        if self.cart is not None:
            self.cart.set_data(self.across[k, :1], self.up[k, :1])
        return [self.chain, self.path]


class _Space:
    """The view in perspective."""

    def __init__(self, axes: Any, points: np.ndarray) -> None:
        self.points = points
        (self.chain,) = axes.plot([], [], [], "-o", color=INK, linewidth=1.6, markersize=3.0)
        (self.path,) = axes.plot([], [], [], color=ACCENT, linewidth=0.8, alpha=0.7)
        half = max(float(np.ptp(points[..., axis])) for axis in range(3)) / 2 or 1.0
        for axis, name in enumerate("xyz"):
            middle = (points[..., axis].max() + points[..., axis].min()) / 2
            getattr(axes, f"set_{name}lim")(middle - half, middle + half)
        axes.set_box_aspect((1, 1, 1))
        axes.tick_params(labelsize=6)

    def at(self, k: int) -> list[Any]:
        """The artists at a frame."""
        self.chain.set_data_3d(*self.points[k].T)
        behind = slice(max(0, k - max(1, int(TAIL * len(self.points)))), k + 1)
        self.path.set_data_3d(*self.points[behind, -1].T)
        return [self.chain, self.path]


def _panels(drawing: Figure, chain: Outline, points: np.ndarray) -> list[Any]:
    """One view of a planar chain; three and one in perspective of one in space, whose last axis points down."""
    upright = points * np.array([1.0] * (points.shape[-1] - 1) + [-1.0])
    if points.shape[-1] == 2:
        axes = drawing.add_subplot()
        axes.set(xlabel="$e_1$ (m)", ylabel="height (m)")
        return [_Panel(axes, upright[..., 0], upright[..., 1], chain.has_cart)]
    found: list[Any] = []
    for place, (title, right, up) in enumerate(VIEWS, 1):
        axes = drawing.add_subplot(2, 2, place)
        axes.set_title(title)
        axes.set(xlabel=f"$e_{right + 1}$ (m)", ylabel="height (m)" if up == 2 else "$e_2$ (m)")
        found.append(_Panel(axes, upright[..., right], upright[..., up], chain.has_cart))
    found.append(_Space(drawing.add_subplot(2, 2, 4, projection="3d"), upright))
    return found
