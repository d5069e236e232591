"""Which names a scene may carry."""

import keyword
import re

import pytest

from phichain.errors import SceneError
from phichain.scene import Scene
from phichain.scene.checks.name import LONGEST_NAME, scene_name

RULE = "use ASCII letters, digits and underscores, a letter first"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (None, 'name: is not a string (got nothing); write name = "my_chain"'),
        (4, 'name: is not a string (got 4); write name = "my_chain"'),
        ("", f"name: is not a C identifier (got ''); {RULE}"),
        ("4links", f"name: is not a C identifier (got '4links'); {RULE}"),
        ("two links", f"name: is not a C identifier (got 'two links'); {RULE}"),
        ("../chain", f"name: is not a C identifier (got '../chain'); {RULE}"),
        ("a/b", f"name: is not a C identifier (got 'a/b'); {RULE}"),
        ("chain\n", f"name: is not a C identifier (got 'chain\\n'); {RULE}"),
        ("a\0b", f"name: is not a C identifier (got 'a\\x00b'); {RULE}"),
        ("a;system(0)", f"name: is not a C identifier (got 'a;system(0)'); {RULE}"),
        ("a){}/*", f"name: is not a C identifier (got 'a){{}}/*'); {RULE}"),
        ("{{ name }}", f"name: is not a C identifier (got '{{{{ name }}}}'); {RULE}"),
        ("péndulo", f"name: is not a C identifier (got 'péndulo'); {RULE}"),
        ("_chain", f"name: begins with an underscore, which C reserves (got '_chain'); {RULE}"),
        ("_Chain", f"name: begins with an underscore, which C reserves (got '_Chain'); {RULE}"),
        (
            "my__chain",
            (
                "name: puts two underscores in a row, which C++ reserves (got 'my__chain'); "
                "use single ones, and none at the end"
            ),
        ),
        (
            "chain_",
            (
                "name: puts two underscores in a row, which C++ reserves (got 'chain_'); "
                "use single ones, and none at the end"
            ),
        ),
        ("while", "name: is a keyword of C or C++ (got 'while'); use a longer name, e.g. \"while_chain\""),
        ("a" * 41, f"name: has 41 characters (got '{'a' * 41}'); use at most 40"),
        (
            "sin",
            (
                "name: is a name of the C library (sin_step would not clash with it, a file, target or C++ "
                "namespace sin would) (got 'sin'); use a longer name, e.g. \"sin_chain\""
            ),
        ),
        (
            "math",
            (
                "name: would hide the system header <math.h> behind math.h (got 'math'); "
                'use a longer name, e.g. "math_chain"'
            ),
        ),
        (
            "selftest",
            (
                "name: would overwrite the generated selftest.c (got 'selftest'); "
                'use a longer name, e.g. "selftest_chain"'
            ),
        ),
        (
            "planar4_casadi",
            (
                "name: ends in _casadi, which marks the symbols of the CasADi file (got 'planar4_casadi'); "
                'use "planar4"'
            ),
        ),
    ],
)
def test_names_are_refused_with_their_reason(name, message):
    with pytest.raises(SceneError) as caught:
        Scene(name, 2, mass=1, length=1)
    assert str(caught.value) == message


C99 = """auto break case char const continue default do double else enum extern float for goto if inline int long
register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
_Bool _Complex _Imaginary"""
C11_AND_C23 = """_Alignas _Alignof _Atomic _Generic _Noreturn _Static_assert _Thread_local alignas alignof bool
constexpr false nullptr static_assert thread_local true typeof typeof_unqual _BitInt"""
CPP20 = """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t
class compl concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype
default delete do double dynamic_cast else enum explicit export extern false float for friend goto if inline int
long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
reinterpret_cast requires return short signed sizeof static static_assert static_cast struct switch template this
thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor
xor_eq"""


@pytest.mark.parametrize("words", [C99, C11_AND_C23, CPP20], ids=["C99", "C11 and C23", "C++20"])
def test_no_keyword_of_c_or_cpp_is_a_name(words):
    for word in words.split():
        with pytest.raises(SceneError, match=r"keyword|begins with an underscore"):
            scene_name(word)


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (
            "main sin cos sqrt free printf abs round exp log NULL EOF NAN INFINITY size_t int32_t j0 y1",
            "C library",
        ),
        ("math Math stdio stdint string errno time malloc memory features", "system header"),
        ("test all clean install help", "CMake"),
        ("m c dl rt casadi", "system library"),
        ("con CON nul lpt1", "Windows"),
        ("SelfTest", "selftest"),
    ],
)
def test_names_that_would_hide_something(names, reason):
    for name in names.split():
        with pytest.raises(SceneError, match=re.escape(reason)):
            scene_name(name)


@pytest.mark.parametrize(
    "name",
    [
        "a",
        "Z9",
        "planar4",
        "paper_b",
        "sin_chain",
        "mathematical",
        "While",
        "tower_crane",
        "casadi_chain",
        "a" * LONGEST_NAME,
    ],
)
def test_plain_names_pass_unchanged(name):
    assert scene_name(name) == name


@pytest.mark.parametrize("name", ["def", "lambda", "None", "import", "yield"])
def test_keywords_of_python_alone_are_no_obstacle(name):
    assert keyword.iskeyword(name)
    assert scene_name(name) == name
