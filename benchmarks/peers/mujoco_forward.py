"""MuJoCo: its minimal forward-dynamics pipeline called from C, out of its pip package.

Chain P only. MuJoCo refuses bodies without rotational inertia, so each point mass gets a millionth of a
millionth of ``m r^2``; the error column shows what that costs.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import mujoco

from benchmarks.chains import GRAVITY, Chain
from benchmarks.harness import C_FLAGS, BenchmarkError, Candidate, run_compiler

VERSION = mujoco.__version__
_SOURCE = Path(__file__).with_suffix(".c")


def build(chain: Chain, folder: Path) -> Candidate:
    """MuJoCo's model of a forced chain P."""
    plain = chain.space == "planar" and chain.angles == "relative" and chain.cart_mass is None and not chain.runtime
    if not plain or not chain.forced:
        raise BenchmarkError("MuJoCo is compared on the forced planar chain with a fixed base alone")
    package = Path(mujoco.__file__).parent
    shared = next(iter(package.glob("libmujoco.so*")))
    library, scene = folder / "mujoco.so", folder / "chain.xml"
    scene.write_text(xml(chain))
    links = [f"-I{package / 'include'}", str(shared), f"-Wl,-rpath,{package}"]
    run_compiler(["cc", "-std=c99", *C_FLAGS, "-fPIC", "-shared", str(_SOURCE), *links, "-o", str(library)])
    reason = ctypes.create_string_buffer(500)
    if ctypes.CDLL(str(library)).peer_setup(str(scene).encode(), reason, len(reason)):
        raise BenchmarkError(f"MuJoCo refused the chain: {reason.value.decode()}")
    return Candidate("MuJoCo", library, "peer_function")


def xml(chain: Chain) -> str:
    """Nested bodies hinged about x, gravity along -z."""
    opening, closing = [], []
    for k, (mass, com) in enumerate(zip(chain.mass, chain.com, strict=True)):
        drop = -chain.length[k - 1] if k else 0.0
        # no less than MuJoCo's own floor of 1e-15 kg m^2
        inertia = max(1e-12 * mass * com**2, 2e-15)
        opening.append(
            f'<body pos="0 0 {drop!r}"><joint type="hinge" axis="1 0 0"/>'
            f'<inertial mass="{mass!r}" pos="0 0 {-com!r}"'
            f' diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
        )
        closing.append("</body>")
    option = f'<option gravity="0 0 {-GRAVITY}"><flag contact="disable"/></option>'
    return f"<mujoco>{option}<worldbody>{''.join(opening)}{''.join(closing)}</worldbody></mujoco>"
