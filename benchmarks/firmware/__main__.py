"""`make firmware`: every check on generated C, or with --write the table of what it costs."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

from benchmarks.firmware.points import (
    analysis,
    example,
    interface,
    loops,
    manifests,
    objects,
    packages,
    runs,
    sizes,
)
from benchmarks.firmware.scenes import Generated, generated
from benchmarks.firmware.tools import Missing, demand

Check = Callable[[Mapping[str, Generated]], Iterator[str]]
CHECKS: Final[tuple[Check, ...]] = (
    objects.imports, objects.numbers, objects.memory, objects.frames, objects.one_image, interface.precision, interface.hooks, interface.headers,
    interface.same_bytes, runs.selftests, runs.bits, runs.motions, runs.instructions, sizes.bounds, sizes.flow_bounds, sizes.shape, sizes.ceilings, sizes.errors,
    analysis.compilers, analysis.analysers, analysis.sanitizers, packages.packages, manifests.manifests,
    example.example, loops.loops,
)  # fmt: skip


def main(words: list[str]) -> int:
    """Run the checks; 1 where one finds something, 2 where a tool is missing."""
    try:
        demand()
    except Missing as refusal:
        print(refusal, file=sys.stderr)
        return 2
    if "--write" in words:
        from benchmarks.firmware.table import write

        write()
        return 0
    with tempfile.TemporaryDirectory() as root:
        return _checked(generated(Path(root)))


def _findings(check: Check, folders: Mapping[str, Generated]) -> tuple[list[str], float]:
    """What a check finds, and how long it took."""
    began = time.perf_counter()
    try:
        found = list(check(folders))
    except RuntimeError as error:
        found = [str(error)]
    return found, time.perf_counter() - began


def _checked(folders: Mapping[str, Generated]) -> int:
    failed = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for check, (found, seconds) in zip(CHECKS, pool.map(lambda check: _findings(check, folders), CHECKS), strict=True):
            line = (check.__doc__ or check.__name__).splitlines()[0]
            print(f"{'FAILED' if found else 'passed'}  {line}  ({seconds:.1f} s)", flush=True)
            for one in found:
                print(f"        {one}")
            failed += bool(found)
    print(f"{len(CHECKS) - failed} of {len(CHECKS)} firmware checks passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
