"""Reading a generated folder, its row loops, and CasADi's external."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.errors import OutputError
from phichain.native import Cache, build_casadi, build_folder
from phichain.native.glue.rows import rows_source
from phichain.native.signature import read_manifest
from tests.native import generated_folder


def edited(folder: Path, edit: Callable[[dict[str, Any]], object]) -> Path:
    """The folder with another manifest."""
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    edit(manifest)
    path.write_text(json.dumps(manifest))
    return folder


def test_manifest_prints_its_signatures(folder: Path) -> None:
    manifest = read_manifest(folder)
    assert [str(signature) for signature in manifest.functions.values()][3:] == [
        "step(h, q, v, u, p=) -> q_next, v_next",
        "linearization(s) -> M, G, B",
    ]
    assert [str(parameter) for parameter in manifest.parameters] == ["mass (2,)", "gravity"]


@pytest.mark.parametrize("content", [None, "", "[]", "{}", '{"name": "duo"}', "\x00"])
def test_folder_without_a_manifest_of_ours(folder: Path, content: str | None) -> None:
    (folder / "manifest.json").unlink()
    if content is not None:
        (folder / "manifest.json").write_text(content)
    with pytest.raises(OutputError) as caught:
        build_folder(folder)
    assert caught.value.field == "folder"
    assert caught.value.value == str(folder)


@pytest.mark.parametrize("name", ["duo.c", "duo.h"])
def test_changed_source_is_refused(folder: Path, cache: Cache, name: str) -> None:
    (folder / name).write_text("/* half a fi")
    with pytest.raises(OutputError, match=rf"its {name} was changed since it was generated"):
        build_folder(folder, cache=cache)
    (folder / name).unlink()
    with pytest.raises(OutputError, match=rf"its {name} cannot be read"):
        build_folder(folder, cache=cache)


@pytest.mark.parametrize(
    "edit",
    [
        lambda m: m.update(name="../duo"),
        lambda m: m.update(name='duo.h"\n#include "/etc/passwd'),
        lambda m: m.update(real="half"),
        lambda m: m["functions"]["step"].update(symbol="system(0); duo_step"),
        lambda m: m["functions"]["step"]["inputs"][0].update(name="h, int"),
        lambda m: m["functions"]["step"]["inputs"][1].update(shape=[-2]),
        lambda m: m["functions"]["step"]["inputs"][1].update(shape=["2"]),
        lambda m: m["functions"].update({"f()": m["functions"]["step"]}),
        lambda m: m.update(functions=None),
    ],
)
def test_manifest_cannot_bring_text_into_the_c(
    folder: Path, edit: Callable[[dict[str, Any]], object]
) -> None:
    with pytest.raises(OutputError, match=r"manifest\.json is not one of ours"):
        read_manifest(edited(folder, edit))


def test_row_loop_reads_as_written_by_hand(folder: Path) -> None:
    text = rows_source(read_manifest(folder))
    assert text.startswith('#include <stddef.h>\n\n#include "duo.h"\n')
    assert (
        "typedef char duo_rows_gravity_is_in_place"
        "[(offsetof(duo_params, gravity) == 2 * sizeof(duo_real)) ? 1 : -1];" in text
    )
    assert (
        "void duo_rows_energy(size_t rows, const duo_params *p, const duo_real *in_q, size_t in_q_stride, "
        "const duo_real *in_v, size_t in_v_stride, duo_real *out_kinetic, duo_real *out_potential)\n"
        "{\n"
        "    size_t row;\n"
        "    for (row = 0; row < rows; row++) {\n"
        "        duo_energy(p, in_q + row * in_q_stride, in_v + row * in_v_stride, "
        "out_kinetic + row * 1, out_potential + row * 1);\n"
        "    }\n"
        "}\n" in text
    )
    assert "duo_step(p, in_h[row * in_h_stride], in_q" in text
    assert "duo_linearization(in_s + row" in text


def test_casadi_module_is_offered_and_read_at_once(folder: Path, cache: Cache) -> None:
    pytest.importorskip("casadi")
    system = build_folder(folder, cache=cache)
    for path in folder.iterdir():
        path.unlink()
    q, v, u = np.array([0.1, 0.2]), np.array([0.3, -0.4]), np.array([0.5, 0.6])
    dynamics = system.casadi()
    assert dynamics.name_in() == ["p", "q", "v", "u"]
    result = dynamics([2.0, 4.0, 9.0], q, v, u).full().ravel()
    np.testing.assert_allclose(result, generated_folder.expected(q, v, u)["forward_dynamics"], rtol=1e-14)
    assert system.casadi() is dynamics


def test_folder_without_a_casadi_module_offers_none(folder: Path, cache: Cache) -> None:
    (folder / "duo_casadi.py").unlink()
    system = build_folder(edited(folder, lambda m: m["files"].pop("duo_casadi.py")), cache=cache)
    assert not system.has("casadi")


def test_casadi_external_with_exact_jacobian(tmp_path: Path, cache: Cache) -> None:
    casadi = pytest.importorskip("casadi")
    name = "duo_casadi_forward_dynamics"
    q, v = casadi.SX.sym("q", 2), casadi.SX.sym("v", 2)
    function = casadi.Function(name, [q, v], [casadi.sin(q) * v], ["q", "v"], ["a"])
    generator = casadi.CodeGenerator("duo_casadi.c", {"with_header": False})
    generator.add(function)
    generator.add(function.jacobian())
    folder = generated_folder.write(tmp_path, duo_casadi__c=generator.dump())
    path = build_casadi(folder, cache=cache)
    external = casadi.external(name, str(path))
    at = (casadi.DM([0.3, 0.4]), casadi.DM([0.5, 0.6]))
    np.testing.assert_allclose(external(*at).full(), function(*at).full(), rtol=1e-15)
    outputs = casadi.DM(2, 1)
    for exact, compiled in zip(
        function.jacobian()(*at, outputs), external.jacobian()(*at, outputs), strict=True
    ):
        np.testing.assert_allclose(compiled.full(), exact.full(), rtol=1e-15)
    assert build_casadi(folder, cache=cache) == path


def test_casadi_external_that_was_not_asked_for(folder: Path, cache: Cache) -> None:
    with pytest.raises(OutputError, match=r"holds no duo_casadi\.c") as caught:
        build_casadi(folder, cache=cache)
    assert "duo_casadi.c asked for" in caught.value.remedy
