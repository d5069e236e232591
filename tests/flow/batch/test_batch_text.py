"""The text of batch forms: strict compilers, sanitizers and names have nothing to say."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from phichain.mechanics import derive
from phichain.scene import Scene
from tests.flow.batch.batches import CHAINS, WRITERS, unit
from tests.flow.flows import STRICT, planar


@pytest.mark.long
@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("name", CHAINS)
def test_strict_compilers_have_nothing_to_say(name: str, form: str, tmp_path: Path) -> None:
    for portable in (False, True) if name in ("runtime", "single") else (False,):
        (tmp_path / "batch.c").write_text(unit(CHAINS[name], form, portable))
        command = ["cc", *STRICT, "-O1", "-c", "batch.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0 and not done.stderr, done.stderr[:3000]


MAIN = """
#include <stdlib.h>
int main(void)
{
    for (size_t n = 1; n < 40; n += 1 + n / 4) {
        /* Exactly as long as promised, on the heap, where a sanitizer guards both ends. */
        NAME_real *q = calloc(NQ * n, sizeof *q), *v = calloc(NV * n, sizeof *v), *a = calloc(NV * n, sizeof *a);
        for (size_t i = 0; i < NQ * n; ++i) q[i] = (NAME_real)0.01 * (NAME_real)(i % 17);
        CALL
        free(q); free(v); free(a);
    }
    return 0;
}
"""
CALLS = {
    "forward_dynamics_batch": "NAME_forward_dynamics_batch(n, q, v, a);",
    "propagate_batch": """
        NAME_real *t = calloc(n, sizeof *t), *end = calloc(n, sizeof *end), *lost = calloc((1 + NQ + NV) * n, sizeof *lost);
        NAME_real *work = malloc(UPPER_BATCH_WORK * sizeof *work), times[1] = {0.01};
        unsigned long *steps = calloc(2 * n, sizeof *steps);
        int *result = calloc(n, sizeof *result);
        NAME_flow_batch flow = {(NAME_real)1e-12, 0, t, lost, steps, steps + n, result};
        for (size_t k = 0; k < n; ++k) end[k] = (NAME_real)0.01 * (NAME_real)(1 + k % 3);
        if (NAME_propagate_batch(n, &flow, end, 1000, q, v, NULL, 1, times, a, a, work) != n) return 1;
        free(t); free(end); free(lost); free(work); free(steps); free(result);""",
}


@pytest.mark.parametrize("form", WRITERS)
def test_nothing_beyond_the_arrays_is_touched(form: str, tmp_path: Path) -> None:
    chain = planar(1)
    main = MAIN.replace("CALL", CALLS[form]).replace("NAME", chain.name).replace("UPPER", chain.name.upper())
    main = re.sub(r"\bN[QV]\b", "1", main)
    (tmp_path / "batch.c").write_text(unit(chain, form) + main)
    command = [
        "cc",
        "-std=c99",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "batch.c",
        "-lm",
    ]
    built = subprocess.run(
        [*command, "-o", "guarded"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    if built.returncode != 0 and "sanitize" in built.stderr:
        pytest.skip("the compiler has no sanitizers")
    assert built.returncode == 0, built.stderr[:2000]
    ran = subprocess.run(["./guarded"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[:3000]


@pytest.mark.parametrize("form", WRITERS)
def test_lines_are_short_and_names_have_the_prefix(form: str) -> None:
    chain = CHAINS["cart"]
    made = WRITERS[form](derive(chain))
    text = made.declarations + made.definitions
    assert max(map(len, text.splitlines())) <= 120
    for line in text.splitlines():
        if line.startswith(("static ", "void ", "size_t ", "#define ")):
            assert chain.name in line or chain.name.upper() in line, line


@pytest.mark.parametrize(("links", "bytes_of"), [(2, 64), (3, 64), (5, 256)])
def test_values_of_short_chains_of_unit_vectors_take_one_register(links: int, bytes_of: int) -> None:
    """Else all of them live in memory, and three links take 1.4 times as long; longer ones are bound by latency, which four hide."""
    chain = Scene("some", links, space="spatial", mass=0.1, length=0.1, base="cart", cart_mass=0.5, want=["forward_dynamics_batch"])
    assert re.search(rf"AVX512F__\)\n#define SOME_BATCH_BYTES {bytes_of}\n", unit(chain, "forward_dynamics_batch"))
