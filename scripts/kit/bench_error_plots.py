"""The picture of one field: errors by time, and error by number of triangles. Needs matplotlib."""

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D

from kit.bench_error_tools import CHOSEN, OWN
from kit.bench_output import save

OURS = ("#1b7f5c", "#c8553d", "#7b4fa3", "#2f6fbf", "#b0892f", "#0f9aa8", "#a0325a", "#5b7a1f")
THEIRS = ("#222222", "#8a6d3b", "#c9a66b", "#d9822b", "#6c8ebf", "#a56cb5", "#9aa5b1")
OUR_MARKS = "oXh"
THEIR_MARKS = "sDdv^<>"

Reading = Callable[[dict], float | None]
"""What a panel shows of a mesh."""


def milliseconds(point: dict) -> float:
    """The median time."""
    return 1e3 * point["quartiles"][1]


def triangles(point: dict) -> float:
    """What the mesh costs whoever uses it."""
    return point["triangles"]


def rms(point: dict) -> float | None:
    """The larger of the two directions; none for a mesh of nothing."""
    return point.get("rms")


def greatest(point: dict) -> float | None:
    """The same."""
    return point.get("max")


def normals(point: dict) -> float | None:
    """Those of vertices, or of faces if there are no others."""
    return point.get("vertex_angle") or point.get("face_angle")


def style(run: dict) -> dict[str, dict]:
    """Colour and mark of each tool: the same in all pictures."""
    styles = {}
    own = [
        tool
        for tool in dict.fromkeys(point["tool"] for point in run["points"])
        if tool.startswith(OWN)
    ]
    for n, tool in enumerate(own):
        turn, place = divmod(n, len(OURS))
        marker = OUR_MARKS[turn % len(OUR_MARKS)]
        styles[tool] = {"color": OURS[place], "marker": marker, "linewidth": 2.2, "zorder": 5}
    for tool, color, marker in zip(CHOSEN, THEIRS, THEIR_MARKS, strict=True):
        styles[tool] = {"color": color, "marker": marker, "linewidth": 1.1, "zorder": 3}
    return styles


def plot(run: dict, path: Path) -> None:
    """Two-sided RMS, greatest distance and normals by time; RMS by triangles."""
    figure, panels = plt.subplots(2, 2, figsize=(13, 10))
    views = (
        ("ms, median", milliseconds, "two-sided RMS distance", rms),
        ("ms, median", milliseconds, "greatest distance", greatest),
        ("ms, median", milliseconds, "normals, RMS degrees", normals),
        ("triangles", triangles, "two-sided RMS distance", rms),
    )
    styles = style(run)
    for axes, (x_name, x, y_name, y) in zip(panels.flat, views, strict=True):
        for tool, look in styles.items():
            points = [point for point in run["points"] if point["tool"] == tool and y(point)]
            points.sort(key=lambda point: point["n"])
            by_faces = y is normals and points and points[0].get("vertex_angle") is None
            curve(axes, points, x, y, look, dashed=by_faces, spread=x is milliseconds)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(x_name)
        axes.set_ylabel(y_name)
        axes.grid(True, which="major", color="#dddddd", linewidth=0.7)
        axes.set_axisbelow(True)
    sizes = sorted({point["n"] for point in run["points"]})
    figure.suptitle(
        f"{run['field']}, {', '.join(map(str, sizes))} samples per axis, left and down is better",
        fontsize=12,
    )
    legend(
        figure,
        {
            tool: look
            for tool, look in styles.items()
            if any(p["tool"] == tool for p in run["points"])
        },
    )
    save(figure, path)


def curve(
    axes: plt.Axes,
    points: list[dict],
    x: Reading,
    y: Reading,
    look: dict,
    dashed: bool,
    spread: bool,
) -> None:
    """One tool: a line, a mark for each mesh, the middle half of the times across it."""
    xs, ys = [x(point) for point in points], [y(point) for point in points]
    common = {"color": look["color"], "zorder": look["zorder"]}
    axes.plot(xs, ys, linewidth=look["linewidth"], linestyle="--" if dashed else "-", **common)
    for point, at, error in zip(points, xs, ys, strict=True):
        fill = "white" if point["faults"] else look["color"]
        axes.plot([at], [error], look["marker"], markersize=6, markerfacecolor=fill, **common)
        if spread:
            low, _, high = (1e3 * value for value in point["quartiles"])
            axes.plot([low, high], [error, error], linewidth=0.8, **common)


def legend(figure: plt.Figure, styles: dict[str, dict]) -> None:
    """Below all panels, once."""
    handles = [
        Line2D(
            [],
            [],
            color=look["color"],
            marker=look["marker"],
            linewidth=look["linewidth"],
            label=tool,
        )
        for tool, look in styles.items()
    ]
    grey = {"color": "#555555", "linewidth": 1.1}
    handles.append(
        Line2D(
            [],
            [],
            marker="o",
            markerfacecolor="white",
            **grey,
            label="hollow: open, non-manifold or wrong topology",
        )
    )
    handles.append(
        Line2D([], [], linestyle="--", **grey, label="dashed: of faces, the tool gives no normals")
    )
    figure.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        ncols=4,
        fontsize=9,
        frameon=False,
    )
