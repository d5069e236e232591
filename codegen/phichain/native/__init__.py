"""Build: a generated folder compiled by the system C compiler, cached, verified, loaded and made callable."""

from phichain.native.cache import Cache, CacheInfo, CacheWarning, default_cache
from phichain.native.closed_loop import ClosedLoop, load_closed_loop
from phichain.native.compiler import Compiler, CompilerOptions, find_compiler
from phichain.native.load import build_casadi, build_files, build_folder
from phichain.native.warm import recalled, remember

__all__ = [
    "Cache",
    "CacheInfo",
    "CacheWarning",
    "ClosedLoop",
    "Compiler",
    "CompilerOptions",
    "build_casadi",
    "build_files",
    "build_folder",
    "default_cache",
    "find_compiler",
    "load_closed_loop",
    "recalled",
    "remember",
]
