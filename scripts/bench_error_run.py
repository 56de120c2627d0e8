#!/usr/bin/env python3
"""Measures run time against error of isokit and its peers on surfaces that are known, with plots.

Started by `scripts/bench_error`, which installs the peers and builds isokit's driver. Each field is
sampled on lattices of several sizes; each tool makes its mesh once, which is compared with the
surface of the field, and is then timed in turn with the others. A mode that divides triangles takes
no part where it would make more than eight million: to compare those takes minutes.

The files go to scripts/results/DATE-CPU/error, those of a quick run to target/bench/error. Each
field has a file of its own there, and what is measured again replaces it: a long run can be made in
parts, by field and by size. Table and plots are of all that lies there. Exit 1 if a mode of isokit
failed, or if a figure of all that lies there is not what it must be and the run was a full one of all
sizes; others say so only, since their lattices are too coarse for some.
"""

import argparse
import datetime
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from kit import bench_error_output, bench_machine
from kit.bench_error_fields import FIELDS, POSITIONS, Field
from kit.bench_error_measure import errors, of_vertices, together
from kit.bench_error_offsets import best_by_offsets
from kit.bench_error_tools import MODES, OWN, divided, is_double, making, tools
from kit.bench_measure import quartiles
from kit.bench_volumes import NAMES, Volume
from kit.bench_worker import Failed
from kit.data import as_json
from kit.program import PROJECT

SIZES = {
    "quick": (16, 24, 32, 48, 64),
    "usual": (32, 48, 64, 96, 128),
    "full": (32, 64, 128, 256, 512),
}
BALANCED = f"{OWN} cubic"
"""The mode whose mesh is put beside the best that moving its vertices can make of it."""
ROUNDS = {"quick": 3, "usual": 7, "full": 15}
CLOUD = {"quick": 10_000, "usual": 20_000, "full": 100_000}
"""Points on the surface whose distance from the mesh is measured."""
MOST = 8_000_000
"""Triangles of a mode that divides them and takes part."""


def parse() -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(
        prog="scripts/bench_error",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only", action="append", choices=FIELDS, help="a field; repeat it; default: all"
    )
    parser.add_argument("--quick", action="store_true", help="16 to 64 samples per axis, 3 rounds")
    parser.add_argument(
        "--full",
        action="store_true",
        help="32 to 512 samples per axis, 15 rounds; orders in up to 768³, which is 3.6 GB",
    )
    parser.add_argument("--sizes", type=int, nargs="+", help="other numbers of samples per axis")
    parser.add_argument("--rounds", type=int, help="runs of each tool; default: 7; 3 with --quick, 15 with --full")
    parser.add_argument(
        "--dtype", choices=("float32", "float64"), default="float32", help="of the samples"
    )
    parser.add_argument(
        "--threads", type=int, default=1, help="for tools that can be told; default: 1"
    )
    parser.add_argument(
        "--mode",
        action="append",
        help="a mode of isokit in place of the usual ones, as 'cubic refine=1 balance'; repeat it",
    )
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument(
        "--busy", action="store_true", help="go on although the machine is; the table will say so"
    )
    parser.add_argument("--note", default="", help="a line for the table")
    parser.add_argument("--load", type=float, help=argparse.SUPPRESS)
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    try:
        for mode in arguments.mode or ():
            making(mode)
    except ValueError as error:
        parser.error(str(error))
    return arguments


class Run:
    """The settings of one run, and what it measures."""

    def __init__(self, arguments: argparse.Namespace, scratch: Path) -> None:
        """Starts nothing yet."""
        self.scale = "quick" if arguments.quick else "full" if arguments.full else "usual"
        self.sizes = arguments.sizes or SIZES[self.scale]
        self.rounds = arguments.rounds or ROUNDS[self.scale]
        self.dtype, self.threads = np.dtype(arguments.dtype), arguments.threads
        self.scratch = scratch
        self.modes = list(arguments.mode or MODES)
        self.absent = bench_machine.absent(PROJECT / ".venv-bench/absent")
        self.tools = tools(self.modes, self.absent, self.threads)
        self.failed = False

    def field(self, name: str) -> dict:
        """All sizes of one field."""
        field = FIELDS[name]()
        cloud = field.cloud(CLOUD[self.scale])
        points, best, skipped, sampling = [], [], [], {}
        for n in self.sizes:
            volumes, sampling[str(n)] = self._volumes(name, field, n)
            for tool, found in self._size(volumes, field, cloud, skipped).items():
                points.append({"n": n, "h": 2 / (n - 1), "tool": tool, **found})
            if BALANCED in self.tools and field.area:
                try:
                    mesh = self.tools[BALANCED].mesh(self.scratch / "mesh")
                except Failed:
                    pass  # which was said when it was measured
                else:
                    figures = errors(best_by_offsets(mesh, field), field, cloud, 2 / (n - 1))
                    best.append({"n": n, "h": 2 / (n - 1), **figures})
            for volume in volumes.values():
                volume.path.unlink(missing_ok=True)
        thickness = field.thickness if np.isfinite(field.thickness) else None
        return {
            "field": name,
            "smooth": field.smooth,
            "surface_rms": field.surface_rms,
            "diameter": float(np.ptp(cloud, axis=0).max()),
            "closed": field.closed,
            "thickness": thickness,
            "rounds": self.rounds,
            "dtype": self.dtype.name,
            "threads": self.threads,
            "cloud": len(cloud),
            "modes": self.modes,
            "absent": self.absent,
            "skipped": skipped,
            "sampling_s": sampling,
            "points": points,
            "order_points": self._order_points(name, field, cloud),
            "best_by_offsets": best,
        }

    def _order_points(self, name: str, field: Field, cloud: np.ndarray) -> list[dict]:
        """What orders are seen on beside what tools are timed on. Of a full run only.

        Only one process at a time holds samples: all of them together do not fit in 24 GB.
        """
        points: list[dict] = []
        if self.scale != "full" or not field.order_sizes:
            return points
        self.close()
        for n in field.order_sizes:
            found = {tool: [] for tool in filter(is_double, self.tools)}
            for position in POSITIONS:
                moved = tuple(2 / (n - 1) * part for part in position)
                path = self.scratch / f"{name}_{n}_moved.raw"
                field.sample(n, np.float64, moved).tofile(path)
                volume = Volume(f"{name} {n}", (n, n, n), NAMES["float64"], 0.0, path)
                for tool, parts in found.items():
                    self.tools[tool].take(volume)
                    mesh = self.tools[tool].mesh(self.scratch / "mesh")
                    self.tools[tool].close()
                    mesh.vertices += moved
                    parts.append(of_vertices(mesh, field, cloud))
                path.unlink()
            for tool, parts in found.items():
                figures = together(parts)
                points.append({"n": n, "h": 2 / (n - 1), "tool": tool, **figures})
                said = "vertices {vertex_rms:.2e}, normals {vertex_angle:.2e}°".format(**figures)
                print(f"{name + ' ' + str(n):20} {tool + ', moved':26} {said}", flush=True)
        return points

    def _volumes(self, name: str, field: Field, n: int) -> tuple[dict[bool, Volume], float]:
        """The samples as all tools get them, those as f64, and how long the first took to make."""
        volumes, seconds = {}, 0.0
        kinds = {False: self.dtype, True: np.dtype(np.float64)}
        for double, dtype in kinds.items():
            if double and not any(map(is_double, self.tools)):
                continue
            start = time.perf_counter()
            samples = field.sample(n, dtype)
            seconds = seconds or time.perf_counter() - start
            path = self.scratch / f"{name}_{n}_{dtype.name}.raw"
            samples.tofile(path)
            volumes[double] = Volume(f"{name} {n}", (n, n, n), NAMES[dtype.name], 0.0, path)
        return volumes, seconds

    def close(self) -> None:
        """Ends all processes; they start anew with the next samples they get."""
        for tool in self.tools.values():
            tool.close()

    def _size(
        self,
        volumes: dict[bool, Volume],
        field: Field,
        cloud: np.ndarray,
        skipped: list[str],
    ) -> dict[str, dict]:
        """All tools on one lattice: meshes first, then time, round by round."""
        found: dict[str, dict] = {}
        volume = volumes[False]

        def skip(name: str, failure: Failed) -> None:
            found.pop(name, None)
            skipped.append(f"{name}, {volume.name}: {failure}")
            print(f"skip {skipped[-1]}", flush=True)
            # A peer may fail, what is measured may not.
            self.failed |= name.startswith(OWN)

        n = volume.dims[0]
        for name, tool in self.tools.items():
            expected = divided(name, found)
            if expected > MOST:
                most = f"{expected:,} triangles, too many to compare"
                skipped.append(f"{name}, {volume.name}: {most}")
                continue
            try:
                tool.take(volumes[is_double(name)])
                mesh = tool.mesh(self.scratch / "mesh")
                found[name] = errors(mesh, field, cloud, 2 / (n - 1))
                found[name]["seconds"] = []
                show(volume.name, name, found[name])
            except Failed as failure:
                skip(name, failure)
        for _ in range(self.rounds):
            for name in list(found):
                try:
                    found[name]["seconds"].append(self.tools[name].seconds())
                except Failed as failure:
                    skip(name, failure)
        for figures in found.values():
            figures["quartiles"] = quartiles(figures["seconds"])
        return found


def show(volume: str, name: str, figures: dict) -> None:
    """One line while it goes on."""
    if "rms" in figures:
        said = "RMS {rms:.2e}, greatest {max:.2e}, {triangles} triangles".format(**figures)
        print(f"{volume:20} {name:26} {said} {', '.join(figures['faults'])}", flush=True)


def joined(old: dict, new: dict) -> dict:
    """A field's file with the sizes of an earlier run, if that is comparable and has others."""
    alike = ("schema", "date", "machine", "versions", "dtype", "threads", "rounds", "modes", "note")
    if any(old.get(key) != new[key] for key in alike):
        return new
    kept = [point for point in old["points"] if str(point["n"]) not in new["sampling_s"]]
    best = old["best_by_offsets"]
    kept_best = [point for point in best if str(point["n"]) not in new["sampling_s"]]
    sampling = old["sampling_s"] | new["sampling_s"]
    return new | {
        "points": sorted(kept + new["points"], key=lambda point: point["n"]),
        "best_by_offsets": sorted(kept_best + new["best_by_offsets"], key=lambda point: point["n"]),
        "sampling_s": dict(sorted(sampling.items(), key=lambda item: int(item[0]))),
        "loads": old["loads"] + new["loads"],
        "skipped": list(dict.fromkeys(old["skipped"] + new["skipped"])),
        "warning": old["warning"] or new["warning"],
    }


def main() -> int:
    """Measures and writes."""
    arguments = parse()
    load = bench_machine.load() if arguments.load is None else arguments.load
    warning = bench_machine.busy(load)
    if warning:
        warning = warning.replace("figures", "times")
        print(f"warning: {warning}", file=sys.stderr)
        if not arguments.busy:
            print("nothing is measured; --busy goes on all the same", file=sys.stderr)
            return 2
    date = datetime.date.today().isoformat()
    machine = bench_machine.facts()
    facts = {"schema": "isokit.bench-error/3", "date": date, "machine": machine}
    facts |= {"versions": bench_machine.versions(), "note": arguments.note, "warning": warning}
    folder = PROJECT / f"scripts/results/{date}-{bench_machine.short(machine['cpu'])}/error"
    if arguments.quick:
        folder = PROJECT / "target/bench/error"
    if arguments.out:
        folder = arguments.base / arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        run = Run(arguments, Path(scratch))
        try:
            for name in arguments.only or FIELDS:
                before = bench_machine.load()
                data = facts | run.field(name)
                data["loads"] = [[before, bench_machine.load()]]
                path = folder / f"{name}.json"
                if path.exists():
                    data = joined(json.loads(path.read_text()), data)
                path.write_text(as_json(data))
        finally:
            run.close()
    missed = bench_error_output.write(folder)
    print(f"wrote {folder}/results.md")
    for line in missed:
        print(f"not as it must be: {line}")
    is_judged = arguments.full and not arguments.sizes
    return int(run.failed or (is_judged and bool(missed)))


if __name__ == "__main__":
    sys.exit(main())
