"""What `scripts/bench_error` must find of isokit, and what is aimed at.

Times to an error are read off the curve of a tool, straight between its points in log-log. A curve
that ends above the error is continued by the line through its finest points, for peers only.
"""

import math
from dataclasses import dataclass
from statistics import linear_regression

from kit.bench_error_fields import POSITIONS
from kit.bench_error_tools import DOUBLE, OWN, is_double

VERTICES = 1e-6
"""Of the diameter: the RMS distance of vertices to which tools are timed."""

FINEST = 4
"""Lattices through which a line is laid."""

NORMALS = 1e-5
"""Degrees: below it errors are those of normals kept as f32, and no order is seen."""

METHOD = f"""\
*Time to* an error is read off the times and errors measured, straight between two lattices in
log-log; the best mode of isokit stands beside the best peer. A peer that does not get there on the
lattices measured has its time from the line through its {FINEST} finest ones, and a *≥*. Errors are
parts of the field's diameter, its longest extent along an axis. Both get the same samples; modes
with *{DOUBLE}* take no part.

*Best by offsets* is the mesh of `{OWN} cubic` with each vertex moved along the surface's own normal
so that the RMS over all triangles is the least there is: its equations know the surface, which no
program does. *Volume* is the error of the enclosed volume, over that before `balance`.

*Order* is the slope of a line through the {FINEST} finest lattices, samples and positions as f64;
normals are f32 always, and those right to {NORMALS:g}° are left out. Where the errors of a field
depend on where slices cut it, or those of most lattices are no more than rounding, orders are seen on
lattices more, at {len(POSITIONS)} places each: the squares of the errors of all are taken together."""


@dataclass
class Figure:
    """One promise on one field."""

    what: str
    field: str
    value: float | None
    """None if it could not be measured."""
    must: float
    aim: float | None = None
    most: bool = False
    """Whether it may be that at most, not at least."""
    bound: str = ""
    """What stands before it if it is only a bound."""
    is_seen: bool = True
    """Whether there is enough to find it from."""
    ours: str = ""
    beside: str = ""

    def holds(self) -> bool:
        """Whether it is as it must be."""
        if self.value is None:
            return False
        return self.value <= self.must if self.most else self.value >= self.must

    def row(self) -> dict[str, str]:
        """For the table."""
        sign = "≤ " if self.most else "≥ "
        value = "-" if self.value is None else f"{self.bound}{self.value:.3g}"
        return {
            "what": self.what,
            "field": self.field,
            "figure": f"**{value}**",
            "must be": f"{sign}{self.must:g}",
            "aim": "" if self.aim is None else f"{sign}{self.aim:g}",
            "holds": "yes" if self.holds() else "**no**" if self.is_seen else "-",
            "isokit": self.ours,
            "beside it": self.beside,
        }


def figures(runs: list[dict]) -> list[Figure]:
    """All that is promised of the fields that were measured."""
    smooth = [run for run in runs if run["smooth"]]
    vertices = f"time to vertices of RMS {VERTICES:.0e}, times less"
    found = [to_error(run, vertices, ("vertex_rms", VERTICES), 100, 500) for run in smooth]
    for run in smooth:
        least = run["surface_rms"]
        surface = f"time to a surface of RMS {least:.0e}, times less"
        found.append(to_error(run, surface, ("rms", least), 3, 10))
    balanced = [run for run in smooth if run["best_by_offsets"]]
    found += [figure for run in balanced for figure in of_balance(run)]
    return found + [figure for run in smooth for figure in orders(run)]


def missed(runs: list[dict]) -> list[str]:
    """What does not hold, in a line each; nothing of what could not be told for want of a peer or of lattices."""
    rows = [figure.row() for figure in figures(runs) if figure.is_seen and not figure.holds()]
    line = "{field}: {what}: {figure}, must be {must be}"
    return [line.format(**row).replace("*", "") for row in rows]


def to_error(
    run: dict, what: str, asked: tuple[str, float], must: float, aim: float
) -> Figure:
    """The best peer's time to an error over isokit's."""
    key, part = asked
    curves = by_tool(run["points"])
    reached = {
        tool: reach(points, key, part * run["diameter"], beyond=not tool.startswith(OWN))
        for tool, points in curves.items()
        if not is_double(tool)
    }
    known = {tool: reached for tool, reached in reached.items() if reached}
    best = []
    for own in (True, False):
        sided = {tool: found for tool, found in known.items() if tool.startswith(OWN) == own}
        best.append(min(sided.items(), key=lambda item: item[1].seconds, default=None))
    said = ["not reached" if one is None else f"{one[1].text()}, {one[0]}" for one in best]
    figure = Figure(what, run["field"], None, must, aim, ours=said[0], beside=said[1])
    # Without a peer there is nothing to say; where only isokit does not get there, it misses it.
    figure.is_seen = best[1] is not None
    if None not in best:
        (_, ours), (_, theirs) = best
        figure.value = theirs.seconds / ours.seconds
        figure.bound = "≥ " if ours.bound or theirs.bound else ""
    return figure


def of_balance(run: dict) -> list[Figure]:
    """What balance leaves, beside the least that offsets can."""
    curves = by_tool(run["points"])
    best = run["best_by_offsets"][-1]
    n, found = best["n"], []
    at = {tool: {point["n"]: point for point in points} for tool, points in curves.items()}
    plain, balanced = (at.get(f"{OWN} {mode}", {}).get(n) for mode in ("cubic", "cubic balance"))
    if plain is None or balanced is None:
        return []
    found.append(
        Figure(
            f"surface RMS of balance over the best by offsets, {n}³",
            run["field"],
            balanced["rms"] / best["rms"],
            1.1,
            1.04,
            most=True,
            ours=f"{balanced['rms']:.3e}, {balanced['triangles']:,} triangles",
            beside=f"{best['rms']:.3e}, {best['triangles']:,} triangles; {plain['rms']:.3e} before",
        )
    )
    errors = [abs(point["volume_error"]) for point in (balanced, plain)]
    found.append(
        Figure(
            f"volume error of balance over that before, {n}³",
            run["field"],
            errors[0] / errors[1],
            1 / 20,
            most=True,
            ours=f"{100 * errors[0]:.2e} %",
            beside=f"{100 * errors[1]:.2e} % before",
        )
    )
    return found


def orders(run: dict) -> list[Figure]:
    """By how fast errors fall."""
    more = run.get("order_points") or []
    sizes = {point["n"] for point in more}
    curves = by_tool([point for point in run["points"] if point["n"] not in sizes] + more)
    found = []
    modes = (("linear exact", 1.9), ("cubic exact matching", 3.8), ("quintic exact matching", 5.5))
    for mode, must in modes:
        points = curves.get(f"{OWN} {mode} {DOUBLE}", [])
        what = f"order of vertices, {mode.split()[0]}"
        found.append(order(run, what, points, ("vertex_rms", 0.0), must))
    points = curves.get(f"{OWN} cubic exact matching {DOUBLE}", [])
    found.append(order(run, "order of normals, cubic", points, ("vertex_angle", NORMALS), 3.8))
    return found


def order(
    run: dict, what: str, points: list[dict], asked: tuple[str, float], must: float
) -> Figure:
    """One of them; without a value on fewer lattices, or where errors are no more than what rounding makes."""
    key, least = asked
    known = [point for point in points if (point.get(key) or 0) > least][-FINEST:]
    figure = Figure(what, run["field"], None, must, is_seen=len(known) == FINEST)
    figure.beside = f"{len(known)} lattices with an error above rounding, {FINEST} are needed"
    if len(known) == FINEST:
        figure.value = slope(known, key)
        figure.ours = f"{known[-1][key]:.2e} at {known[-1]['n']}³"
        figure.beside = f"{known[0][key]:.2e} at {known[0]['n']}³"
    return figure


def slope(points: list[dict], key: str, by: str = "h") -> float:
    """That of a line through log of error by log of something."""
    xs, ys = ([math.log(point[what]) for point in points] for what in (by, key))
    return linear_regression(xs, ys).slope


@dataclass
class Reached:
    """When a tool gets to an error."""

    seconds: float
    bound: str = ""
    """`<` if its coarsest mesh is better, `≥` if it was not seen to."""
    ends: tuple[dict, ...] = ()
    """The meshes between which it lies."""

    def text(self) -> str:
        """For people."""
        return f"{self.bound}{' ' * bool(self.bound)}{1e3 * self.seconds:.3g} ms"


def reach(points: list[dict], key: str, error: float, beyond: bool = False) -> Reached | None:
    """When the curve first goes below an error; `beyond` its end, by its slope."""
    known = [point | {"seconds": point["quartiles"][1]} for point in points if point.get(key)]
    if not known:
        return None
    if known[0][key] <= error:
        return Reached(known[0]["seconds"], "<", (known[0],))
    for one, other in zip(known, known[1:], strict=False):
        if one[key] > error >= other[key]:
            share = math.log(one[key] / error) / math.log(one[key] / other[key])
            start, end = one["seconds"], other["seconds"]
            return Reached(start * (end / start) ** share, "", (one, other))
    last = known[-FINEST:]
    if not beyond or len(last) < FINEST:
        return None
    per_lattice = [slope(last, what) for what in (key, "seconds")]
    if not per_lattice[0] > 0 > per_lattice[1]:
        return None  # it does not get better, or costs nothing: there is nothing to continue
    finer = (last[-1][key] / error) ** (1 / per_lattice[0])
    return Reached(last[-1]["seconds"] * finer ** -per_lattice[1], "≥", (last[-1],))


def by_tool(points: list[dict]) -> dict[str, list[dict]]:
    """The points of each tool, coarse to fine."""
    curves: dict[str, list[dict]] = {}
    for point in sorted(points, key=lambda point: point["n"]):
        curves.setdefault(point["tool"], []).append(point)
    return curves
