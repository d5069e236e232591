"""One trip through everything: two papers' chains from scene to running code, in motion, followed and controlled.

`make run` takes it. Every stop does one thing that a user would do, says what came out, and leaves a section with a
figure in the report.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from phichain.continuation import Branch, trace
from phichain.control import lqr
from phichain.files import write_file
from phichain.library import find_scene
from phichain.pipeline import build, generate
from phichain.report import figures
from phichain.report.html import Section, page
from phichain.report.style import save
from phichain.scene import Scene
from phichain.simulate import Trajectory, simulate
from phichain.start import leaning
from phichain.system import System

PAPER_A, PAPER_B = "paper_a_4", "paper_b"

Facts = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Stop:
    """What one stop of the tour found.

    Attributes:
        title: What was done.
        text: How, and how to read the figure.
        facts: What came out.
        caption: What the figure shows.
        figure: The figure, or None.
        seconds: How long it took.
    """

    title: str
    text: str
    facts: Facts
    caption: str = ""
    figure: Any = None
    seconds: float = 0.0
