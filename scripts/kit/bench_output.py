"""Table, data and plots of one run. Needs matplotlib."""

from pathlib import Path
from statistics import linear_regression

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

from kit.bench_measure import ENOUGH, MOST, PATIENCE, STEADY, Bench, Result, Series, quartiles
from kit.data import as_json

SECTIONS = {
    "synthetic": "Against VTK Flying Edges",
    "real": "Scans, against VTK Flying Edges",
    "modes": "Topology, placement and matching normals, against the plain way",
    "defaults": "With isokit's defaults, against VTK Flying Edges",
    "command": "Whole command",
    "threads": "Two threads",
    "classify": "Classification",
    "many": "Several isovalues in one call",
    "index": "With an index",
    "bound": "Against the bound",
    "memory": "Memory",
    "slabs": "Slice by slice",
    "again": "Whole command again, with an index",
    "growth": "Growth",
    "peers": "All peers",
}

METHOD = """\
Unless a line says otherwise: `--topology table --placement linear --degenerate never`,
`--boundary open`, f32 positions, unit normals, u32 indices. Contenders are processes that live as
long as a row and take turns, A B C A B C; a first round is not counted. Times are medians, in
parentheses the middle half. A ratio is the median of the rounds' ratios. Reading the volume is not
timed, except where commands are: there all programs use all cores. Memory is a peak, of three runs.

*Cold*: the output's memory is allocated within the time, and what was freed before went back to the
system: isokit and Rust peers run with `MALLOC_MMAP_THRESHOLD_` and `MALLOC_TRIM_THRESHOLD_` at
128 KiB, Python peers call `malloc_trim` before each run. *Warm*: isokit refills a mesh that was
used before; VTK runs a filter that was used before, in what memory its allocator has kept. The data has
the page faults of each run. *Bound*: a pure read of the input, and plain stores to
fresh memory of the output's exact size, advised for 2 MiB pages."""


def rounds(bench: Bench) -> str:
    """How often things are measured, for people."""
    least = f"{bench.rounds} rounds"
    more = f", up to {MOST * bench.rounds} where they are over in {ENOUGH:.0f} s"
    unsteady = f"; while the middle half of times is wider than {STEADY:.0%} of their median"
    longer = f", more, for up to {PATIENCE:.0f} s in all"
    return least if bench.quick else least + more + unsteady + longer


def write(bench: Bench, facts: dict, folder: Path, warning: str) -> None:
    """All three into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "results.md").write_text(table(bench, facts, warning))
    (folder / "results.json").write_text(data(bench, facts, warning))
    for stale in folder.glob("*.png"):
        stale.unlink()
    plot_ratios(bench.results, folder / "ratios.png")
    plot_peers(bench, folder)
    plot_growth(bench, folder / "growth.png")
    plot_index(bench, folder / "index.png")


def data(bench: Bench, facts: dict, warning: str) -> str:
    """Everything, every run included, as JSON."""
    whole = facts | {
        "schema": "isokit.bench/1",
        "warning": warning,
        "rounds": bench.rounds,
        "quick": bench.quick,
        "memory_rates": bench.facts,
        "results": [result.as_dict() for result in bench.results],
        "skipped": bench.skipped,
        "absent": bench.absent,
        "series": [vars(series) for series in bench.series],
    }
    return as_json(whole)


def table(bench: Bench, facts: dict, warning: str) -> str:
    """Everything that was measured, for people."""
    machine, versions = facts["machine"], facts["versions"]
    caches = ", ".join(f"{name} {size}" for name, size in machine["caches"].items())
    parts = [f"# Benchmarks of {facts['date']} on {machine['cpu']}", ""]
    if warning:
        parts += [f"**{warning}**", ""]
    parts += [
        f"Printed by `scripts/bench`, {rounds(bench)}. {machine['cores']} cores"
        f"{', virtual' if machine['hypervisor'] else ''}, {', '.join(machine['simd'])}; "
        f"isokit used {levels(bench)}. {caches}; {machine['memory_gib']} GiB; Linux {machine['kernel']}, "
        f"{machine['libc']}, huge pages {machine['huge_pages']}. Load {facts['load']['start']:.2f} "
        f"at the start, {facts['load']['end']:.2f} at the end, its own work included.",
        "",
        "; ".join(f"{name} {version}" for name, version in versions.items()) + ".",
        "",
        METHOD,
        "",
    ]
    if bench.facts:
        parts += ["## The machine's memory", "", "| work | rate |", "| --- | --- |"]
        parts += [f"| {name} | {rate} |" for name, rate in bench.facts.items()] + [""]
    for row, title in SECTIONS.items():
        lines = [line(result) for result in bench.results if result.row == row]
        if lines:
            head = "| work | isokit | against | ratio | must | aim | reached | remarks |"
            parts += [f"## {title}", "", head, "| --- " * 8 + "|", *lines, ""]
    missing = [f"{name}: {reason}" for name, reason in bench.absent.items()] + bench.skipped
    if missing:
        parts += ["## Not measured", "", *(f"- {reason}" for reason in missing), ""]
    return "\n".join(parts)


def line(result: Result) -> str:
    """One row of a Markdown table."""
    must, aim = result.goal.words()
    ratio = "**{}** {}".format(*result.spread().split(" "))
    work = result.work.replace("|", "\\|")
    cells = (work, result.ours, result.theirs, ratio, must, aim, result.verdict(), result.remark)
    return f"| {' | '.join(cells)} |"


def levels(bench: Bench) -> str:
    """The instruction sets that isokit chose, by its own word."""
    answers = [answer for series in bench.series for answer in series.answers]
    return ", ".join(sorted({answer["simd"] for answer in answers if "simd" in answer})) or "?"


def plot_ratios(results: list[Result], path: Path) -> None:
    """Every ratio that has a goal, as a share of it: at 1 and right of it the goal is reached."""
    wanted = [result for result in results if result.must is not None]
    if not wanted:
        return
    figure, axes = plt.subplots(figsize=(11, 1 + 0.26 * len(wanted)))
    for n, result in enumerate(wanted):
        share, low, high = (
            value / result.must if result.at_least else result.must / value
            for value in (result.ratio, result.low, result.high)
        )
        reached = {"aim": "#2a7f62", "must": "#5b8fd6"}.get(result.verdict(), "#c8553d")
        axes.barh(n, share, color=reached)
        axes.plot([low, high], [n, n], color="black", linewidth=1.2)
        if result.aim is not None:
            aim = result.aim / result.must if result.at_least else result.must / result.aim
            axes.plot([aim, aim], [n - 0.4, n + 0.4], color="black", linewidth=1.2, linestyle=":")
    axes.axvline(1, color="black", linewidth=1)
    axes.set_yticks(range(len(wanted)), [result.work for result in wanted], fontsize=7)
    axes.margins(y=0.01)
    axes.invert_yaxis()
    axes.set_xlabel("share of the least ratio wanted (solid line); dotted: what is aimed at")
    save(figure, path)


def plot_peers(bench: Bench, folder: Path) -> None:
    """The times of all peers on one volume, with normals and without."""
    compared = [result.work for result in bench.results if result.row == "peers"]
    volumes = dict.fromkeys(work.split(" f32")[0] for work in compared)
    for volume in volumes:
        bars = [series for series in bench.series if is_peer_run(series, volume)]
        # Rows before may have measured the same; the last is that of all peers in one loop.
        unique = {label(series): series for series in bars}
        ranked = sorted(unique.items(), key=lambda item: item[1].median)
        figure, axes = plt.subplots(figsize=(9, 1 + 0.3 * len(ranked)))
        for n, (name, series) in enumerate(ranked):
            low, middle, high = (1e3 * value for value in quartiles(series.seconds))
            axes.barh(n, middle, color="#2a7f62" if series.who == "isokit" else "#9aa5b1")
            axes.plot([low, high], [n, n], color="black", linewidth=1.2)
            digits = 1 if middle < 100 else 0
            axes.text(high, n, f" {middle:,.{digits}f} ms", va="center", fontsize=7)
        axes.set_yticks(range(len(ranked)), [name for name, _ in ranked], fontsize=8)
        axes.set_xscale("log")
        axes.margins(x=0.15, y=0.01)
        axes.invert_yaxis()
        axes.set_xlabel(f"ms, cold, {volume}³ f32 (lower is better)")
        save(figure, folder / f"peers_{volume.replace(' ', '_')}.png")


def is_peer_run(series: Series, volume: str) -> bool:
    """Whether it belongs to the picture of all peers."""
    request = series.request
    plain = not {"boundary", "nan"} & request.keys()
    return series.volume == volume and request["op"] == "extract" and not request["warm"] and plain


def label(series: Series) -> str:
    """Who, and how."""
    normals = "normals" if series.request["normals"] else "no normals"
    threads = series.request["threads"]
    return f"{series.who}, {normals}, {threads} thread{'s' * (threads > 1)}"


def plot_growth(bench: Bench, path: Path) -> None:
    """Time per sample by size; level is linear growth."""
    if not any(result.row == "growth" for result in bench.results):
        return
    figure, axes = plt.subplots(figsize=(7, 4))
    shown: set[int] = set()
    for field, name in (("gyroid", "gyroid, period 32 samples"), ("sphere", "sphere")):
        points = {}
        for series in bench.series:
            kind, size, *rest = (*series.volume.split(), "")
            fits = kind == field and bool(rest[0]) == (field == "gyroid")
            if fits and series.request == growth_request(series):
                points[int(size)] = [1e9 * one / int(size) ** 3 for one in series.seconds]
        sizes = sorted(points)
        shown.update(sizes)
        spread = [quartiles(points[size]) for size in sizes]
        axes.plot(sizes, [middle for _, middle, _ in spread], marker="o", label=name)
        axes.fill_between(
            sizes, [low for low, _, _ in spread], [high for _, _, high in spread], alpha=0.25
        )
    axes.set_xscale("log", base=2)
    axes.set_xticks(sorted(shown), [str(size) for size in sorted(shown)])
    axes.set_ylim(bottom=0)
    axes.set_xlabel("samples per axis")
    axes.set_ylabel("ns per sample, warm, 1 thread")
    axes.legend()
    save(figure, path)


def growth_request(series: Series) -> dict:
    """The request as the row of growth makes it: it alone says how many times in a row."""
    plain = {"op": "extract", "threads": 1, "normals": True, "warm": True}
    return plain | {name: series.request.get(name) for name in ("iso", "runs")}


def plot_index(bench: Bench, path: Path) -> None:
    """Time by the share of bricks that the surface goes through, with the line nearest to it."""
    known = [series for series in bench.series if "index" in series.request]
    if len(known) < 2:
        return
    figure, axes = plt.subplots(figsize=(7, 4))
    shares = [100 * series.answers[-1]["active"] for series in known]
    spread = [[1e3 * one for one in quartiles(series.seconds)] for series in known]
    middles = [middle for _, middle, _ in spread]
    axes.plot(shares, middles, "o", color="#2a7f62", label="with the index")
    for share, (low, _, high) in zip(shares, spread, strict=True):
        axes.plot([share, share], [low, high], color="black", linewidth=1.2)
    slope, start = linear_regression(shares, middles)
    ends = [0, max(shares)]
    axes.plot(
        ends,
        [start + slope * end for end in ends],
        color="#2a7f62",
        linewidth=1,
        label=f"{start:.2f} ms + {slope:.2f} ms per %",
    )
    without = [
        1e3 * other.median
        for series in known
        for other in bench.series
        if other.volume == series.volume
        and series.request == other.request | {"index": True}
        and "index" not in other.request
    ]
    if len(without) == len(shares):
        axes.plot(shares, without, "o", color="#9aa5b1", label="without")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(f"% of the bricks that the surface goes through ({known[0].volume}³ f32)")
    axes.set_ylabel("ms, normals, warm, 1 thread")
    axes.legend()
    save(figure, path)


def save(figure: plt.Figure, path: Path) -> None:
    """Writes and forgets a figure."""
    figure.tight_layout()
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)
