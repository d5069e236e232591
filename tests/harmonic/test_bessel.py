"""J0..J4: the expansion's mathematics, error bounds proven and measured, the C text and the CasADi text."""

import ctypes
import math
import os
import re
import runpy
import shutil
import subprocess
from pathlib import Path

import casadi
import jinja2
import mpmath
import numpy as np
import pytest
import scipy.special

from phichain.emit import bessel

REALS = ("double", "float")
DTYPE = {"double": np.float64, "float": np.float32}
HALF_ULP_OF_ONE = {"double": 2.0**-53, "float": 2.0**-24}
TEMPLATES = Path(__file__).resolve().parents[2] / "templates"
COMPILER = os.environ.get("CC") or shutil.which("gcc") or "cc"
STRICT = ["-std=c99", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion"]
STRICT += ["-Wdouble-promotion", "-Wfloat-conversion", "-Wshadow", "-Wstrict-prototypes", "-Wundef"]
STRICT += ["-Wmissing-prototypes", "-Wcast-qual", "-Wvla", "-Werror"]
ENVIRONMENT = jinja2.Environment(
    loader=jinja2.FileSystemLoader(TEMPLATES), undefined=jinja2.StrictUndefined, trim_blocks=True
)


def source(real):
    """Return a translation unit that exports the rendered function for an array of arguments."""
    text = ENVIRONMENT.get_template("bessel.c.j2").render(name="k", real=real, own=False, **bessel.coefficients(real))
    includes = "".join(f"#include <{header}>\n" for header in bessel.HEADERS)
    signature = "void all(int n, const k_real *x, k_real *j)"
    loop = "for (int i = 0; i < n; ++i) { k_bessel(x[i], j + 5 * i); }"
    return f"{includes}typedef {real} k_real;\n{text}\n{signature};\n{signature} {{ {loop} }}\n"


def compiled(folder, real, flags, output):
    """Compile the rendered function and return the path of what comes out."""
    (folder / "bessel.c").write_text(source(real))
    command = [COMPILER, "-std=c99", *flags, str(folder / "bessel.c"), "-o", str(folder / output), "-lm"]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    return folder / output


@pytest.fixture(scope="module", params=REALS)
def real(request):
    return request.param


@pytest.fixture(scope="module", params=["-ffp-contract=off", "-ffp-contract=fast"])
def evaluate(real, request, tmp_path_factory):
    flags = ["-O2", "-march=native", "-shared", "-fPIC", request.param]
    library = ctypes.CDLL(str(compiled(tmp_path_factory.mktemp("bessel"), real, flags, "bessel.so")))
    pointer = np.ctypeslib.ndpointer(DTYPE[real], flags="C")
    library.all.argtypes = [ctypes.c_int, pointer, pointer]
    library.all.restype = None

    def function(arguments):
        arguments = np.ascontiguousarray(arguments, DTYPE[real])
        values = np.empty((len(arguments), bessel.ORDERS), DTYPE[real])
        library.all(len(arguments), arguments, values)
        return values

    return function


@pytest.fixture(scope="module")
def casadi_bessel(tmp_path_factory):
    script = tmp_path_factory.mktemp("casadi") / "bessel.py"
    text = ENVIRONMENT.get_template("casadi/bessel.py.j2").render(**bessel.casadi_coefficients())
    script.write_text(f"import casadi\n\n\n{text}")
    return runpy.run_path(str(script))["bessel"]


def arguments_to_judge(real):
    """Return random arguments of every region, the regions' edges, and zeros of J0..J4 with neighbours."""
    draw = np.random.default_rng(5)
    edge = bessel.REGIONS[real].crossover
    random = [draw.uniform(-edge, edge, 250), draw.uniform(edge, 3 * edge, 60), 10 ** draw.uniform(1, 8, 40)]
    zeros = np.concatenate([scipy.special.jn_zeros(order, 12) for order in range(bessel.ORDERS)])
    steps = np.arange(1.0, edge + 1)
    arguments = np.concatenate([*random, 10 ** draw.uniform(-6, 0, 40), zeros, steps]).astype(DTYPE[real])
    below = np.nextafter(steps.astype(DTYPE[real]), DTYPE[real](0))
    return np.concatenate([arguments, below, -arguments[-5:]])


def exact(x, derivative=0):
    return [mpmath.besselj(order, mpmath.mpf(float(x)), derivative) for order in range(bessel.ORDERS)]


def recurrence(x, order, one):
    """Run the recurrence from `order` in the arithmetic of `one`; return all r_k and their scale."""
    y = x * x / 4
    r = [0 * one] * order + [one, 0 * one]
    for k in range(order, 0, -1):
        r[k - 1] = k * r[k] - y * r[k + 1]
    return r, r[0] + 2 * sum(y ** (k // 2) * r[k] for k in range(2, order + 1, 2))


def rounding_bound(x, real):
    """Return the first-order bound of the rounding error of J0..J4, in half units in the last place of 1.

    An error e at r_m changes r_n by e g_n, g being the recurrence started from g_m = 1, and the scale
    likewise. Each r_(k-1) takes three roundings, and one from y; each term of the scale takes three.
    """
    order = bessel.REGIONS[real].order(x)
    y = x * x / 4
    r, scale = recurrence(x, order, 1.0)
    values = [(x / 2) ** n * r[n] / scale for n in range(bessel.ORDERS)]
    bound = [0.0] * bessel.ORDERS
    for m in range(order):
        error = (m + 1) * abs(r[m + 1]) + 2 * y * abs(r[m + 2]) + abs(r[m])
        g, g_scale = recurrence(x, m, 1.0)
        for n in range(bessel.ORDERS):
            direct = (x / 2) ** n * g[n] if n <= m else 0.0
            bound[n] += error * abs((direct - values[n] * g_scale) / scale)
    partial, scale_error = 0.0, abs(scale)
    for k in range(order, 0, -2):
        scale_error += 2 * y ** (k // 2) * 2 * y * abs(partial)
        partial = r[k] + y * partial
        scale_error += 2 * y ** (k // 2) * abs(partial)
    scale_error += 4 * y * abs(partial)
    return [b + abs(v) * (4 + scale_error / abs(scale)) for b, v in zip(bound, values, strict=True)]


def test_the_recurrence_starts_high_enough(real):
    """In exact arithmetic the error at the end of each piece, where it is largest, is below round-off."""
    regions = bessel.REGIONS[real]
    allowed = {"double": 2.0**-55, "float": 2.0**-27}[real]
    with mpmath.workdps(60):
        for end in range(1, regions.crossover + 1):
            r, scale = recurrence(mpmath.mpf(end), regions.order(end - 1), mpmath.mpf(1))
            for order, value in enumerate(exact(end)):
                power = mpmath.mpf(end) ** order / 2**order
                assert abs(power * r[order] / scale - value) < allowed * (abs(value) if end == 1 else 1)


def test_the_casadi_start_is_high_enough():
    with mpmath.workdps(60):
        edge = mpmath.mpf(bessel.REGIONS["double"].crossover)
        r, scale = recurrence(edge, bessel.CASADI_START, mpmath.mpf(1))
        for order, value in enumerate(exact(edge)):
            assert abs((edge / 2) ** order * r[order] / scale - value) < 2.0**-56


def test_the_a_priori_rounding_bound(real):
    edge = bessel.REGIONS[real].crossover
    worst = max(max(rounding_bound(x, real)) for x in np.linspace(0.05, edge - 0.01, 120))
    truncation = {"double": 2.0**-55, "float": 2.0**-27}[real]
    assert 8 < worst < {"double": 16.5, "float": 11.8}[real]
    assert worst * HALF_ULP_OF_ONE[real] + truncation < bessel.PROVEN[real]


def test_hankel_s_terms_left_out_are_below_round_off(real):
    regions = bessel.REGIONS[real]
    amplitude = math.sqrt(2 / (math.pi * regions.crossover))
    stated = {"double": 6e-18, "float": 4e-9}[real]
    for order in (0, 1):
        for index in (2 * regions.terms, 2 * regions.terms + 1):
            term = abs(bessel.hankel_coefficient(order, index)) / regions.crossover**index
            assert float(term) * amplitude < stated


def test_hankel_s_series_are_those_of_the_handbook():
    """Abramowitz & Stegun 9.2.9-10 with mu = 0 and mu = 4."""
    p0, q0 = bessel.hankel_series(0, 2)
    p1, q1 = bessel.hankel_series(1, 2)
    assert [float(value) for value in (*p0, *q0)] == [1.0, -9 / 128, -1 / 8, 75 / 1024]
    assert [float(value) for value in (*p1, *q1)] == [1.0, 15 / 128, 3 / 8, -105 / 1024]


def test_the_absolute_error_against_40_digits(real, evaluate):
    arguments = arguments_to_judge(real)
    worst = 0.0
    with mpmath.workdps(40):
        for x, values in zip(arguments, evaluate(arguments), strict=True):
            pairs = zip(values, exact(x), strict=True)
            worst = max(worst, *(abs(mpmath.mpf(float(value)) - true) for value, true in pairs))
    assert HALF_ULP_OF_ONE[real] < worst < bessel.ERROR[real]


def test_the_relative_error_for_small_arguments(real, evaluate):
    arguments = (10.0 ** np.linspace(-5, 0, 60)).astype(DTYPE[real])
    with mpmath.workdps(40):
        for x, values in zip(arguments, evaluate(arguments), strict=True):
            for value, true in zip(values, exact(x), strict=True):
                assert abs(mpmath.mpf(float(value)) / true - 1) < 6 * HALF_ULP_OF_ONE[real]


def test_zero_is_exact_and_parity_structural(real, evaluate):
    assert evaluate([0.0]).tolist() == [[1, 0, 0, 0, 0]]
    arguments = arguments_to_judge(real)
    signs = np.array([1, -1, 1, -1, 1])
    assert np.array_equal(evaluate(-arguments), signs * evaluate(arguments))


def test_huge_and_undefined_arguments(real, evaluate):
    largest = np.finfo(DTYPE[real]).max
    values = evaluate([largest, -largest, np.nan])
    assert np.abs(values[:2]).max() < 1e-15
    assert np.isnan(values[2]).all()


def test_agreement_with_scipy(evaluate, real):
    arguments = np.linspace(-60, 60, 4001).astype(DTYPE[real])
    expected = scipy.special.jv(np.arange(bessel.ORDERS), arguments.astype(float)[:, None])
    assert np.abs(evaluate(arguments) - expected).max() < bessel.ERROR[real] + 1e-15


@pytest.mark.parametrize("level", ["-O0", "-O3", "-Os"])
def test_strict_flags_are_clean(real, level, tmp_path):
    compiled(tmp_path, real, [*STRICT, level, "-c"], "bessel.o")


def test_float_text_computes_in_float_alone():
    text = re.sub(r"/\*.*?\*/", "", source("float"), flags=re.DOTALL)
    assert "double" not in text
    literals = re.findall(r"(?<![\w.])(?:\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(\w?)", text)
    assert len(literals) > 25
    assert set(literals) == {"F"}
    assert not re.search(r"\b(sin|cos|sqrt|fabs)\(", text)


def test_the_casadi_text_and_its_derivatives(casadi_bessel):
    x = casadi.SX.sym("x")
    values = casadi.vertcat(*casadi_bessel(x))
    slopes = casadi.jacobian(values, x)
    backwards = casadi.vertcat(*[casadi.gradient(values[order], x) for order in range(bessel.ORDERS)])
    function = casadi.Function("bessel", [x], [values, slopes, backwards])
    edge = bessel.REGIONS["double"].crossover
    special = [0.0, -0.0, edge, -edge, 1e5]
    with mpmath.workdps(40):
        for argument in [*special, *arguments_to_judge("double")[::5]]:
            results = [np.asarray(result).ravel() for result in function(argument)]
            for result, true in zip(results, (exact(argument), *2 * [exact(argument, 1)]), strict=True):
                assert max(abs(r - t) for r, t in zip(result, true, strict=True)) < 5e-16


def test_the_casadi_text_is_finite_to_second_order_everywhere(casadi_bessel):
    x = casadi.SX.sym("x")
    second = casadi.jacobian(casadi.jacobian(casadi.vertcat(*casadi_bessel(x)), x), x)
    function = casadi.Function("second", [x], [second])
    for argument in (0.0, 1e-200, 25.0, 30.0, -1e6):
        assert np.isfinite(np.asarray(function(argument))).all()
    assert np.allclose(np.asarray(function(0.0)).ravel(), [-0.5, 0, 0.25, 0, 0], atol=1e-15)
