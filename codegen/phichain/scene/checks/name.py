"""Which names a scene may carry.

A scene's name becomes the prefix of every external symbol (`NAME_forward_dynamics`), the stem of files (`NAME.h`,
`NAME.c`), a CMake target (`NAME`) and its library (`libNAME.a`), and stays free for a C++ namespace. So it must be
an identifier of C and C++ alike, and a file, target, library or namespace of that name must not hide another one.
As a prefix it never meets the C library: `sin_forward_dynamics` is nobody else's symbol.
"""

from __future__ import annotations

import re
from typing import Final

from phichain.errors import SceneError

# With the longest suffix, emitted names stay within the 63 characters that C99 (5.2.4.1) promises to tell apart.
LONGEST_NAME: Final = 40
LONGEST_FUNCTION: Final = 63


def _words(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


# C99, C11, C23 and C++20 with its alternative tokens; asm, which C compilers reserve too.
_KEYWORDS: Final = _words(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void
    volatile while alignas alignof bool constexpr false nullptr static_assert thread_local true typeof
    typeof_unqual
    and and_eq asm bitand bitor catch char8_t char16_t char32_t class co_await co_return co_yield compl
    concept const_cast consteval constinit decltype delete dynamic_cast explicit export friend mutable
    namespace new noexcept not not_eq operator or or_eq private protected public reinterpret_cast
    requires static_cast template this throw try typeid typename using virtual wchar_t xor xor_eq
    """
)

# NAME.h beside the user's sources would be found in place of these (without case, as some file systems compare).
_HEADERS: Final = _words(
    """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign
    stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath
    threads time uchar wchar wctype
    alloca byteswap dirent dlfcn endian features fcntl malloc memory poll pthread sched semaphore
    strings unistd values windows
    """
)

# The mathematics of the C library, of double and of complex numbers.
_MATHEMATICS: Final = _words(
    """
    abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs
    fdim floor fma fmax fmin fmod fpclassify frexp hypot ilogb isfinite isgreater isgreaterequal isinf
    isless islessequal islessgreater isnan isnormal isunordered ldexp lgamma llrint llround log log10
    log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo rint round
    scalbln scalbn signbit sin sinh sqrt tan tanh tgamma trunc j0 j1 jn y0 y1 yn
    cabs cacos cacosh carg casin casinh catan catanh ccos ccosh cexp cimag clog conj cpow cproj creal
    csin csinh csqrt ctan ctanh
    """
)

# A C++ namespace NAME would meet these in the headers of the C library; those of mathematics for every precision.
_STANDARD_NAMES: Final = frozenset(f"{name}{precision}" for name in _MATHEMATICS for precision in ("", "f", "l")) | _words(
    """
    main std linux unix malloc signal time assert setjmp alloca
    abort atexit atof atoi atol atoll bsearch calloc div exit free getenv labs ldiv llabs lldiv mblen
    mbstowcs mbtowc qsort rand realloc srand strtod strtof strtol strtold strtoll strtoul strtoull
    system wcstombs wctomb imaxabs imaxdiv strtoimax strtoumax
    memchr memcmp memcpy memmove memset strcat strchr strcmp strcoll strcpy strcspn strerror strftime
    strlen strncat strncmp strncpy strpbrk strrchr strspn strstr strtok strxfrm
    clearerr fclose feof ferror fflush fgetc fgetpos fgets fopen fprintf fputc fputs fread freopen
    fscanf fseek fsetpos ftell fwrite getc getchar gets perror printf putc putchar puts remove rename
    rewind scanf setbuf setvbuf snprintf sprintf sscanf stderr stdin stdout tmpfile tmpnam ungetc
    vfprintf vfscanf vprintf vscanf vsnprintf vsprintf vsscanf
    isalnum isalpha isblank iscntrl isdigit isgraph islower isprint ispunct isspace isupper isxdigit
    tolower toupper
    asctime clock ctime difftime gmtime localtime mktime localeconv longjmp raise setlocale
    feclearexcept fegetenv fegetexceptflag fegetround feholdexcept feraiseexcept fesetenv
    fesetexceptflag fesetround fetestexcept feupdateenv offsetof va_arg va_copy va_end va_start
    clock_t div_t fenv_t fpos_t int8_t int16_t int32_t int64_t intmax_t intptr_t jmp_buf ptrdiff_t
    sig_atomic_t size_t time_t uint8_t uint16_t uint32_t uint64_t uintmax_t uintptr_t va_list wint_t
    BUFSIZ CHAR_BIT CLOCKS_PER_SEC DBL_MAX DBL_MIN EOF EXIT_FAILURE EXIT_SUCCESS FILE FLT_MAX FLT_MIN
    HUGE_VAL I INFINITY INT_MAX INT_MIN M_PI NAN NDEBUG NULL RAND_MAX SIZE_MAX
    """
)

# libNAME.a would be linked in place of these.
_LIBRARIES: Final = _words("c m dl rt util gcc gcc_s stdc asan ubsan casadi")

_CMAKE_TARGETS: Final = _words(
    """
    all clean depend edit_cache help install list_install_components package package_source
    rebuild_cache test ALL_BUILD INSTALL PACKAGE RUN_TESTS ZERO_CHECK
    """
)

_DEVICE_FILES: Final = frozenset(
    ["con", "prn", "aux", "nul", *(f"{device}{i}" for device in ("com", "lpt") for i in range(10))]
)


def scene_name(value: object) -> str:
    """Return a scene's name after checking that files and symbols can carry it.

    Raises:
        SceneError: The name is no identifier, is reserved, or would hide something (the message says what).
    """
    if not isinstance(value, str):
        raise SceneError("name", value, "is not a string", 'write name = "my_chain"')
    name = str(value)
    reason = _not_an_identifier(name, LONGEST_NAME) or _hides(name)
    if reason is not None:
        problem, remedy = reason
        raise SceneError("name", value, problem, remedy)
    return name


def function_name(key: str, value: object) -> str:
    """Return the name of a function of the user's after checking that C and C++ let one be called so.

    Args:
        key: What it is the value of.
        value: The name.

    Raises:
        SceneError: It is no identifier, is reserved, or is a name of the C library.
    """
    if not isinstance(value, str):
        raise SceneError(key, value, "is not a string", 'write a name such as "my_sincos"')
    name = str(value)
    reason = _not_an_identifier(name, LONGEST_FUNCTION)
    if reason is None and name in _STANDARD_NAMES:
        reason = "is a name of the C library", f'choose another name, e.g. "my_{name}"'
    if reason is not None:
        raise SceneError(key, value, *reason)
    return name


def _not_an_identifier(name: str, longest: int) -> tuple[str, str] | None:
    """Return what keeps a name from being an identifier of C and C++, and the remedy."""
    rule = "use ASCII letters, digits and underscores, a letter first"
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        return "is not a C identifier", rule
    if len(name) > longest:
        return f"has {len(name)} characters", f"use at most {longest}"
    if name.startswith("_"):
        return "begins with an underscore, which C reserves", rule
    if "__" in name or name.endswith("_"):
        return "puts two underscores in a row, which C++ reserves", "use single ones, and none at the end"
    if name in _KEYWORDS:
        return "is a keyword of C or C++", _longer(name)
    return None


def _hides(name: str) -> tuple[str, str] | None:
    """Return what a file, target or library of this name would hide, and the remedy."""
    folded = name.lower()
    if folded in _HEADERS:
        return f"would hide the system header <{folded}.h> behind {name}.h", _longer(name)
    if name in _STANDARD_NAMES:
        problem = (
            f"is a name of the C library ({name}_step would not clash with it, "
            f"a file, target or C++ namespace {name} would)"
        )
        return problem, _longer(name)
    if name in _CMAKE_TARGETS:
        return "is a target that CMake keeps for itself", _longer(name)
    if folded in _LIBRARIES:
        return f"would hide the system library lib{folded}", _longer(name)
    if folded in _DEVICE_FILES:
        return "is a device on Windows, where no file can carry it", _longer(name)
    if folded in ("selftest", "selftest_hook"):
        return f"would overwrite the generated {folded}.c", _longer(name)
    if folded == "stem":
        return "is the word for names in the flows that are written for every chain", _longer(name)
    if folded.endswith("_casadi"):
        remedy = f'use "{name[: -len("_casadi")]}"'
        return "ends in _casadi, which marks the symbols of the CasADi file", remedy
    return None


def _longer(name: str) -> str:
    """Return the remedy that proposes a longer name."""
    return f'use a longer name, e.g. "{name}_chain"'
