"""The sine-cosine kernel: its derivation, its error against independent references, its text and code."""

import ctypes
import math
import os
import platform
import re
import runpy
import shutil
import subprocess
import textwrap
from fractions import Fraction
from pathlib import Path

import jinja2
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from phichain.emit.c import sincos as trig

REALS = ("double", "float")
DTYPE = {"double": np.float64, "float": np.float32}
PRECISION = {"double": 53, "float": 24}
TEMPLATES = Path(__file__).resolve().parents[2] / "templates"
COMPILER = os.environ.get("CC") or shutil.which("gcc") or "cc"
STRICT = ["-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion"]
STRICT += ["-Wdouble-promotion", "-Wfloat-conversion", "-Wshadow", "-Wstrict-prototypes", "-Wundef"]
STRICT += ["-Wmissing-prototypes", "-Wcast-qual", "-Wvla", "-Werror"]
REPRODUCIBLE = ["-O3", "-ffp-contract=off"]
FAST = ["-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]


def source(real, count="n"):
    """Return a translation unit that exports the rendered kernel as `all(n, angle, sine, cosine)`."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES), undefined=jinja2.StrictUndefined, trim_blocks=True
    )
    restrict = environment.get_template("restrict.c.j2").render(name="k")
    text = environment.get_template("trig/sincos.c.j2").render(name="k", real=real, writes=(), **trig.coefficients(real))
    includes = "".join(f"#include <{header}>\n" for header in trig.HEADERS)
    signature = "void all(int n, const k_real *angle, k_real *sine, k_real *cosine)"
    call = f"{signature};\n{signature} {{ (void)n; k_sincos({count}, angle, sine, cosine); }}\n"
    return f"{includes}{restrict}\ntypedef {real} k_real;\n{text}\n{call}"


def compiled(folder, text, flags, output):
    """Compile a translation unit and return the path of what comes out."""
    path = folder / "kernel.c"
    path.write_text(text)
    command = [COMPILER, "-std=c99", *flags, str(path), "-o", str(folder / output)]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    return folder / output


def kernel(folder, real, flags):
    """Return the compiled kernel as a function of one array giving two."""
    # Linked in a step of its own: given -ffast-math, it would switch off denormals in the whole process.
    compiled_object = compiled(folder, source(real), ["-fPIC", *flags, "-c"], "kernel.o")
    shared = folder / "kernel.so"
    link = [COMPILER, "-shared", str(compiled_object), "-o", str(shared), "-lm"]
    subprocess.run(link, check=True, timeout=60)
    library = ctypes.CDLL(str(shared))
    pointer = np.ctypeslib.ndpointer(DTYPE[real], flags="C")
    library.all.argtypes = [ctypes.c_int, pointer, pointer, pointer]
    library.all.restype = None

    def evaluate(angles):
        angles = np.ascontiguousarray(angles, DTYPE[real])
        sine, cosine = np.empty_like(angles), np.empty_like(angles)
        library.all(len(angles), angles, sine, cosine)
        return sine, cosine

    return evaluate


@pytest.fixture(scope="module", params=REALS)
def real(request):
    return request.param


@pytest.fixture(scope="module")
def reproducible(real, tmp_path_factory):
    return kernel(tmp_path_factory.mktemp("reproducible"), real, REPRODUCIBLE)


@pytest.fixture(scope="module")
def fast(real, tmp_path_factory):
    return kernel(tmp_path_factory.mktemp("fast"), real, FAST)


def bits(array):
    return array.view(np.uint64 if array.dtype == np.float64 else np.uint32)


def exact(value):
    return Fraction(*float(value).as_integer_ratio())


def half_pi():
    """Return pi/2 as a fraction that is good to 400 bits."""
    with mpmath.workprec(420):
        return Fraction(int(mpmath.floor(mpmath.ldexp(mpmath.pi / 2, 400))), 2**400)


def critical_angles(real):
    """Return the floating-point numbers nearest to multiples of pi/4 within the bound, and neighbours."""
    wide = np.longdouble(np.pi) / 4 + np.longdouble(6.123233995736766e-17) / 2
    quarters = np.arange(1, int(trig.KERNELS[real].bound / (math.pi / 4)), 1 if real == "float" else 7)
    nearest = (quarters * wide).astype(DTYPE[real])
    steps = [nearest, np.nextafter(nearest, DTYPE[real](0)), np.nextafter(nearest, DTYPE[real](1e9))]
    return np.concatenate(steps)


def angles_to_judge(real):
    """Return random angles over the whole range on two scales, and the critical ones."""
    draw = np.random.default_rng(7)
    bound = trig.KERNELS[real].bound
    spread = [draw.uniform(-top, top, 150_000) for top in (0.8, 12.0, bound)]
    tiny = np.ldexp(draw.uniform(-1, 1, 50_000), draw.integers(-60, 10, 50_000))
    edge = np.array([bound, -bound])
    return np.concatenate([*spread, tiny, critical_angles(real), edge]).astype(DTYPE[real])


def error_ulp(values, reference):
    """Return |values - reference| in units of the last place of the reference."""
    unit = np.spacing(np.abs(reference.astype(values.dtype)))
    return np.abs(values - reference) / unit


def test_the_documented_derivation_gives_the_coefficients(tmp_path):
    script = tmp_path / "derivation.py"
    script.write_text(textwrap.dedent(trig.__doc__.split("mpmath::\n\n")[1].split("`slack`")[0]))
    coefficients = runpy.run_path(str(script))["derived"]
    for real in REALS:
        numbers = trig.KERNELS[real]
        for derived, tabled in zip(coefficients[real], (numbers.sine, numbers.cosine), strict=True):
            assert [float(value) for value in derived] == list(tabled)


def test_the_polynomials_meet_their_stated_error(real):
    stated = {"double": (-57.8, -63.3), "float": (-27.8, -32.4)}[real]
    numbers = trig.KERNELS[real]
    worst = [0.0, 0.0]
    with mpmath.workprec(200):
        for i in range(1, 400):
            r = mpmath.pi / 4 * i / 399
            sine = r - r**3 * mpmath.polyval(numbers.sine[::-1], r**2)
            cosine = 1 - r**2 / 2 + r**4 * mpmath.polyval(numbers.cosine[::-1], r**2)
            worst[0] = max(worst[0], abs(sine / mpmath.sin(r) - 1))
            worst[1] = max(worst[1], abs(cosine / mpmath.cos(r) - 1))
    assert math.log2(worst[0]) < stated[0]
    assert math.log2(worst[1]) < stated[1]


def test_the_reduction_is_exact_where_it_must_be_and_accurate_where_it_is_hardest(real):
    """At the number nearest to n pi/2 all leading digits cancel: the kernel's steps in exact arithmetic."""
    precision = PRECISION[real]
    numbers = trig.KERNELS[real]
    largest, stated = {"double": (18, -57.9), "float": (11, -25.4)}[real]
    unit = 2**400
    first, second, third = (int(exact(part) * unit) for part in numbers.half_pi)
    quarter_turn = int(half_pi() * unit)
    for part in (first, second):
        assert len(f"{abs(part):b}".rstrip("0")) <= precision - largest
    assert numbers.bound < 2**largest * math.pi / 2
    worst = 0.0
    for n in range(1, 2**largest + 1):
        true_angle = n * quarter_turn
        drop = true_angle.bit_length() - precision
        angle = (true_angle + (1 << (drop - 1))) >> drop << drop
        excess = n * third
        rounding = max(abs(excess).bit_length() - precision, 0)
        excess = excess >> rounding << rounding
        reduced = angle - n * first - n * second - excess
        worst = max(worst, abs(reduced / (angle - true_angle) - 1))
    assert worst < 2.0**stated


@pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="needs a wider type than double as reference")
@pytest.mark.parametrize("build", ["reproducible", "fast"])
def test_the_error_stays_below_the_stated_bound(real, build, request):
    evaluate = request.getfixturevalue(build)
    angles = angles_to_judge(real)
    wide = angles.astype(np.longdouble)
    for values, reference in zip(evaluate(angles), (np.sin(wide), np.cos(wide)), strict=True):
        assert error_ulp(values, reference).max() < trig.KERNELS[real].error_ulp


def test_the_error_against_40_digits(real, reproducible):
    draw = np.random.default_rng(11)
    critical = critical_angles(real)
    angles = np.concatenate([draw.uniform(-50, 50, 400), draw.choice(critical, 400), critical[-3:]])
    angles = angles.astype(DTYPE[real])
    sine, cosine = reproducible(angles)
    with mpmath.workdps(40):
        for angle, s, c in zip(angles.tolist(), sine, cosine, strict=True):
            for value, true in ((s, mpmath.sin(angle)), (c, mpmath.cos(angle))):
                unit = float(np.spacing(np.abs(DTYPE[real](float(true)))))
                assert abs(float(value) - true) < trig.KERNELS[real].error_ulp * unit


def test_zero_keeps_its_sign_and_tiny_angles_their_value(real, reproducible):
    limits = np.finfo(DTYPE[real])
    angles = np.array([0.0, -0.0, limits.tiny, -limits.tiny, limits.smallest_subnormal, -limits.tiny / 8])
    angles = angles.astype(DTYPE[real])
    sine, cosine = reproducible(angles)
    assert np.array_equal(bits(sine), bits(angles))
    assert np.array_equal(cosine, np.ones(len(angles)))


def test_larger_angles_are_the_library_s_and_leave_their_neighbours_alone(real, reproducible):
    bound = DTYPE[real](trig.KERNELS[real].bound)
    wild = [np.nextafter(bound, DTYPE[real](np.inf)), -1e7, 3e30, np.inf, -np.inf, np.nan]
    tame = np.linspace(-3, 3, len(wild))
    mixed = np.empty(2 * len(wild), DTYPE[real])
    mixed[0::2], mixed[1::2] = wild, tame
    for together, alone in zip(reproducible(mixed), reproducible(tame), strict=True):
        assert np.array_equal(bits(together[1::2]), bits(alone))
    sine, cosine = reproducible(mixed)
    assert np.isnan(sine[6::2]).all() and np.isnan(cosine[6::2]).all()
    finite = mixed[0:6:2].astype(np.longdouble)
    assert error_ulp(sine[0:6:2], np.sin(finite)).max() < 1
    assert error_ulp(cosine[0:6:2], np.cos(finite)).max() < 1


@given(angle=st.floats(-4e5, 4e5))
@settings(max_examples=200, deadline=None)
def test_parity_is_exact_and_the_circle_closes(real, reproducible, angle):
    sine, cosine = reproducible(np.array([angle, -angle]))
    assert sine[0] == -sine[1] and cosine[0] == cosine[1]
    assert abs(float(sine[0]) ** 2 + float(cosine[0]) ** 2 - 1) < 4 * np.finfo(DTYPE[real]).eps


def test_bits_depend_neither_on_the_count_nor_on_the_optimiser(real, reproducible, tmp_path):
    angles = angles_to_judge(real)[::997]
    plain = kernel(tmp_path, real, ["-O0", "-ffp-contract=off"])
    together = reproducible(angles)
    for one, other in zip(together, plain(angles), strict=True):
        assert np.array_equal(bits(one), bits(other))
    for i in range(0, len(angles), 29):
        sine, cosine = reproducible(angles[i : i + 1])
        assert (sine[0], cosine[0]) == (together[0][i], together[1][i])


def test_flags_that_reorder_sums_hand_over_to_the_library(real, tmp_path):
    evaluate = kernel(tmp_path, real, ["-O2", "-ffast-math"])
    angles = (np.arange(1, 2000) * (math.pi / 2)).astype(DTYPE[real])
    wide = angles.astype(np.longdouble)
    for values, reference in zip(evaluate(angles), (np.sin(wide), np.cos(wide)), strict=True):
        assert error_ulp(values, reference).max() < 4.5


@pytest.mark.parametrize("level", ["-O0", "-O3", "-Os"])
def test_strict_flags_are_clean(real, level, tmp_path):
    compiled(tmp_path, source(real, count="4"), [*STRICT, level, "-c"], "kernel.o")


def test_float_text_computes_in_float_alone():
    text = re.sub(r"/\*.*?\*/", "", source("float"), flags=re.DOTALL)
    assert "double" not in text
    literals = re.findall(r"(?<![\w.])\d+\.\d+(?:e[+-]?\d+)?(\w?)", text)
    assert len(literals) > 12
    assert set(literals) == {"F"}
    assert not re.search(r"\b(sin|cos)\(", text)


@pytest.mark.skipif(
    platform.machine() != "x86_64" or "gcc" not in COMPILER, reason="reads the assembly of gcc on x86-64"
)
@pytest.mark.parametrize("target", [[], ["-mavx2"], ["-mavx2", "-mfma"]])
def test_the_compiler_vectorises_over_the_angles(target, tmp_path):
    assembly = compiled(tmp_path, source("double", count="8"), ["-O3", *target, "-S"], "kernel.s").read_text()
    packed = len(re.findall(r"\b(?:v?mulpd|v?addpd|v?subpd|vfn?m(?:add|sub)\d+pd)\b", assembly))
    single = len(re.findall(r"\b(?:v?mulsd|v?addsd|v?subsd|vfn?m(?:add|sub)\d+sd)\b", assembly))
    assert packed > 20
    assert single == 0


def test_literals_are_exact(real):
    numbers = trig.KERNELS[real]
    for value in (*numbers.half_pi, numbers.two_over_pi, numbers.rounder, *numbers.sine, *numbers.cosine):
        text = trig.literal(value, real)
        assert float(DTYPE[real](text.removesuffix("F"))) == value
        assert DTYPE[real](value) == value
