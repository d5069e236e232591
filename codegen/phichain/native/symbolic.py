"""The CasADi module of a generated folder, for integrators that want the equations themselves.

phichain does not import casadi here: the generated module does, when its function is first asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from types import ModuleType
from typing import Any

from phichain.native.signature import Manifest


def casadi_dynamics(manifest: Manifest) -> Callable[[], Any] | None:
    """A callable that makes the casadi.Function of the forward dynamics; None where there is no such thing.

    The module's text is read and checked now, so the folder may go away before the function is wanted.

    Raises:
        OutputError: NAME_casadi.py is missing or was changed since it was generated.
    """
    file = f"{manifest.name}_casadi.py"
    if (
        find_spec("casadi") is None
        or file not in manifest.files
        or "forward_dynamics" not in manifest.functions
    ):
        return None
    text = manifest.source(file)

    @cache
    def dynamics() -> Any:
        module = ModuleType(f"{manifest.name}_casadi")
        # As trusted as the C beside it: the manifest vouches for both.
        exec(compile(text, file, "exec"), module.__dict__)  # noqa: S102
        return module.forward_dynamics()

    return dynamics
