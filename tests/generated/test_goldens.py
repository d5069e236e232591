"""The emitted text: equal to the committed samples, to the byte, whoever generates it, wherever, however often.

`pytest tests/generated --update` writes generated/reference/ anew; read the difference before committing it.
"""

from __future__ import annotations

import getpass
import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Mapping
from difflib import unified_diff
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from phichain.emit import folder_files
from phichain.files import MANIFEST, write_folder
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.scene import Scene
from tests.generated.reference_scenes import FOLDER, REFERENCE

ROOT = Path(__file__).parents[2]
MOST_SHOWN = 40


def proven_files(scene: Scene, with_casadi_c: bool = False) -> dict[str, str]:
    """What `generate` writes."""
    lowered = lower(derive(scene))
    return folder_files(scene, lowered, with_casadi_c, prove(lowered.model, lowered).record)


@cache
def generated(name: str) -> Mapping[str, str]:
    """The files of a reference scene, with the opt-in C for CasADi where there is one."""
    scene = REFERENCE[name]
    return proven_files(scene, with_casadi_c=scene.real == "double")


def sample(name: str) -> dict[str, str]:
    """The files of which the committed sample consists."""
    scene = REFERENCE[name]
    return proven_files(scene)


@pytest.mark.parametrize("name", REFERENCE)
def test_the_committed_sample_is_what_is_generated(name: str, update: bool) -> None:
    folder, files = FOLDER / name, sample(name)
    if update:
        write_folder(folder, files)
    assert {path.name for path in folder.iterdir() if path.is_file()} == set(files)
    for file, text in files.items():
        committed = (folder / file).read_text()
        if file == MANIFEST:
            assert without_versions(committed) == without_versions(text)
        elif committed != text:
            pytest.fail(
                f"{file} differs; refresh with --update and read the difference\n{difference(committed, text)}"
            )


def without_versions(manifest: str) -> Any:
    """A manifest's record but for the versions of the tools that wrote it."""
    record = json.loads(manifest)
    assert set(record.pop("generator")) == {"phichain", "sympy", "jinja2"}
    return record


def difference(committed: str, text: str) -> str:
    lines = unified_diff(
        committed.splitlines(), text.splitlines(), "committed", "generated", lineterm="", n=1
    )
    return "\n".join(islice(lines, MOST_SHOWN))


def test_no_sample_is_left_from_a_scene_that_is_gone() -> None:
    assert {path.name for path in FOLDER.iterdir() if path.is_dir()} == set(REFERENCE)


@pytest.mark.parametrize("seed", ["1", "4294967295"])
def test_bytes_depend_neither_on_the_hash_seed_nor_on_the_folder(seed: str, tmp_path: Path) -> None:
    """A process of its own, another working folder, another language, another day's environment.

    Two more seeds, over every committed scene: test_processors.
    """
    script = (
        "from phichain import generate\n"
        "from tests.generated.reference_scenes import REFERENCE\n"
        "for scene in REFERENCE.values():\n"
        "    generate(scene, 'out', with_casadi_c=scene.real == 'double')\n"
    )
    environment = {
        **os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join([str(ROOT / "codegen"), str(ROOT)]),
        "LC_ALL": "C", "TZ": "Pacific/Auckland", "SOURCE_DATE_EPOCH": seed,
    }  # fmt: skip
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, check=True, timeout=300)
    for name in REFERENCE:
        folder = tmp_path / "out" / name
        assert {path.name: path.read_text() for path in folder.iterdir()} == dict(generated(name))


@pytest.mark.parametrize("name", REFERENCE)
def test_nothing_in_the_text_says_when_where_or_by_whom(name: str, tmp_path: Path) -> None:
    people_and_places = {str(ROOT), str(Path.home()), str(Path.cwd()), str(tmp_path), socket.gethostname()}
    if len(getpass.getuser()) > 4:
        people_and_places.add(getpass.getuser())
    for file, text in generated(name).items():
        assert not [word for word in people_and_places if len(word) > 1 and word in text], file
        assert not re.search(r"\b(19|20)\d\d-\d\d-\d\d\b|\b\d\d:\d\d:\d\d\b", text), file
        assert not re.search(r"(?<![\w.)}]|\*)/(usr|tmp|opt|var|etc|mnt|srv)/", text), file


@pytest.mark.parametrize("name", REFERENCE)
def test_the_text_is_plain(name: str) -> None:
    """ASCII, line ends of one kind, no tabs, no blanks at line ends, C no wider than a page."""
    for file, text in generated(name).items():
        assert text.isascii() and text.endswith("\n") and not text.endswith("\n\n"), file
        assert "\r" not in text and "\t" not in text and not re.search(r" $", text, re.MULTILINE), file
        assert "\n\n\n" not in text or file.endswith(".py"), file
        if file in (f"{name}.c", f"{name}.h", "selftest.c"):
            assert max(map(len, text.splitlines())) <= 110, file


# --- what the C says -------------------------------------------------------------------------------------------------


def code_of(text: str) -> str:
    """C without comments and strings."""
    return re.sub(r"/\*.*?\*/|\"[^\"\n]*\"", " ", text, flags=re.DOTALL)


DOUBLE_LITERAL = re.compile(
    r"(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE])|0[xX][\da-fA-F.]+(?=[pP]))(?:[eEpP][+-]?\d+)?(?![\w.])"
)
DOUBLE_FUNCTIONS = {
    "sin", "cos", "tan", "sqrt", "fabs", "floor", "ceil", "round", "rint", "pow", "fmod", "exp", "log", "hypot", "fma",
    "atan2", "asin", "acos", "remainder", "remquo", "ldexp", "frexp", "scalbn", "copysign", "fmax", "fmin", "j0", "j1", "jn",
}  # fmt: skip


def doubles_in(code: str) -> set[str]:
    """Literals, types and functions of double precision."""
    called = set(re.findall(r"\b([A-Za-z_]\w*)\s*\(", code))
    types = {"double"} & set(re.findall(r"\w+", code))
    return set(DOUBLE_LITERAL.findall(code)) | (called & DOUBLE_FUNCTIONS) | types


def float_folder() -> Mapping[str, str]:
    return generated("cart1_float")


@pytest.mark.parametrize("file", ["cart1_float.c", "cart1_float.h", "selftest.c"])
def test_single_precision_text_holds_no_double(file: str) -> None:
    code = code_of(float_folder()[file])
    if file == "selftest.c":
        code = re.sub(r"\(double\)\w+", "", code)  # printf takes no other
    assert doubles_in(code) == set()


def test_doubles_would_be_found() -> None:
    assert doubles_in("x = 0.5 * y + 1.0e-3F; z = sin(y) + sinf(y) + 2.0F;") == {"0.5", "sin"}
    assert doubles_in("double a = 0x1.8p+3; b = 0x1.8p+3F; c = 1e5; int d = 15; e[3] = .5;") == {
        "double", "0x1.8p+3", "1e5", ".5",
    }  # fmt: skip
    assert len(doubles_in(code_of(generated("planar2")["planar2.c"]))) > 10


@pytest.mark.parametrize("name", REFERENCE)
def test_the_c_leaves_small_things_out(name: str) -> None:
    """No allocation, no state, no recursion, no power function, no sign after an operator, no parenthesised number."""
    code = code_of(generated(name)[f"{name}.c"]).replace("__attribute__((aligned(64)))", "")
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|pow|powf|printf)\s*\(", code)
    assert not re.search(r"^\s*static (?!const\b|(\w+_(APART|SINGLY) )?(void|int|uint\w+|\w+_real) \w+\()", code, re.MULTILINE)
    assert not re.search(r"[-+*/] -\w|\(\d[\d.]*F?\)", code)
    for function in REFERENCE[name].want:
        (body,) = re.findall(
            rf"^(?:void|int) {name}_{function}\([^)]*\)\n{{\n(.*?)^}}", code, re.MULTILINE | re.DOTALL
        )
        assert not re.search(rf"\b{name}_{function}\(", body), "recursion"


@pytest.mark.parametrize("name", REFERENCE)
def test_sines_and_cosines_come_in_pairs_from_the_kernel(name: str) -> None:
    code = code_of(generated(name)[f"{name}.c"])
    functions = code[code.index(f"void {name}_forward_dynamics") :]
    assert not re.search(r"\b(sin|cos)f?\(", functions)
    turning = REFERENCE[name].space == "planar" or "step_lie4" in REFERENCE[name].want
    assert (f"{name}_sincos(" in functions) == turning


@pytest.mark.parametrize("name", REFERENCE)
def test_the_header_explains_every_argument(name: str) -> None:
    text = generated(name)[f"{name}.h"]
    documented = rf"/\* ([^/]*?)\*/\n(?:void|int) {name}_\w+\((.*?)\);"
    for comment, arguments in re.findall(documented, text, re.DOTALL):
        names = [
            re.sub(r"\[\d+\]", "", argument).split()[-1].lstrip("*") for argument in arguments.split(",")
        ]
        rows = re.findall(r"^ \*   (\w+(?:, \w+)*)\s+(?:in|out|in, out) +\S", comment, re.MULTILINE)
        assert [argument for row in rows for argument in row.split(", ")] == names
    assert len(re.findall(rf"^(?:void|int) {name}_", text, re.MULTILINE)) == len(REFERENCE[name].want)
