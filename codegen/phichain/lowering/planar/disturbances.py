"""What the derivatives by angles and rates disturb: single joints of the planar chain (theory, section 5).

Turning joint k turns the chain beyond against the acceleration t of the tip before it and turns its force f: a jump (t_y, -t_x) of the
acceleration and a force (-f_y, f_x). Turning link k faster moves its tip by -2 w along it and its mass likewise. A spring or damper
is a couple on the joint. Each is a force eta seen at joint k - 1, a turn -zeta of link k - 1 and a jump d beyond its tip, and at link k
a turn phi and a jump of its own. A column by an angle of the scene is a sum of few of them, one by a relative rate that of all beyond.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from phichain.ir.builder import ArrayRef, Builder, Expr, Index, Loop
from phichain.lowering.chain.parameters import Parameters
from phichain.lowering.planar.response import Base, Pair, Response, dot
from phichain.scene import Scene


@dataclass(frozen=True)
class Jump:
    """What happens at a link: a jump (x, y) of the acceleration beyond its tip, and a free turn phi."""

    x: Expr
    y: Expr
    phi: Expr


class Disturbance:
    """One kind of disturbance at every joint: arrays over joints, zero beyond the tip."""

    def __init__(self, builder: Builder, name: str, links: int, fields: Sequence[str]) -> None:
        self.nothing, self.links = builder.lift(0), links
        self.nothing_at: set[tuple[str, Index]] = set()
        self.cells = {field: builder.array(f"{name}_{field}", links + 2) for field in fields}
        for cells in self.cells.values():
            for k in (links, links + 1):
                cells[k] = self.nothing

    def get(self, field: str, k: Index) -> Expr:
        """The entry of joint or link k; zero where this kind has none."""
        return self.cells[field][k] if field in self.cells and (field, k) not in self.nothing_at else self.nothing

    def put(self, k: Index, **values: Expr) -> None:
        for field, value in values.items():
            if field in self.cells:
                self.cells[field][k] = value
                if value.is_zero and isinstance(k, int):
                    self.nothing_at.add((field, k))
                else:
                    self.nothing_at.discard((field, k))

    def eta(self, k: Index) -> Pair:
        return self.get("eta_x", k), self.get("eta_y", k)


def turned_joints(builder: Builder, scene: Scene, parameters: Parameters, response: Response, base: Base) -> Disturbance:
    """Of the joints' angles; springs with them."""
    kept, sweep, overhang = response.sweep.kept, response.sweep, response.units.overhang
    fields = ["eta_x", "eta_y", "zeta", "x", "y"] + (["phi"] if parameters.stiffness is not None else [])
    found = Disturbance(builder, "angle", scene.links, fields)
    found.put(0, x=base.tip[1], y=-base.tip[0], zeta=_at_base(response, base, parameters.stiffness, base.zeta))
    with builder.loop("k", 1, scene.links) as loop:
        k = loop.index
        before = k - 1
        tip, force = [(kept[f"{name}_x"][before], kept[f"{name}_y"][before]) for name in ("tip", "tip_force")]
        gain, unit = sweep.gain_x[before], response.torque_unit[before]
        zeta = builder.let("joint_turn", kept["inverse"][before] * force[0] - kept["level"][before] * tip[0])
        eta_x = unit * (kept["axial"][before] * tip[1] - gain * (tip[0] + force[0]) - force[1])
        eta_y = -(unit * overhang[before] * (zeta + gain * tip[1]))
        found.put(k, x=tip[1], y=-tip[0], **_with_couple(response, parameters.stiffness, k, (eta_x, eta_y), zeta))
    _own_couple(builder, response, parameters.stiffness, found)
    return found


def slowed_joints(builder: Builder, scene: Scene, slopes: ArrayRef, response: Response, base: Base) -> Disturbance:
    """Of the joints' rates: what resists them, by its slopes (N m s/rad)."""
    found = Disturbance(builder, "slowing", scene.links, ["eta_x", "eta_y", "zeta", "phi"])
    nothing = builder.lift(0)
    found.put(0, zeta=_at_base(response, base, slopes, nothing))
    with builder.loop("k", 1, scene.links) as loop:
        k = loop.index
        found.put(k, **_with_couple(response, slopes, k, (nothing, nothing), nothing))
    _own_couple(builder, response, slopes, found)
    return found


def _at_base(response: Response, base: Base, rate: ArrayRef | None, zeta: Expr) -> Expr:
    if rate is None or base.mobile.is_zero:
        return zeta
    return zeta - rate[0] * (base.mobile * response.arrays["joint_gain"][0])


def _with_couple(response: Response, rate: ArrayRef | None, k: Index, eta: Pair, zeta: Expr) -> dict[str, Expr]:
    """eta and zeta with the couple -rate on joint k: eta = -sigma and zeta = (1 + n.rho) / D a unit."""
    if rate is not None:
        sigma = response.row(k, True)
        eta = eta[0] + rate[k] * sigma[0], eta[1] + rate[k] * sigma[1]
        zeta = zeta - rate[k] * (response.arrays["link_mobility"][k - 1] * (1 + response.arrays["joint_gain"][k]))
    return {"eta_x": eta[0], "eta_y": eta[1], "zeta": zeta}


def _own_couple(builder: Builder, response: Response, rate: ArrayRef | None, found: Disturbance) -> None:
    if rate is None:
        return
    with builder.loop("k", 0, found.links) as loop:
        found.put(loop.index, phi=-(rate[loop.index] * response.arrays["link_mobility"][loop.index]))


def faster_links(
    builder: Builder, scene: Scene, response: Response, base: Base, rate: ArrayRef, beside: Callable[[Loop], None] | None = None
) -> Disturbance:
    """Of the links' absolute rates; in relative angles of each rate and all beyond it together.

    Args:
        beside: writes what goes outwards over joint k, 0 < k < N, into a loop over k: beside it these forces go inwards.
    """
    sweep, kept, units, relative = response.sweep, response.sweep.kept, response.units, scene.angles == "relative"
    found = Disturbance(builder, "rate", scene.links, ["eta_x", "eta_y", "zeta", "along"])
    force_x, force_y = builder.array("rate_force_x", scene.links), builder.array("rate_force_y", scene.links)
    with builder.loop("k", 0, scene.links) as loop:
        k = loop.index
        along = builder.let("tip_slope", -2 * rate[k])
        unit = builder.let("force_slope", response.torque_unit[k] * along)
        found.put(k, along=along)
        force_x[k] = unit * (units.leverage[k] + kept["axial"][k])
        force_y[k] = -(unit * (units.overhang[k] * sweep.gain_x[k]))
    with builder.loop("k", scene.links - 1, 0, -1) if beside is None else builder.loop("k", 1, scene.links) as loop:
        k = loop.index if beside is None else scene.links - loop.index
        if beside is not None:
            beside(loop)
        force = force_x[k], force_y[k]
        if relative:
            beyond = loop.carry("rate_beyond_x", 0), loop.carry("rate_beyond_y", 0)
            force = builder.let("rate_sum_x", force[0] + beyond[0]), builder.let("rate_sum_y", force[1] + beyond[1])
        eta = response.inwards(k, force)
        found.put(k, eta_x=eta[0], eta_y=eta[1], zeta=response.arrays["link_mobility"][k - 1] * dot(response.turn(k), force))
        if relative:
            for carried, value in zip(beyond, eta, strict=True):
                loop.follow(carried, value)
    force = force_x[0], force_y[0]
    if relative:
        force = force[0] + beyond[0], force[1] + beyond[1]
    found.put(0, zeta=base.mobile * dot(response.turn(0), force))
    return found


class Column:
    """The columns of one derivative: weighted sums of disturbances at joint m and the next ones.

    Args:
        name: prefix of its arrays.
        parts: disturbances and their weights at joint m, m + 1, ...
        whole: a disturbance whose entry at joint m stands for all beyond, and acts on every link from m on.
    """

    def __init__(
        self, builder: Builder, name: str, response: Response, parts: Sequence[tuple[Disturbance, Sequence[int]]],
        base: Base, whole: Disturbance | None = None,
    ) -> None:  # fmt: skip
        self.builder, self.name, self.response, self.base = builder, name, response, base
        self.parts, self.whole, self.nothing = parts, whole, builder.lift(0)
        self.reach = max([0, *(self._reach(part, weights) for part, weights in parts)])
        mixed = any(len(weights) > 1 for _, weights in parts)
        self.total = self._totals() if mixed or len(parts) + (whole is not None) > 1 else None

    def _reach(self, part: Disturbance, weights: Sequence[int]) -> int:
        return len(weights) - 1 + ("phi" in part.cells or "along" in part.cells)

    def _totals(self) -> Disturbance:
        total = Disturbance(self.builder, self.name, self.response.scene.links, ["eta_x", "eta_y", "zeta"])
        force = self._beyond(0, 0, self.parts)
        zeta = self._sum("zeta", 0)
        total.put(0, zeta=zeta if self.base.mobile.is_zero else zeta + self.base.mobile * dot(self.response.turn(0), force))
        with self.builder.loop("k", 1, self.response.scene.links) as loop:
            k = loop.index
            force = self._beyond(k, 0, self.parts)
            eta = self.response.inwards(k, force)
            zeta = self.response.arrays["link_mobility"][k - 1] * dot(self.response.turn(k), force)
            total.put(
                k, eta_x=self._sum("eta_x", k) + eta[0], eta_y=self._sum("eta_y", k) + eta[1],
                zeta=self._sum("zeta", k) + zeta,
            )  # fmt: skip
        return total

    def _sum(self, field: str, k: Index) -> Expr:
        """What the disturbances at joint k itself have."""
        own = self.nothing if self.whole is None else self.whole.get(field, k)
        for part, weights in self.parts:
            own = own + weights[0] * part.get(field, k)
        return own

    def _beyond(self, k: Index, lag: int, parts: Sequence[tuple[Disturbance, Sequence[int]]]) -> Pair:
        """Force at joint k of the disturbances at later joints, for column k - lag."""
        x, y = self.nothing, self.nothing
        for part, weights in parts:
            for later in range(lag + 1, len(weights)):
                if weights[later]:
                    force = part.eta(k + (later - lag))
                    for step in range(later - lag - 1, 0, -1):
                        force = self.response.inwards(k + step, force)
                    x, y = x + weights[later] * force[0], y + weights[later] * force[1]
        return x, y

    def eta(self, k: Index) -> Pair:
        """What column k does to the chain inside, at joint k - 1."""
        found = self.total or self.whole or self.parts[0][0]
        return found.eta(k)

    def start(self, k: Index) -> Jump:
        """What column k begins with, at link k - 1."""
        found = self.total or self.whole or self.parts[0][0]
        x, y = self.nothing, self.nothing
        for part, weights in self.parts:
            x, y = x + weights[0] * part.get("x", k), y + weights[0] * part.get("y", k)
        return Jump(x, y, -found.get("zeta", k))

    def common(self, k: Index) -> Jump:
        """What all columns up to k have at link k."""
        if self.whole is None:
            return Jump(self.nothing, self.nothing, self.nothing)
        return Jump(self.whole.get("along", k), self.nothing, -self.whole.get("zeta", k + 1))

    def along(self, k: Index, lag: int) -> Jump:
        """What column k - lag has at link k."""
        common = self.common(k)
        x, y, phi = common.x, common.y, common.phi
        for part, weights in self.parts:
            own, after = (weights[i] if i < len(weights) else 0 for i in (lag, lag + 1))
            if own:
                phi, x = phi + own * part.get("phi", k), x + own * part.get("along", k)
            if after:
                x, y = x + after * part.get("x", k + 1), y + after * part.get("y", k + 1)
                phi = phi - after * part.get("zeta", k + 1)
            if any(weights[lag + 2 :]):
                force = self._beyond(k + 1, lag + 1, ((part, weights),))
                phi = phi - self.response.arrays["link_mobility"][k] * dot(self.response.turn(k + 1), force)
        return Jump(x, y, phi)
