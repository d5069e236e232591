"""What a generated folder does without, and why: the reasons, as the manifest and its README state them."""

from __future__ import annotations

from typing import Final

from phichain.contract.functions import TABLE
from phichain.emit.printed import Printed

#: Why functions are absent: which ones there are is said by the command, and not in every folder.
OTHERS: Final = "not wanted by the scene; `phichain functions` lists all that it could want"


def left_out(printed: Printed) -> dict[str, str]:
    """Reason by what is absent."""
    scene = printed.scene
    kinds = {kind for function in printed.programs.functions for kind in function.counts}
    is_partial = any(row.is_missed and row.name not in scene.want for row in TABLE)
    absent = {"other functions": OTHERS} if is_partial else {}
    if scene.base_law.left_out:
        absent["cart terms"] = scene.base_law.left_out
    if not scene.runtime:
        absent["params struct"] = "every parameter is a number and folded into the code"
    if scene.damping is None:
        absent["dampers"] = "the joints carry none"
    if scene.stiffness is None:
        absent["springs"] = "the joints carry none"
    if not scene.nu:
        absent["input u"] = "nothing is actuated"
    if not kinds & {"sin", "cos"} and scene.forced is None:
        reason = "unit vectors serve" if not scene.is_planar else "no wanted function needs an angle"
        absent["trigonometry"] = reason
    if not any(kind.startswith("bessel") for kind in kinds):
        absent["Bessel functions"] = "only phi needs them"
    if scene.armature is not None:
        absent["link tensions"] = "the joints carry rotors, so that articulated inertias serve"
    elif scene.tip_masses:
        absent["articulated inertias"] = "all masses sit at the link ends, so that link tensions serve"
    elif scene.inertia is not None:
        absent["link tensions"] = "links have moments of inertia, so that articulated inertias serve"
    else:
        absent["link tensions"] = "some mass sits before its link's end, so that articulated inertias serve"
    return absent
