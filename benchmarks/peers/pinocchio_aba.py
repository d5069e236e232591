"""Pinocchio: the articulated-body algorithm and its derivatives, compiled from the headers of its pip package (``pin``)
and called from C.

Chain P only: on the sphere its universal joints are a chart with singular poles and its spherical joints
need a fictitious axial inertia, so neither computes chain S. The headers of Eigen come with the pip package
of CasADi. The one-time compilation takes a minute or two; the result is kept in the user's cache folder
under a digest of everything that went into it.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
from pathlib import Path

import casadi
import cmeel
import pinocchio

from benchmarks.chains import Chain
from benchmarks.harness import BenchmarkError, Candidate, run_compiler

VERSION = pinocchio.__version__
_SOURCE = Path(__file__).with_suffix(".cpp")
# the two macros are what Pinocchio's own build configuration asks of its users
_FLAGS = (
    *("-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-fPIC", "-shared"),
    *("-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"),
)


def build(chain: Chain, folder: Path, jacobian: bool = False) -> Candidate:
    """Pinocchio's model of chain P: the accelerations of the forced one, or the Jacobian of the unforced one.

    Raises:
        BenchmarkError: Another kind of chain.
    """
    plain = chain.space == "planar" and chain.angles == "relative" and chain.cart_mass is None and not chain.runtime
    if not plain or chain.forced == jacobian:
        raise BenchmarkError("Pinocchio is compared on the planar chain with a fixed base and relative angles alone")
    name = "pinocchio_jacobian.so" if jacobian else "pinocchio.so"
    library = Path(shutil.copy(_compiled(), folder / name))  # a copy of its own: the model is global in it
    numbers = [(ctypes.c_double * chain.links)(*values) for values in (chain.mass, chain.length, chain.com)]
    ctypes.CDLL(str(library)).peer_setup(chain.links, *numbers)
    if jacobian:
        return Candidate("Pinocchio computeABADerivatives", library, "peer_jacobian")
    return Candidate("Pinocchio aba", library, "peer_function")


def _compiled() -> Path:
    """The shared object from the cache, compiled first where it is missing."""
    digest = hashlib.sha256(repr((_SOURCE.read_text(), _FLAGS, VERSION)).encode()).hexdigest()[:16]
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "phichain-bench"
    library = cache / f"pinocchio-{digest}.so"
    if not library.exists():
        cache.mkdir(parents=True, exist_ok=True)
        print("compiling Pinocchio's aba from its headers (once, a minute or two)", flush=True)
        unfinished = library.with_suffix(f".{os.getpid()}")
        includes = [f"-I{_prefix() / 'include'}", f"-I{Path(casadi.__file__).parent / 'include' / 'eigen3'}"]
        run_compiler(["c++", *_FLAGS, *includes, str(_SOURCE), "-o", str(unfinished)])
        unfinished.replace(library)
    return library


def _prefix() -> Path:
    """Where the pip packages of the cmeel family put their headers."""
    return Path(cmeel.__file__).parents[1] / "cmeel.prefix"
