"""Times that are no numbers, as C may be given them: no flow says that it has arrived."""

from __future__ import annotations

from pathlib import Path

import pytest

from phichain.scene import Scene
from tests.generated.compiling import run, write_c

_HEAD = '#include "late.h"\n#include <math.h>\n#include <string.h>\nint main(void)\n{\n    double q[1] = {0.3}, v[1] = {0.1};\n'
_CALLS = {
    "propagate": """    static late_workspace work;
    late_flow flow;
    memset(&flow, 0, sizeof flow);
    flow.work = &work;
    flow.tolerance = 1e-9;
    if (late_propagate(&flow, 1.0, 1000, q, v, NULL, 0, NULL, NULL, NULL) != LATE_DONE) return 2;
    return late_propagate(&flow, END, 1000, q, v, NULL, 0, NULL, NULL, NULL) != LATE_NOT_FINITE;
}
""",
    "propagate_stiff": """    static late_stiff_workspace work;
    late_stiff flow;
    memset(&flow, 0, sizeof flow);
    flow.work = &work;
    flow.tolerance = 1e-6;
    if (late_propagate_stiff(&flow, 1.0, 1000, q, v, 0, NULL, NULL, NULL) != LATE_STIFF_DONE) return 2;
    return late_propagate_stiff(&flow, END, 1000, q, v, 0, NULL, NULL, NULL) != LATE_STIFF_NOT_FINITE;
}
""",
}


@pytest.mark.parametrize("flow", _CALLS)
def test_a_flow_never_arrives_at_a_time_that_is_no_number(flow: str, tmp_path: Path) -> None:
    source = write_c(Scene("late", 1, mass=1.0, length=0.5, want=[flow]), tmp_path)
    main = source.with_name("main.c")
    main.write_text(_HEAD + _CALLS[flow].replace("END", "(double)NAN"))
    run("cc", "-std=c99", "-O1", source.name, main.name, "-o", "late", "-lm", cwd=source.parent)
    run(source.parent / "late")
