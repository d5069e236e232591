"""Stencils compile without a scene, in every form that one could ask for; and what `instance` makes of them."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest

from phichain.emit import stencil
from phichain.emit.stencil import instance, stencils_folder
from phichain.errors import EmissionError
from tests.generated.compiling import need

#: Warnings that no stencil may cause.
STRICT = (
    "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion", "-Wshadow",
    "-Wcast-qual", "-Wundef", "-Wvla", "-Wfloat-equal", "-Werror",
)  # fmt: skip
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)] or ["cc"]
STENCILS = ("norms", "turns", "series", "length", "event", "columns", "run")
FLOW = ("norms", "turns", "series", "length", "event", "run", "batch", "fused", "drive", "sums", "move", "rubs", "shared", "shared_sums")
COLUMNS = ("parameters", "links", "products", "sums", "series")
BESIDE = ("pairs", "steps", "defects", "neighbours")
SPACES: tuple[dict[str, int], ...] = ({"WITH_TURNS": 1}, {}, {"WITH_SPHERE": 1})
Combination = dict[str, int]


def combinations() -> Iterator[Combination]:
    """Every combination of features that a scene can have; what has no part in a feature takes turns."""
    forms = [
        {"ALONE_BATCH": 0, "WITH_COLUMNS": columns, **stack}
        for columns, stack in product((0, 1), ({}, {"PHI_WORK_ON_STACK": 1}))
    ]
    forms.append({"ALONE_BATCH": 1, "WITH_COLUMNS": 0})
    chosen = product(SPACES, forms, (0, 1), (0, 1), (0, 1), (0, 1))
    for number, (space, form, inputs, squares, lost, scales) in enumerate(chosen):
        is_alone = not (form["ALONE_BATCH"] and "WITH_SPHERE" in space or form["WITH_COLUMNS"] * (number // 7 % 2) or squares or number // 9 % 2 or number // 11 % 2 or number // 13 % 2)
        is_plain = not (form["ALONE_BATCH"] or number // 3 % 2 or number // 9 % 2)
        yield {
            "WITH_BESIDE": int(is_plain and number // 2 % 2 == 0),
            "WITH_PAIRS": int(is_plain and number // 2 % 2 == 0 and "WITH_SPHERE" not in space and not (squares or number // 11 % 2 or number // 13 % 2)),
            "WITH_TURNS": 0, "WITH_SPHERE": 0, **space, **form, "WITH_INPUTS": inputs, "WITH_SQUARES": squares, "WITH_LOST": lost,
            "WITH_FORCING": number // 9 % 2, "WITH_OWN_TRIGONOMETRY": number // 9 % 2 * (number // 13 % 2),
            "WITH_LINKS": int(form["WITH_COLUMNS"] and not squares and "WITH_SPHERE" not in space and number // 5 % 2 == 0 and not number // 13 % 2),
            "WITH_ANGLES": int(not form["ALONE_BATCH"] and not squares and "WITH_SPHERE" not in space and number // 5 % 2 == 0),
            "WITH_PARAMETERS": form["WITH_COLUMNS"] * (number // 7 % 2), "WITH_SCALES": scales, "ALONE_PARAMS": (0, 2)[number // 2 % 2] if scales else 1, "ALONE_FLOAT": number // 3 % 2,
            "ALONE_VECTORS": number // 5 % 2, "ALONE_CART": number % 3, "ALONE_NEWEST": number // 7 % 2, "WITH_DRY": number // 11 % 2, "WITH_RUBS": number // 13 % 2, "WITH_SPRINGS": number // 17 % 2,
            "WITH_SHARED": int(form["ALONE_BATCH"] and "WITH_SPHERE" in space), "WITH_CROSSED": number // 7 % 2,
            "WITH_OUTRIGHT": int(is_alone and number // 2 % 2 == 0),
        }  # fmt: skip


def emitted() -> list[Path]:
    """The stencils of flows and of their columns."""
    return [path for part in ("flow", "columns", "beside") for path in (stencils_folder() / part).iterdir()]


def compile_alone(folder: Path, compiler: str, made: list[tuple[int, Combination]], *flags: str) -> None:
    """Compile the first so many stencils with these features; fail with whatever the compiler says."""
    files = []
    for number, (count, combination) in enumerate(made):
        words = {"ALONE_COUNT": count, **combination}
        lines = [f"#define {name} {value}" for name, value in words.items()]
        files.append(folder / f"alone_{number}.c")
        files[-1].write_text("\n".join([*lines, '#include "alone.c"', ""]), encoding="utf-8")
    done = subprocess.run(
        [compiler, *STRICT, f"-I{stencils_folder()}", *flags, *(file.name for file in files)],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and not done.stderr, done.stderr


@pytest.mark.long
@pytest.mark.parametrize("compiler", COMPILERS)
def test_all_together_in_every_combination(compiler: str, tmp_path: Path) -> None:
    need(compiler)
    every = list(combinations())
    assert len({tuple(sorted(combination.items())) for combination in every}) == len(every) == 240
    for value in ("ALONE_FLOAT", "ALONE_VECTORS", "ALONE_NEWEST", "WITH_FORCING", "WITH_OWN_TRIGONOMETRY"):
        assert {(c[value], c["ALONE_BATCH"], c["WITH_SPHERE"]) for c in every} == set(
            product((0, 1), repeat=3)
        )
    compile_alone(
        tmp_path, compiler, [(len(STENCILS), combination) for combination in every], "-fsyntax-only"
    )


@pytest.mark.long
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("count", range(1, len(STENCILS) + 1), ids=STENCILS)
def test_each_behind_those_it_leans_on(count: int, compiler: str, tmp_path: Path) -> None:
    """The optimiser sees more: what may be used before it has a value."""
    need(compiler)
    compile_alone(
        tmp_path,
        compiler,
        [(count, combination) for combination in list(combinations())[:: 59 + count]],
        "-c",
        "-O2",
    )


def test_no_stencil_is_left_out() -> None:
    text = (stencils_folder() / "alone.c").read_text(encoding="utf-8")
    flows = {f"{path.parent.name}/{path.name}" for path in emitted()}
    assert flows == set(re.findall(r'#include "(\w+/\w+\.c)"', text))
    assert flows == {f"flow/{name}.c" for name in FLOW} | {f"{part}/{name}.c" for part, names in (("columns", COLUMNS), ("beside", BESIDE)) for name in names}
    asked = {
        name for path in flows for name in re.findall(r"WITH_\w+", (stencils_folder() / path).read_text())
    }
    assert asked == {name for name in next(combinations()) if name.startswith("WITH_")}


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("flow/length.c", "memcpy(&bits, length, sizeof bits);", "memcpy(&bits, *length, sizeof bits);"),
        ("flow/norms.c", "stem_lanes size = STEM_SIZE(x[i]);", "int size = STEM_SIZE(x[i]);"),
        ("flow/turns.c", "STEM_AT(jet->turns[i], lane) += turns;", ""),
        ("beside/neighbours.c", "room->lost = room->lost ||", "room->lost = &room->lost ||"),
        ("flow/run.c", "#ifdef PHI_WORK_ON_STACK\n    return", "#if WITH_STACKS\n    return"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_found(
    file: str, right: str, wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stencil with a wrong type, a narrowed number, a value nobody uses, a feature that does not exist."""
    spoilt = tmp_path / "stencils"
    shutil.copytree(stencils_folder(), spoilt)
    text = (spoilt / file).read_text(encoding="utf-8")
    assert text.count(right) == 1
    if wrong:
        (spoilt / file).write_text(text.replace(right, wrong), encoding="utf-8")
    else:
        (spoilt / file).write_text(text.replace(right, "const phi_real idle = turns;"), encoding="utf-8")
    monkeypatch.setattr("tests.emit.test_stencil.stencils_folder", lambda: spoilt)
    with pytest.raises(AssertionError, match="error"):
        compile_alone(tmp_path, COMPILERS[0], [(len(STENCILS), next(combinations()))], "-fsyntax-only")


def test_what_stands_in_for_a_scene_is_never_emitted() -> None:
    for path in (Path(stencil.__file__).parent).rglob("*.py"):
        assert "alone" not in re.findall(r'instance\("([\w/]+)"', path.read_text(encoding="utf-8"))
    for path in emitted():
        assert "ALONE" not in path.read_text(encoding="utf-8")
        assert "#include" not in path.read_text(encoding="utf-8")


# --- what they compute -------------------------------------------------------------------------------------------------


def said(folder: Path, program: str, **words: int) -> list[float]:
    """The numbers that a C program around stencils prints."""
    need(COMPILERS[0])
    features = [f"-D{name}={value}" for name, value in ({name: 0 for name in next(combinations())} | words).items()]
    source = Path(__file__).parents[1] / "data" / "stencils" / f"{program}.c"
    command = [COMPILERS[0], "-std=gnu99", "-O1", "-w", f"-I{stencils_folder()}", *features, str(source), "-o", "said", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return [float(word) for word in subprocess.run([folder / "said"], capture_output=True, text=True, check=True).stdout.split()]


@pytest.mark.parametrize("words", [{"ALONE_BATCH": 0}, {"ALONE_BATCH": 1, "ALONE_VECTORS": 1, "WITH_SHARED": 1, "WITH_CROSSED": 1}, {"ALONE_BATCH": 1}])
def test_blocks_of_four_orders_are_the_whole_sums(words: dict[str, int], tmp_path: Path) -> None:
    """At every start of a block, and without a look at rows that come later."""
    apart = said(tmp_path, "sums", WITH_SPHERE=1, WITH_SQUARES=1, WITH_SCALES=1, **words)
    assert len(apart) == 67 and max(apart) < 1e-14


def test_zeros_take_few_looks(tmp_path: Path) -> None:
    """To the last digit, and no faster method needs many fewer."""
    found = said(tmp_path, "zeros", WITH_SCALES=1)
    exact = [math.pi / 10, math.log(1.3), 0.3, 1e-9, -0.7]
    assert found[::2] == pytest.approx(exact, rel=4e-16, abs=0)
    assert max(found[1::2]) <= 9


# --- instances ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of stencils of the test's own."""
    monkeypatch.setattr(stencil, "stencils_folder", lambda: tmp_path)
    stencil._text.cache_clear()
    yield tmp_path
    stencil._text.cache_clear()


NESTED = """\
before
#if WITH_A
a
#if !WITH_B
a, not b
#else
a and b
#endif
#else
not a
#ifdef __GNUC__
not a, gcc
#else
not a, others
#endif
#endif
#if defined(__GNUC__)
gcc
#if WITH_B
gcc, b
#endif
#endif
after
"""


@pytest.mark.parametrize(
    ("a", "b", "kept"),
    [
        (True, False, ["a", "a, not b"]),
        (True, True, ["a", "a and b"]),
        (False, True, ["not a", "#ifdef __GNUC__", "not a, gcc", "#else", "not a, others", "#endif"]),
    ],
)
def test_features_nest_and_conditions_of_the_compiler_stay(
    folder: Path, a: bool, b: bool, kept: list[str]
) -> None:
    (folder / "nested.c").write_text(NESTED, encoding="utf-8")
    lines = instance("nested", {}, {"WITH_A": a, "WITH_B": b}).splitlines()
    both = ["gcc, b"] if b else []
    assert lines == ["before", *kept, "#if defined(__GNUC__)", "gcc", *both, "#endif", "after"]


def test_a_feature_that_nobody_knows_is_refused(folder: Path) -> None:
    (folder / "wrong.c").write_text("#if WITH_WINGS\nflap\n#endif\n", encoding="utf-8")
    with pytest.raises(EmissionError, match=r"WITH_WINGS.*WITH_A, WITH_B"):
        instance("wrong", {}, {"WITH_B": True, "WITH_A": False})


def test_names_are_put_in_whole_ones_first(folder: Path) -> None:
    text = (
        "stem_lanes a = stem_larger(PASS x, PHI_HALF); system_lanes b; NEWEST(row[n]) c; stem_ d; EMPTY e\n"
    )
    (folder / "named.c").write_text(text, encoding="utf-8")
    names = {
        "stem_": "chain_flow_",
        "stem_lanes": "chain_real",
        "PASS": "p, ",
        "PHI_HALF": "0.5",
        "NEWEST": "",
        "EMPTY": "",
    }
    made = instance("named", names, {})
    assert made == "chain_real a = chain_flow_larger(p, x, 0.5); system_lanes b; c; stem_ d; e\n"
    assert instance("named", names | {"NEWEST": "given", "PASS": ""}, {}) == made.replace("p, ", "").replace(
        "; c", "; row[n], c"
    )
