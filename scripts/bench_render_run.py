#!/usr/bin/env python3
"""Measures pictures of isokit and VTK, and what it is worth to skip what cannot be seen.

Times are of a picture in memory from samples or surfaces in memory, medians of rounds in which
the contenders take turns; what is found out once for pictures from all sides (blocks in which
something can be seen, meshes; what VTK keeps of a volume) is apart.
Errors of ray casting are root mean squares of colours from 0 to 1 against a picture of the same
program with steps of a sixteenth, before black, rounded to 8 bits as VTK's are; and, by the books,
against rays in float64 that are neither's, at every eighth pixel of every eighth row. VTK's ray
caster is vtkFixedPointVolumeRayCastMapper; its surfaces are drawn by OpenGL on the processor, with
depth peeling. Started by `scripts/bench_render`.
"""

import argparse
import datetime
import os
import statistics
import sys
import tempfile
from pathlib import Path

import numpy as np
from kit import bench_machine
from kit import bench_render_reference as reference
from kit.bench_goal import Goal
from kit.bench_volumes import Absent, Store, Volume
from kit.bench_worker import Failed, Worker
from kit.data import as_json
from kit.program import PROJECT

DRIVER = PROJECT / "target/release/examples/bench_render"
FINE = 16
VALUES, ERRORS = Goal(1.5, aim=4.0), Goal(1 / 3, at_least=False)
"""Values at 512²: how many times faster than VTK's, and how large their errors beside VTK's."""
SURFACES, SKIPS = Goal(2.0, aim=5.0), Goal(5.0)
"""Three surfaces: times faster than VTK's; leaps and an early end: than without."""
SCENES = {
    "bonsai": [[30, 0.5, 0.3, 0.1, 0.0], [60, 0.3, 0.6, 0.1, 0.1], [255, 1.0, 0.9, 0.8, 0.8]],
    "MNI152": [[30, 0.7, 0.4, 0.3, 0.0], [90, 0.8, 0.6, 0.4, 0.06], [200, 1.0, 1.0, 0.9, 0.5]],
}
"""Transfer functions: value, red, green, blue, and opacity over one spacing."""
HEAD = [
    {"iso": -300, "color": [0.68, 0.38, 0.22], "opacity": 0.3},
    {"iso": 150, "color": [0.6, 0.2, 0.15], "opacity": 0.4},
    {"iso": 400, "color": [0.8, 0.72, 0.53], "opacity": 1.0},
]


def view_of(volume: Volume, size: int, threads: int, lit: bool = True) -> dict:
    """From the front, a little aside and above; all of it is in the picture."""
    middle = [(n - 1) / 2 for n in volume.dims]
    away = 1.9 * float(np.linalg.norm(volume.dims)) / 2
    direction = np.array([0.5, -1.0, 0.4])
    place = np.array(middle) + 2 * away * direction / np.linalg.norm(direction)
    return {
        "threads": threads,
        "from": [float(c) for c in place],
        "at": middle,
        "up": [0.0, 0.0, 1.0],
        "fov": 30.0,
        "size": [size, size],
        "lit": lit,
        "points": 1,
    }


class Own:
    """isokit, in a process of its own."""

    def __init__(self, volume: Volume) -> None:
        """With a volume in memory."""
        self.worker = Worker([str(DRIVER)])
        request = volume.request()
        del request["iso"]
        self.worker.ask(request)

    def cast(self, view: dict, transfer: list, step: float, **more: object) -> dict:
        """The picture of values."""
        cast = {"transfer": transfer, "step": step, "leap": True, "opaque": None} | more
        return self.worker.ask({"op": "cast", "view": view, "cast": cast})

    def draw(self, view: dict, surfaces: list[dict], rays: bool = False) -> dict:
        """The picture of surfaces."""
        return self.worker.ask({"op": "draw", "view": view, "surfaces": surfaces, "rays": rays})

    def picture(self, ask, view: dict, *words: object, **more: object) -> np.ndarray:
        """The colours of such a picture, before black."""
        with tempfile.NamedTemporaryFile() as file:
            ask(view | {"out": file.name}, *words, **more)
            parts = np.fromfile(file.name, np.float32)
        width, height = view["size"]
        return parts.reshape(height, width, 4).astype(np.float64)[:, :, :3]


def rms(one: np.ndarray, other: np.ndarray) -> float:
    """Of the differences."""
    return float(np.sqrt(np.mean((one - other) ** 2)))


def eight_bits(picture: np.ndarray) -> np.ndarray:
    """Rounded as VTK's pictures are."""
    return np.rint(np.clip(picture, 0, 1) * 255) / 255


def interleaved(rounds: int, *contenders) -> list[float]:
    """The median of each one's seconds; the first round warms up."""
    seconds = [[] for _ in contenders]
    for n in range(rounds + 1):
        for contender, times in zip(contenders, seconds, strict=True):
            time = contender()
            if n:
                times.append(time)
    return [statistics.median(times) for times in seconds]


def values(store: Store, rounds: int, size: int, threads: int) -> list[dict]:
    """Ray casting of real volumes, lit and not, against VTK's on the processor."""
    from kit.bench_render_vtk import Caster

    rows = []
    volumes = [
        store.nifti("bonsai", "volvis/bonsai.nii.gz", 37.5),
        store.nifti("MNI152", "nifti/mni152_t1_1mm.nii.gz", 60.5),
    ]
    for volume in volumes:
        transfer, own, field = SCENES[volume.name], Own(volume), reference.Field(volume)
        for lit in (True, False):
            view = view_of(volume, size, threads, lit)
            exact = reference.picture(field, view, transfer)
            few = np.s_[:: reference.EVERY, :: reference.EVERY]
            for step in (1.0, 0.5):
                theirs = Caster(volume, view, transfer, step)
                ours_s, integrated_s, cubic_s, theirs_s = interleaved(
                    rounds,
                    lambda: own.cast(view, transfer, step)["seconds"],
                    lambda: own.cast(view, transfer, step, integrated=True)["seconds"],
                    lambda: own.cast(view, transfer, step, cubic=True)["seconds"],
                    theirs.seconds,
                )
                fine = Caster(volume, view, transfer, step / FINE)
                fine.seconds()
                theirs_fine = fine.picture()
                ours_fine = own.picture(own.cast, view, transfer, step / FINE)
                ours = eight_bits(own.picture(own.cast, view, transfer, step))
                integrated = own.picture(own.cast, view, transfer, step, integrated=True)
                faster = theirs_s / ours_s
                errors = [rms(picture[few], exact) for picture in (ours, theirs.picture())]
                rows.append(
                    {
                        "what": f"{volume.name} {size}², {'' if lit else 'not '}lit, step {step:g}",
                        "isokit ms": 1e3 * ours_s,
                        "VTK ms": 1e3 * theirs_s,
                        "times faster": faster,
                        **VALUES.cells(faster),
                        "isokit error": rms(ours, ours_fine),
                        "VTK error": rms(theirs.picture(), theirs_fine),
                        "integrated ms": 1e3 * integrated_s,
                        "integrated error": rms(eight_bits(integrated), ours_fine),
                        "cubic ms": 1e3 * cubic_s,
                        "isokit error by the books": errors[0],
                        "VTK error by the books": errors[1],
                        **ERRORS.cells(errors[0] / errors[1], "error "),
                    }
                )
                say(rows[-1])
        own.worker.close()
    return rows


def surfaces(store: Store, rounds: int, size: int, threads: int) -> list[dict]:
    """Three isosurfaces of a head, two of them translucent, meshes in memory."""
    from kit.bench_render_vtk import Drawer

    volume = store.ct_head(400.5)
    own, view = Own(volume), view_of(volume, size, threads)
    theirs = Drawer(volume, view, HEAD)
    smooth = view | {"points": 4}
    ours_s, smooth_s, rays_s, theirs_s = interleaved(
        rounds,
        lambda: own.draw(view, HEAD)["seconds"],
        lambda: own.draw(smooth, HEAD)["seconds"],
        lambda: own.draw(view, HEAD, rays=True)["seconds"],
        theirs.seconds,
    )
    difference = rms(eight_bits(own.picture(own.draw, view, HEAD)), theirs.picture())
    own.worker.close()
    rows = []
    all_seconds = (ours_s, smooth_s, rays_s)
    hows = ("", ", four points a pixel", ", by rays without a mesh")
    for how, seconds in zip(hows, all_seconds, strict=True):
        rows.append(
            {
                "what": f"CT head {size}², three surfaces{how}",
                "isokit ms": 1e3 * seconds,
                "VTK ms": 1e3 * theirs_s,
                "times faster": theirs_s / seconds,
                **({} if how else SURFACES.cells(theirs_s / seconds)),
                "difference of pictures": difference if not how else "",
            }
        )
        say(rows[-1])
    return rows


def whole(answer: dict) -> float:
    """The seconds of a picture and of what was made ready for it."""
    return answer["before"] + answer["seconds"]


def skipped(store: Store, rounds: int, size: int, threads: int) -> list[dict]:
    """What leaps, an early end and fewer samples are worth, and a plane that cuts."""
    rows = []
    volume = store.nifti("bonsai", "volvis/bonsai.nii.gz", 37.5)
    own, view = Own(volume), view_of(volume, size, threads)
    transfer = [[90, 0.3, 0.6, 0.1, 0.0], [130, 1.0, 0.9, 0.8, 0.9], [255, 1.0, 0.9, 0.8, 1.0]]
    on, off = (
        lambda: whole(own.cast(view, transfer, 0.5)),
        lambda: whole(own.cast(view, transfer, 0.5, leap=False, opaque=2.0)),
    )
    on_s, off_s = interleaved(rounds, on, off)
    with_skips = own.picture(own.cast, view, transfer, 0.5)
    without = own.picture(own.cast, view, transfer, 0.5, leap=False, opaque=2.0)
    rows.append(
        {
            "what": f"bonsai's densest {size}²: leaps and early end",
            "with ms": 1e3 * on_s,
            "without ms": 1e3 * off_s,
            "times faster": off_s / on_s,
            **SKIPS.cells(off_s / on_s),
            "greatest difference": float(np.abs(with_skips - without).max()),
        }
    )
    say(rows[-1])
    transfer = SCENES["bonsai"]
    for share in (1.0, 0.75, 0.5, 0.25):
        # In fog nothing hides what is behind it: what is left is what is computed.
        thin = [[*point[:4], 0.02 * point[4]] for point in transfer]
        clips = [[1.0, 0.0, 0.0, share * (volume.dims[0] - 1)]]
        cut = view | {"clips": clips}
        (seconds,) = interleaved(rounds, lambda: own.cast(cut, thin, 0.5, leap=False)["seconds"])
        steps = own.cast(cut, thin, 0.5, leap=False)["work"]
        rows.append(
            {
                "what": f"bonsai {size}² as thin fog, {share:.0%} of it left by a plane",
                "with ms": 1e3 * seconds,
                "steps": steps,
            }
        )
        say(rows[-1])
    for pixels in (size, size // 4, size // 8):
        small = view_of(volume, pixels, threads)
        few, every = (
            lambda small=small: own.cast(small, transfer, 0.5, lod=True)["seconds"],
            lambda small=small: own.cast(small, transfer, 0.5)["seconds"],
        )
        few_s, every_s = interleaved(rounds, few, every)
        pictures = [own.picture(own.cast, small, transfer, 0.5, lod=lod) for lod in (True, False)]
        rows.append(
            {
                "what": f"bonsai {pixels}², no more samples than pixels show",
                "with ms": 1e3 * few_s,
                "without ms": 1e3 * every_s,
                "times faster": every_s / few_s,
                "root mean square difference": rms(*pictures),
            }
        )
        say(rows[-1])
    own.worker.close()
    return rows


PARTS = {"values": values, "surfaces": surfaces, "skipped": skipped}


def say(row: dict) -> None:
    """One line for who waits."""
    cells = [f"{key} {cell(value)}" for key, value in row.items() if key != "what"]
    print(" · ".join([row["what"], *cells]), flush=True)


def cell(value: object) -> str:
    """A figure for people."""
    if isinstance(value, float) and value < 1000:
        return f"{value:.3g}"
    return f"{value:,.0f}" if isinstance(value, int | float) else str(value)


def table(rows: list[dict]) -> list[str]:
    """Markdown."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = ["| " + " | ".join(names) + " |", "| --- |" + " ---: |" * (len(names) - 1)]
    cells = [[cell(row.get(name, "")) for name in names] for row in rows]
    return lines + [f"| {' | '.join(row)} |" for row in cells]


def report(data: dict) -> str:
    """For people."""
    facts = data["machine"]
    lines = [
        f"# Pictures, {data['date']}",
        "",
        f"Printed by `scripts/bench_render`, isokit {data['versions']['isokit']}, "
        f"VTK {data['versions'].get('vtk', '?')}, on {facts['cpu']}, {data['threads']} threads, "
        f"{data['rounds']} rounds. "
        + " ".join((__doc__ or "").split("\n\n")[1].split()),
        "",
    ]
    for name, rows in data["parts"].items():
        lines += [f"## {(PARTS[name].__doc__ or '').rstrip('.')}", "", *table(rows), ""]
    lines += [f"Not measured: {line}" for line in data["skipped"]]
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    """Measures and writes."""
    parser = argparse.ArgumentParser(
        prog="scripts/bench_render",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    quick = "small pictures, few rounds: whether it works"
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--only", action="append", choices=PARTS, help="a part; repeat it")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--data", type=Path, default=PROJECT.parent / "shared/data")
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument("--load", type=float, default=0.0, help=argparse.SUPPRESS)
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    # Before OpenGL begins: its threads besides the one that asks.
    os.environ["LP_NUM_THREADS"] = str(arguments.threads)
    rounds, sizes = (2, (128, 256)) if arguments.quick else (arguments.rounds, (512, 1024))
    warning = bench_machine.busy(arguments.load)
    if warning:
        print(warning, file=sys.stderr)
    parts, missing = {}, []
    with tempfile.TemporaryDirectory() as scratch:
        store = Store(Path(scratch), arguments.data)
        for name, part in PARTS.items():
            if arguments.only and name not in arguments.only:
                continue
            try:
                parts[name] = part(store, rounds, sizes[name == "surfaces"], arguments.threads)
            except (Absent, Failed, ImportError) as why:
                missing.append(f"{name}: {why}")
                print(f"skip {missing[-1]}", flush=True)
    facts, date = bench_machine.facts(), datetime.date.today().isoformat()
    folder = PROJECT / f"scripts/results/{date}-{bench_machine.short(str(facts['cpu']))}/render"
    if arguments.out:
        folder = arguments.base / arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    data = {"schema": "isokit.bench-render/1", "date": date, "versions": bench_machine.versions()}
    data |= {"machine": facts, "warning": warning, "threads": arguments.threads, "rounds": rounds}
    data |= {"parts": parts, "skipped": missing}
    (folder / "results.json").write_text(as_json(data))
    (folder / "results.md").write_text(report(data))
    print(f"wrote {folder}/results.md")
    return 0 if parts else 2


if __name__ == "__main__":
    sys.exit(main())
