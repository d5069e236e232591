"""Forces in the links, by the accelerations that the Lagrangian's positions have along a motion that the forward dynamics makes."""

from __future__ import annotations

from phichain.proof.case import Case, Wrong, nothing, proves
from phichain.proof.lagrange import along_told
from phichain.proof.modular.compiled import FAULTS
from phichain.proof.modular.field import PRIME, dot, plus


@proves("tensions")
def tensions(case: Case) -> None:
    """-q_k . sum_{a>=k} m_a (r_a'' - g e_d), with r'' = D^2 r (x', x') + D r x''; the forward dynamics, itself proven, gives x''."""
    point, judge, chain = case.point, case.judge, case.chain
    try:
        a = case.forward.values(point.given(), point)["a"][0]
    except FAULTS as fault:
        raise Wrong(f"no accelerations, for {nothing(fault)}") from fault
    motion = judge.motion(point, a=a)
    values = {"q": motion.x, "v": motion.omega, judge.rate: motion.rate}
    curved = judge.evaluate(point, values, along={"q": motion.rate}, across={"q": motion.rate})["positions"]
    straight = judge.evaluate(point, values, along={"q": motion.acceleration})["positions"]
    size, gravity = len(chain.directions[0]), chain.single("gravity")
    beyond, true = [0] * size, list[int]()
    for k in reversed(range(case.scene.links)):
        rows = range(size * k, size * (k + 1))
        rise = [(curved[3][i] + straight[1][i]) % PRIME for i in rows]
        rise[-1] -= gravity
        if case.scene.is_moving:
            rise = plus(rise, along_told(case.scene, point.u))
        beyond = plus(beyond, rise, chain.per_link("mass")[k])
        true.append(-dot(chain.directions[k], beyond))
    case.same("out", case.run()["out"], true[::-1])
