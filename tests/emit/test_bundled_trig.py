"""Sines and cosines without a library: errors against 60 digits, range, what lies beyond, and who else may compute them."""

from __future__ import annotations

import ctypes
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest

from phichain.emit.c import sincos as trig
from phichain.emit.c.text import sincos_kernel
from phichain.errors import SceneError, UnsupportedError
from phichain.pipeline import build
from phichain.scene import Scene
from phichain.scratch import folder_texts
from tests.generated.compiling import STRICT, compiled, selftest_program, symbols, write_all, write_c

#: Numbers of single precision beyond 2^11 that lie nearest to multiples of pi/2 in their binades: within 2e-8 to 7e-8.
_NEAREST = [float.fromhex(number) for number in ("0x1.17cc5p+11", "0x1.9a48dep+15", "0x1.9a48dep+16", "0x1.04ccbcp+18", "0x1.04ccbcp+19")]
DTYPE = {"double": np.float64, "float": np.float32}


def scene(trig: str | None = "bundled", real: str = "float", **more: object) -> Scene:
    return Scene("own", 2, mass=0.5, length=0.5, com=0.25, trig=trig, real=real, **more)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def kernels(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ctypes.CDLL]:
    """The kernel of both types, callable."""
    made = {}
    for real in DTYPE:
        folder = tmp_path_factory.mktemp(real)
        lines = [
            *(f"#include <{header}>" for header in trig.HEADERS), f"typedef {real} own_real;", "#define OWN_RESTRICT", "#define OWN_REGISTER", "#define OWN_VALUE const own_real",
            sincos_kernel(scene(real=real), ("sincos",)),
            "void turned(int n, const own_real *angle, own_real *sine, own_real *cosine)",
            "{\n    own_sincos(n, angle, sine, cosine);\n}",
        ]  # fmt: skip
        (folder / "k.c").write_text("\n".join(lines))
        words = ["cc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "k.c", "-o", "k.so"]
        subprocess.run(words, cwd=folder, check=True)
        made[real] = ctypes.CDLL(str(folder / "k.so"))
    return made


def turned(library: ctypes.CDLL, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    sine, cosine = np.empty_like(angles), np.empty_like(angles)
    library.turned(len(angles), *(ctypes.c_void_p(array.ctypes.data) for array in (angles, sine, cosine)))
    return sine, cosine


def hard_angles(real: str) -> np.ndarray:
    """Random angles of every size up to the range, and the numbers nearest to multiples of pi/2, where digits cancel."""
    source = np.random.default_rng(7)
    sizes = 10 ** source.uniform(-6, 6, 1500) * source.choice([-1.0, 1.0], 1500)
    turns = np.concatenate([np.arange(1, 200), source.integers(200, 636_000, 700)])
    with mpmath.workdps(40):
        near = [float(int(k) * mpmath.pi / 2) for k in turns]
    angles = np.concatenate([sizes, near, _NEAREST]).astype(DTYPE[real])
    return angles[np.abs(angles) <= trig.RANGE]


def worst(found: np.ndarray, exact: list[mpmath.mpf], digits: int) -> float:
    """Largest error in units of the last place."""
    return max(
        float(abs(mpmath.mpf(float(x)) - y) / mpmath.ldexp(1, int(mpmath.floor(mpmath.log(abs(y), 2))) + 1 - digits))
        for x, y in zip(found, exact, strict=True)
    )


@pytest.mark.parametrize("real", DTYPE)
def test_errors_stay_below_what_the_header_says(real: str, kernels: dict[str, ctypes.CDLL]) -> None:
    angles, digits = hard_angles(real), 53 if real == "double" else 24
    sine, cosine = turned(kernels[real], angles)
    with mpmath.workdps(60):
        arguments = [mpmath.mpf(float(x)) for x in angles]
        errors = worst(sine, list(map(mpmath.sin, arguments)), digits), worst(cosine, list(map(mpmath.cos, arguments)), digits)
    assert max(errors) < trig.BUNDLED_ERROR[real]


@pytest.mark.parametrize("real", DTYPE)
def test_beyond_the_range_is_not_a_number(real: str, kernels: dict[str, ctypes.CDLL]) -> None:
    beyond = np.array([1.1e6, -1e30, np.inf, -np.inf, np.nan], DTYPE[real])
    assert all(np.isnan(part).all() for part in turned(kernels[real], beyond))
    edge = np.array([trig.RANGE, -trig.RANGE], DTYPE[real])
    assert all(np.isfinite(part).all() for part in turned(kernels[real], edge))


def test_the_words_of_two_over_pi_and_its_parts_are_derived() -> None:
    with mpmath.workprec(300):
        numbers = trig.bundled("double")
        halves = [int(word[11:-1], 16) for word in numbers["two_over_pi_halves"]]  # type: ignore[attr-defined]
        assert (halves[0] << 64) + halves[1] == int(mpmath.floor(mpmath.ldexp(2 / mpmath.pi, 128)))
        assert int(str(numbers["quarter_pi"])[11:-1], 16) == int(mpmath.nint(mpmath.ldexp(mpmath.pi / 4, 64)))


def test_the_words_of_half_pi_add_up_and_the_coefficients_are_derived() -> None:
    """pi/2 by two words and a number to 2^-79; S and C leave 2^-26.5 and 2^-31 up to where the rounding of x 2/pi may leave an angle."""
    with mpmath.workprec(300):
        units = mpmath.ldexp(mpmath.pi / 2, 56)
        (high, low), rest = trig.HALF_PI_WORDS, trig.HALF_PI_REST
        assert (high << 32) + low == int(mpmath.nint(units)) and abs(low) < 2**31
        assert abs(units - (high << 32) - low - rest) < mpmath.ldexp(1, -26)
        assert float(np.float32(rest)) == rest
        most = trig.FLOAT_END * 2 / mpmath.pi
        off = np.spacing(np.float32(most)) / 2 + most * abs(np.float32(2 / np.pi) * mpmath.pi / 2 - 1)
        assert off * mpmath.pi / 2 < mpmath.mpf(3) / 32
        for k in range(1, 200):
            r = (mpmath.pi / 4 + mpmath.mpf(3) / 32) * k / 199
            sine = r - r**3 * mpmath.polyval(trig.WIDE_SINE[::-1], r * r)
            cosine = 1 - r**2 / 2 + r**4 * mpmath.polyval(trig.WIDE_COSINE[::-1], r * r)
            assert abs(sine / mpmath.sin(r) - 1) < 2**-26.5 and abs(cosine - mpmath.cos(r)) < 2**-31


def test_quarter_turns_are_counted_by_bits() -> None:
    """The number that counts them is a multiple of four, lies far enough from both ends of its binade, and products stay exact."""
    counter = int.from_bytes(np.array(trig.COUNTER_START + trig.COUNTER_ZERO, ">u4").tobytes(), "big")
    number = int(np.array(counter, np.uint32).view(np.float32))
    most = int(trig.FLOAT_END * 2 / np.pi) + 1
    assert number % 4 == 0 and counter % 4 == 0 and 2**23 + most < number < 2**24 - most
    kernel = trig.KERNELS["float"]
    for part in kernel.half_pi[:2]:
        assert abs(part.as_integer_ratio()[0]) * trig.COUNTER_ZERO < 2**24
    assert kernel.bound < (trig.COUNTER_SPAN - trig.COUNTER_ZERO - 0.5) * np.pi / 2


def test_angles_at_the_ends_of_both_reductions(kernels: dict[str, ctypes.CDLL]) -> None:
    """Where the near one gives way to the far one, and where the range ends: 2^20, from which on there is no number."""
    near = np.array([(k + 0.5) * np.pi / 2 for k in range(2040, 2056)], np.float32)
    angles = np.concatenate([near, -near, np.nextafter(near, np.float32(0)), np.array([trig.FLOAT_END], np.float32) - np.float32(0.0625)])
    sine, cosine = turned(kernels["float"], angles)
    with mpmath.workdps(40):
        arguments = [mpmath.mpf(float(x)) for x in angles]
        assert worst(sine, list(map(mpmath.sin, arguments)), 24) < trig.BUNDLED_ERROR["float"]
        assert worst(cosine, list(map(mpmath.cos, arguments)), 24) < trig.BUNDLED_ERROR["float"]
    beyond = np.array([trig.FLOAT_END, -trig.FLOAT_END, 5.4e6, 5.5e6, 3e38, -(2.0**22) * np.pi / 2], np.float32)
    assert all(np.isnan(part).all() for part in turned(kernels["float"], beyond))


@pytest.mark.parametrize(("more", "apart"), [({}, False), ({"code": "loops"}, False), ({"want": ["phi"]}, True), ({"real": "double"}, True)])
def test_sines_and_cosines_stand_side_by_side_where_the_kernel_sets_pairs(more: dict[str, object], apart: bool) -> None:
    """Of single precision; Bessel functions want two arrays, and so does the kernel in double precision."""
    text = folder_texts(scene(**{"want": ["forward_dynamics"], **more}), False, False)["own.c"]
    assert ("static void own_sincos(" in text) == apart
    assert ("    own_sincos_pairs(2, q, sine_cosine);" in text and re.search(r"sine_cosine\[\w\]\[0\]", text) is not None) == (not apart)


@pytest.mark.parametrize(("name", "imported"), [("bundled", set()), ("libm", {"sinf", "cosf", "sincosf"}), ("hook", {"my_sincos"})])
def test_an_object_asks_for_what_the_scene_says(name: str, imported: set[str], tmp_path: Path) -> None:
    made = scene(name, trig_hook="my_sincos" if name == "hook" else None, actuated="all", want=["forward_dynamics", "phi"])
    if name == "hook":
        made = replace(made, want=("forward_dynamics",))
    else:
        imported = imported | {"sqrtf"}
    assert symbols(compiled(write_c(made, tmp_path), *STRICT, "-O1")).imported <= imported


def test_the_self_test_passes_with_bundled_trigonometry_and_a_hook(tmp_path: Path) -> None:
    for made in (scene("bundled"), scene("hook", trig_hook="my_sincos", real="double")):
        folder = write_all(made, tmp_path / str(made.trig))
        if made.trig == "hook":
            with (folder / "selftest.c").open("a") as file:
                file.write("\n#include <math.h>\nvoid my_sincos(double x, double *s, double *c)\n{\n    *s = sin(x);\n    *c = cos(x);\n}\n")
        subprocess.run([selftest_program(folder, "-std=c99")], check=True, capture_output=True)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"trig": "hook"}, "target.trig: asks for a function that is not declared (got 'hook'); name it, as trig_hook ="),
        ({"trig": "table"}, "target.trig: is not one of the choices (got 'table')"),
        ({"trig": None, "trig_hook": "f"}, "target.trig_hook: is declared and not asked for"),
        ({"trig": "hook", "trig_hook": "a b"}, "target.trig_hook: is not a C identifier (got 'a b')"),
        ({"trig": "hook", "trig_hook": "own_sincos"}, "target.trig_hook: is a name of the generated code's"),
        ({"stack_max": 0}, "target.stack_max: is below 1"),
        ({"flash_max": 2.5}, "target.flash_max: is not a whole number"),
    ],
)
def test_bad_words_are_refused(keys: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(**keys)  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_what_is_left_to_the_user_is_not_built_here() -> None:
    with pytest.raises(UnsupportedError) as caught:
        build(scene("hook", trig_hook="my_sincos"))
    assert str(caught.value) == (
        "target.trig: leaves sines and cosines to my_sincos, which nothing can be linked with here (got 'hook'); "
        "generate the folder and link it with yours, or build the scene with another trig"
    )


def test_vectors_have_one_kernel() -> None:
    with pytest.raises(UnsupportedError, match="has no form on vectors, which forward_dynamics_batch computes on"):
        scene(want=["forward_dynamics_batch"])


def test_a_scene_without_the_keys_says_nothing_of_them() -> None:
    assert not {"trig", "trig_hook", "stack_max", "flash_max"} & set(scene(None).to_dict()["target"])
    assert scene(None).digest != scene("bundled").digest
