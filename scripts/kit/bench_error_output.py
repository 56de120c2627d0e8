"""Table of the runs of `scripts/bench_error` that lie in a folder, a file for each field."""

import json
from pathlib import Path

from kit import bench_error_must, bench_error_plots
from kit.bench_error_fields import FIELDS
from kit.bench_error_must import FINEST, by_tool, reach, slope
from kit.bench_error_tools import NO_DUAL

METHOD = """\
Each field is given at n³ points of the cube from -1 to 1, a distance h = 2/(n - 1) apart; positive
is inside. Lengths are in units of which the cube has two.

*Time* is the median, in parentheses the middle half, of cold runs from the samples in memory to the
mesh in memory, one thread unless said otherwise; tools take turns. isokit and what can make normals
make them; what `refine` and `balance` do counts. Sampling the field is not in it. meshlib takes all
cores. SurfaceNets gets labels, made off the clock. Modes of isokit with *f64* get samples as f64 and
give positions as f64, whatever the others get.

On a busy machine short runs slip between interruptions and long ones do not: then times favour the
fast, and ratios of times say too much.

*RMS* and *greatest* are the larger of the two directions: of the mesh from the surface, at the
vertices and at seven points in each triangle, weighted with area; and of points spread over the
surface from the mesh, which can only come out too large. Those points are chance ones, so the
greatest of that direction comes out too small. *Vertices* is the RMS distance of vertices alone.
*Normals* are RMS angles in degrees: of the vertex normals that a tool gives, and of faces, weighted
with area. *Order* is the slope of a line through the four finest lattices, as log of error by log
of h; a noisy slope says little. Surfaces that leave the cube are judged within 80 % of it.

A *bound* is what isokit itself says that triangles leave the surface by at most, before they are
balanced, as second derivatives tell it. That surface is the one of the cubic field through the
samples, since isokit knows no other: on a coarse lattice the given one may be farther. *Without* a
bound are those that isokit counts beside it, at creases and where the surface bends within a cell.
The greatest distance measured is of all triangles, of surfaces that leave the cube within 80 % of
it.

*Faults*: edges of one triangle (not counted along the border of the cube if the surface leaves it)
or of more than two, vertices as stored; and components and χ = V - E + F other than those of the
field, where these are known. Such a mesh is a hollow mark in the plots, and (○) below."""

ERRORS = {
    "vertices": "vertex_rms",
    "RMS": "rms",
    "greatest": "max",
    "vertex normals": "vertex_angle",
    "face normals": "face_angle",
}

def write(folder: Path) -> list[str]:
    """Table and plots of all files that are there. What is not as it must be."""
    found = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}
    runs = [found[name] for name in FIELDS if name in found]
    for run in runs:
        bench_error_plots.plot(run, folder / f"{run['field']}.png")
    (folder / "results.md").write_text(table(runs))
    return bench_error_must.missed(runs)


def table(runs: list[dict]) -> str:
    """Everything, for people."""
    first = runs[0]
    machine = first["machine"]
    versions = "; ".join(f"{name} {version}" for name, version in first["versions"].items())
    parts = [
        f"# Run time against error, {first['date']}, {machine['cpu']}",
        "",
        f"Printed by `scripts/bench_error`. {machine['cores']} cores"
        f"{', virtual' if machine['hypervisor'] else ''}, {', '.join(machine['simd'])}; "
        f"{machine['memory_gib']} GiB; Linux {machine['kernel']}, {machine['libc']}.",
        "",
        f"{versions}.",
        "",
        *(
            line
            for note in dict.fromkeys(run["note"] for run in runs)
            if note
            for line in (note, "")
        ),
        METHOD,
        "",
    ]
    promised = [figure.row() for figure in bench_error_must.figures(runs)]
    if promised:
        parts += ["## Must", "", *markdown(promised), "", bench_error_must.METHOD, ""]
    warnings = dict.fromkeys(run["warning"] for run in runs if run["warning"])
    parts[2:2] = [line for warning in warnings for line in (f"**{warning}**", "")][:2]
    for run in runs:
        parts += section(run, first)
    missing = {f"{name}: {reason}" for run in runs for name, reason in run["absent"].items()}
    missing = [NO_DUAL, *sorted(missing), *(line for run in runs for line in run["skipped"])]
    parts += ["## Not measured", "", *(f"- {reason}" for reason in missing), ""]
    return "\n".join(parts)


def section(run: dict, first: dict) -> list[str]:
    """One field."""
    curves = by_tool(run["points"])
    finest = max(point["n"] for point in run["points"])
    threads = f"{run['threads']} thread{'s' * (run['threads'] > 1)}"
    head = f"{run['rounds']} rounds, {run['dtype']}, {threads}; "
    loads = [load for pair in run["loads"] for load in pair]
    head += f"load {min(loads):.2f} to {max(loads):.2f}, its own work included. "
    if same(run) != same(first):
        head += "Measured {} on {}, isokit {}. ".format(*same(run))
    sampling = ", ".join(f"{1e3 * s:.0f} ms ({n}³)" for n, s in run["sampling_s"].items())
    head += f"Sampling the field by numpy took {sampling}."
    if run["thickness"]:
        head += f" Its thinnest wall is {run['thickness']:.2g}; with a larger h it is not resolved."
    parts = [f"## {run['field']}", "", f"![{run['field']}]({run['field']}.png)", "", head, ""]
    parts += [f"At {finest}³:", "", *markdown(finest_rows(curves, finest)), ""]
    bounds = bound_rows(run["points"])
    if bounds:
        parts += ["Bounds, where one was asked for:", "", *markdown(bounds), ""]
    parts += ["Order:", "", *markdown(order_rows(curves)), ""]
    rows = time_rows(curves)
    if rows:
        parts += ["Milliseconds until the RMS is as small:", "", *markdown(rows), ""]
    broken = faults(run)
    return parts + (["Faults:", "", *broken, ""] if broken else [])


def same(run: dict) -> tuple:
    """What makes figures comparable."""
    return run["date"], run["machine"]["cpu"], run["versions"]["isokit"]


def finest_rows(curves: dict[str, list[dict]], n: int) -> list[dict[str, str]]:
    """Everything about the finest meshes."""
    rows = []
    for tool, points in curves.items():
        point = points[-1]
        if point["n"] != n:
            continue
        low, middle, high = (1e3 * value for value in point["quartiles"])
        row = {"": tool, "triangles": f"{point['triangles']:,}"}
        row["ms"] = f"**{middle:.2f}** ({low:.2f}-{high:.2f})"
        row |= {name: number(point.get(key)) for name, key in ERRORS.items()}
        for name in ("area", "volume"):
            error = point.get(f"{name}_error")
            row[name] = "" if error is None else f"{100 * error:+.3g} %"
        rows.append(row | {"faults": "; ".join(point["faults"])})
    return rows


def bound_rows(points: list[dict]) -> list[dict[str, str]]:
    """What a tool said of its meshes' distances beside what they are."""
    rows = []
    for point in points:
        if not point.get("unbounded") and not point.get("bound"):
            continue
        share = point["unbounded"] / point["triangles"]
        rows.append({
            "": f"{point['tool']}, {point['n']}³",
            "bound": number(point["bound"]),
            "triangles without": f"{point['unbounded']:,} ({100 * share:.2g} %)",
            "greatest, mesh to surface": number(point.get("forward_max")),
        })
    return rows


def order_rows(curves: dict[str, list[dict]]) -> list[dict[str, str]]:
    """Slopes of all errors."""
    rows = []
    for tool, points in curves.items():
        row = {"": tool}
        for name, key in ERRORS.items():
            known = [point for point in points if point.get(key)][-FINEST:]
            row[name] = f"{slope(known, key):.2f}" if len(known) == FINEST else ""
        rows.append(row)
    return rows


def time_rows(curves: dict[str, list[dict]]) -> list[dict[str, str]]:
    """When each tool gets to errors that at least two of them get to."""
    steps = [digit * 10.0**-power for power in range(1, 13) for digit in (3, 1)]
    shared = [e for e in steps if sum(crosses(points, e) for points in curves.values()) >= 2]
    rows = []
    for tool, points in curves.items():
        rows.append({"": tool} | {f"{e:.0e}": reached(points, e) for e in shared[-4:]})
    return rows if shared else []


def crosses(points: list[dict], error: float) -> bool:
    """Whether the curve goes through an error."""
    found = reach(points, "rms", error)
    return found is not None and not found.bound


def reached(points: list[dict], error: float) -> str:
    """The time for people; a bound or a dash where the curve does not cross the error."""
    known = [point for point in points if point.get("rms")]
    if not known:
        return "-"
    found = reach(known, "rms", error)
    if found is None:
        return f"- (best {min(point['rms'] for point in known):.1e})"
    return f"{found.bound}{1e3 * found.seconds:.2f}" + mark(found.ends)


def mark(points: tuple[dict, ...]) -> str:
    """A ring if one of the meshes is broken."""
    return " ○" if any(point["faults"] for point in points) else ""


def faults(run: dict) -> list[str]:
    """Each fault with the tools and sizes that have it."""
    lines: dict[tuple[int, str], list[str]] = {}
    for point in run["points"]:
        if point["faults"]:
            lines.setdefault((point["n"], "; ".join(point["faults"])), []).append(point["tool"])
    return [f"- {n}³, {what}: {', '.join(names)}" for (n, what), names in lines.items()]


def number(value: float | None) -> str:
    """Three digits, small numbers as powers of ten."""
    if value is None:
        return ""
    return f"{value:.3g}" if value >= 0.01 else f"{value:.2e}"


def markdown(rows: list[dict[str, str]]) -> list[str]:
    """A table of rows with the same keys."""
    head = list(rows[0])
    lines = [head, ["---"] * len(head), *([row[key] for key in head] for row in rows)]
    return [f"| {' | '.join(cells)} |" for cells in lines]
