#!/usr/bin/env python3
"""Tries isokit on real volumes by other people's programs, against their manifest.

Every volume opens with the dims, type and range that an independent reader found, or is refused
for a stated reason. Every reference isosurface has the table's triangles and points exactly and
its area within 1 %, and closed at the border it is watertight. One brain in its storage orders
gives one surface. No file that is broken on purpose makes the program crash.

The data is not part of the project: where its folder is absent this says so and passes.
"""

import argparse
import re
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from check_mesh import check_manifold, check_trimesh
from kit import manifest
from kit.manifest import Facts, Reference
from kit.program import PROJECT, Failed, Isokit
from kit.surface import euler, parts_of
from kit.tally import Record, Tally

REFUSED = {
    "nifti/analyze.hdr": r"img",
    "nifti/dtypes/int64.nii": r"\bi(nt)?64\b",
    "nifti/dtypes/uint64.nii": r"\bu(int)?64\b",
    "nrrd/pynrrd/BallBinary30x30x30_byteskip_minus_five.nhdr": r"byte skip|-5",
}
"""Files that must be refused, and what the message must name."""

READERS_DIFFER = {
    "nifti/pair/minimal2.hdr": (64, 64, 10),  # its image is compressed, the header is not
    "nifti/pair/minimal.img": (64, 64, 10),  # the half of a pair that has no header
    "nrrd/pynrrd/BallBinary30x30x30_nifti.nhdr": (30, 30, 30),  # teem reads it, pynrrd does not
}
"""Files that may be refused, but when opened must have these dims."""

COUNTERS = ("boundary_edges", "nonmanifold_edges", "degenerate_triangles")
ORIENT_ISO = 60


def check_facts(tally: Tally, isokit: Isokit, data: Path, facts: Facts) -> None:
    """A volume is what its line says. Of four dimensions isokit takes the first volume."""
    path = facts.path
    try:
        info = isokit.json("info", data / path, "--json", *manifest.raw_options(path))
    except Failed as failure:
        tally.check(path, "opens", False, failure)
        return
    dims = tuple(info["dims"])
    tally.check(path, "dims", dims == facts.dims[:3], f"{dims} of {facts.dims}")
    tally.check(path, "dtype", info["dtype"] == facts.dtype, f"{info['dtype']} of {facts.dtype}")
    low, high = info["range"]
    slack = 1e-4 * max(map(abs, facts.range))
    if len(facts.dims) > 3:  # the line's range is over all volumes
        fits = facts.range[0] - slack <= low <= high <= facts.range[1] + slack
    else:
        fits = max(abs(low - facts.range[0]), abs(high - facts.range[1])) <= slack
    tally.check(path, "range", fits, f"{low}..{high} of {facts.range[0]:g}..{facts.range[1]:g}")
    if facts.spacing:
        near = np.allclose(info["spacing"], facts.spacing[:3], rtol=1e-3)
        tally.check(path, "spacing", near, f"{info['spacing']} of {facts.spacing[:3]}")


def check_refused(tally: Tally, isokit: Isokit, data: Path) -> None:
    """What must not be read is refused by name; what is broken is refused without a crash."""
    for path, reason in REFUSED.items():
        done = isokit.run("info", data / path)
        named = done.returncode == 1 and re.search(reason, done.stderr)
        tally.check(path, "refused by name", named, done.stderr.strip()[-160:])
    for path, dims in READERS_DIFFER.items():
        done = isokit.run("info", data / path, "--json")
        opened = done.returncode == 0 and f"{list(dims)}" in re.sub(r"\s*\n\s*", " ", done.stdout)
        found = done.stderr.strip()[-160:] or "opened"
        fair = opened or done.returncode == 1
        tally.check(path, "opens with its dims, or is refused", fair, found)
    broken = [path for path in (data / "malformed").rglob("*") if path.is_file()]
    for path in sorted(broken):
        done = isokit.run("info", path)
        calm = done.returncode in (0, 1) and "panicked" not in done.stderr
        tally.check(str(path.relative_to(data)), "no crash", calm, f"exit {done.returncode}")


def reference_checks(isokit: Isokit, data: Path, folder: Path, line: Reference) -> Record:
    """One line of the reference table: open as the table has it, then closed."""
    record = Record()
    subject = f"{line.path} at {line.iso:g}"
    stem = re.sub(r"\W", "_", subject)
    common = ("--iso", f"{line.iso:g}", *manifest.raw_options(line.path))
    try:
        bare = folder / f"{stem}_open.ply"
        table_options = ("--topology", "table", "--boundary", "open", "--degenerate", "exact")
        table_options += ("--placement", "linear")
        report = isokit.extract(data / line.path, bare, *common, *table_options)
        check_table(record, subject, line, bare, report["surfaces"][0])
        bare.unlink()
        closed = folder / f"{stem}.ply"
        report = isokit.extract(data / line.path, closed, *common)
        check_closed(record, subject, closed, report["surfaces"][0])
        closed.unlink()
    except Failed as failure:
        record.check(subject, "extracts", False, failure)
    return record


def check_table(
    record: Record, subject: str, line: Reference, path: Path, surface: dict
) -> None:
    """The table's counts and area, by the file and by the report."""
    (part,) = parts_of(path)
    counts = {"triangles": len(part.mesh.faces), "points": len(part.mesh.vertices)}
    for key, count in counts.items():
        wanted = getattr(line, key)
        record.check(subject, key, count == wanted, f"{count} of {wanted}")
    reported = {"triangles": surface["triangles"], "points": surface["vertices"]}
    record.check(subject, "report counts the file", reported == counts, reported)
    sheared = "shear_gantry_tilt" in line.path
    area = manifest.SHEARED[line.iso] if sheared else line.area
    for where, value in (("area", part.mesh.area), ("area of the report", surface["area"])):
        near = abs(value - area) <= 0.01 * area
        record.check(subject, where, near, f"{value:.6g}, {100 * (value / area - 1):+.3f} %")


def check_closed(record: Record, subject: str, path: Path, surface: dict) -> None:
    """Closed by default: for trimesh, for manifold3d and by isokit's own counters."""
    (part,) = parts_of(path)
    check_trimesh(record, f"{subject}, closed", part, open_border=False)
    check_manifold(record, f"{subject}, closed", part)
    counters = {key: surface[key] for key in COUNTERS}
    record.check(f"{subject}, closed", "report: sound", not any(counters.values()), counters)


def check_orientations(tally: Tally, isokit: Isokit, data: Path, folder: Path) -> None:
    """The storage orders of one brain give one set of vertices and one Euler characteristic."""
    first: tuple[str, np.ndarray, int] | None = None
    for path in sorted((data / "nifti/orient").glob("*.nii.gz")):
        out = folder / f"orient_{path.name[:3]}.ply"
        try:
            isokit.extract(path, out, "--iso", ORIENT_ISO)
        except Failed as failure:
            tally.check(path.name, "extracts", False, failure)
            continue
        (part,) = parts_of(out)
        points, characteristic = np.asarray(part.mesh.vertices), euler(part.mesh)
        tally.check(path.name, "outside is out", part.mesh.volume > 0, f"{part.mesh.volume:.6g}")
        if first is None:
            first = (path.name, points, characteristic)
            continue
        name, others, expected = first
        apart = unmatched(points, others)
        tally.check(path.name, f"the vertices of {name}", apart == 0, f"{apart} elsewhere")
        same = characteristic == expected
        tally.check(path.name, f"Euler characteristic of {name}", same, characteristic)


def unmatched(points: np.ndarray, others: np.ndarray) -> int:
    """How many points of two sets have no partner within one ulp of f32 at the outermost coordinate.

    The headers hold their offsets as f32 and so differ by half an ulp of those; near zero that is many
    ulps of the coordinate itself.
    """
    if len(points) != len(others):
        return abs(len(points) - len(others))
    _, partner = cKDTree(others).query(points)
    taken = len(np.unique(partner))
    slack = np.spacing(np.float32(np.abs(others).max()))
    near = (np.abs(points - others[partner]) <= slack).all(axis=1)
    return len(points) - min(taken, int(near.sum()))


def check_all(tally: Tally, isokit: Isokit, data: Path) -> None:
    """Everything that the manifest promises about formats that isokit reads."""
    text = (data / "MANIFEST.md").read_text()
    volumes = [
        *manifest.volumes(text),
        *manifest.told_in_words(),
        *manifest.orientations(data),
    ]
    for facts in volumes:
        check_facts(tally, isokit, data, facts)
    check_refused(tally, isokit, data)
    known = {facts.path for facts in volumes} | REFUSED.keys() | READERS_DIFFER.keys()
    for path in sorted(str(path.relative_to(data)) for path in data.rglob("*")):
        if manifest.VOLUME.search(path) and path not in known and "malformed/" not in path:
            tally.skip(path, "the manifest has no facts about it")
    lines, foreign = manifest.references(text)
    print(f"note: {foreign} reference isosurfaces are in formats without a reader here")
    with tempfile.TemporaryDirectory() as name, ProcessPoolExecutor(2) as processes:
        folder = Path(name)
        for record in processes.map(partial(reference_checks, isokit, data, folder), lines):
            tally.replay(record)
        check_orientations(tally, isokit, data, folder)


def main() -> int:
    """Checks the program on the data, if it is there."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("isokit", type=Path, help="the program to try")
    parser.add_argument(
        "--data",
        type=Path,
        default=PROJECT.parent / "shared/data",
        help="the folder with MANIFEST.md; default: shared/data beside the project",
    )
    arguments = parser.parse_args()
    tally = Tally("check_data")
    if (arguments.data / "MANIFEST.md").exists():
        check_all(tally, Isokit(arguments.isokit), arguments.data)
    else:
        tally.skip("real volumes", f"there is no {arguments.data / 'MANIFEST.md'}")
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
