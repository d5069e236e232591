"""Runtime parameters as the command line is given them, `--set NAME=A,B,...`, held against what the scene leaves to run time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from phichain.errors import ArrayError

if TYPE_CHECKING:
    from phichain.scene import Scene
    from phichain.system import System

Settings = Annotated[list[str] | None, typer.Option("--set", metavar="NAME=A,B,...", help="A runtime parameter's values; repeatable.")]


def values_given(scene: Scene, settings: Sequence[str] | None, known: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Values of all that a scene leaves to run time, in the shapes that it has them in; one number serves all links.

    Args:
        scene: The scene.
        settings: Words NAME=A,B,...
        known: Values that nobody has to give.

    Raises:
        ArrayError: A word is no NAME=NUMBERS, a name is no runtime parameter of the scene, or one has no value or not as many as links.
    """
    import numpy as np

    from phichain.system.starts import parameters

    values = {**(known or {}), **(parameters(settings or []) or {})}
    demand(scene, values)
    whole = {name: np.broadcast_to(value, scene.runtime_shapes[name]) for name, value in values.items()}
    return {name: value if value.ndim else float(value) for name, value in whole.items()}


def with_values(system: System, scene: Scene, settings: Sequence[str] | None) -> System:
    """The system with values for all that its scene leaves to run time.

    Raises:
        ArrayError: As `values_given`.
    """
    values = values_given(scene, settings)
    return replace(system, params=values) if values else system


def demand(scene: Scene, values: Mapping[str, Any]) -> None:
    """Refuse values that do not fit a scene, in the words of the command line.

    Raises:
        ArrayError: As `values_given`.
    """
    from phichain.contract.words import known_names

    shapes = scene.runtime_shapes
    for name, value in values.items():
        if name not in shapes:
            problem = f"is no runtime parameter of '{scene.name}', which has {', '.join(shapes) or 'none'}"
            raise ArrayError("--set", name, problem, known_names(name, tuple(shapes)) if shapes else f'write {name} = "runtime" in the scene, or its value')
        size = getattr(value, "size", 1)
        if size not in (1, *shapes[name]):
            raise ArrayError("--set", f"{name}={','.join(f'{entry:g}' for entry in value)}", f"has {size} numbers", f"write {_option(name, shapes[name])}, {shapes[name][0] if shapes[name] else 1} of them, or one for all")
    left = [name for name in shapes if name not in values]
    if left:
        raise ArrayError("--set", left, f"are what '{scene.name}' leaves to run time, and have no value", f"write {' '.join(_option(name, shapes[name]) for name in left)}, or one number for all links")


def _option(name: str, shape: tuple[int, ...]) -> str:
    """How a value is given: one number, or one for each link."""
    return f"--set {name}={','.join('ABCD'[: shape[0]]) if shape and shape[0] <= 4 else 'A,B,...' if shape else 'A'}"
