#!/usr/bin/env python3
"""Extracts the fixtures with every set of vector instructions and compares the files.

`ISOKIT_SIMD` holds a process to one set; the report says whether the machine has it. Each fixture is
tried as it is and, converted by numpy, as samples of all eight types, with both borders, with vertices
on straight lines and on curves, by the table alone, with triangles that have no area, without what is
next to NaN, divided and balanced, on one thread and on two. The portable path's PLY is what all others
must be, byte for byte.
"""

import argparse
import os
import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

from kit.program import PROJECT, Isokit
from kit.tally import Tally

LEVELS = ("portable", "avx2", "avx512")
MODES = (
    ("--placement", "linear"),
    ("--placement", "cubic", "--normals", "matching"),
    ("--placement", "quintic"),
    ("--placement", "quintic", "--normals", "matching"),
    ("--topology", "table"),
    ("--degenerate", "exact"),
    ("--diagonals", "fitted"),
    ("--nan", "mask"),
    ("--refine", "1", "--balance"),
)
DTYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8")
FIXTURES = {"head.nii.gz": 90, "marschner_lobb.nrrd": 0.5, "part.mha": 100, "ties.npy": 0}


def volumes(folder: Path) -> list[tuple[Path, str]]:
    """The fixtures with their isovalues, and an uneven field in every type of sample."""
    found = [(PROJECT / "fixtures/volumes" / name, str(iso)) for name, iso in FIXTURES.items()]
    z, y, x = (np.arange(n) / 9 for n in (21, 37, 131))
    wave = np.sin(x) * np.cos(y)[:, None] + np.sin(y)[:, None] * np.cos(z)[:, None, None]
    for dtype in DTYPES:
        path = folder / f"{dtype}.npy"
        np.save(path, (60 + 30 * wave).astype(f"<{dtype}"))
        found.append((path, "60"))
    return found


def written(isokit: Isokit, volume: Path, iso: str, out: Path, level: str, *options: str) -> bytes:
    """The mesh as one level writes it; nothing where the machine has not got it."""
    os.environ["ISOKIT_SIMD"] = level
    report = isokit.extract(volume, out, "--iso", iso, *options)
    return out.read_bytes() if report["simd"] == level else b""


def main() -> int:
    """Compares all levels, volumes, borders and numbers of threads."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("isokit", type=Path, help="the program to try")
    isokit = Isokit(parser.parse_args().isokit)
    tally = Tally("check_levels", quiet=True)
    with tempfile.TemporaryDirectory() as name:
        out = Path(name, "out.ply")
        choices = product(volumes(Path(name)), ("closed", "open"), MODES)
        for (volume, iso), border, options in choices:
            mode = f"{border}, {' '.join(options)}"
            same = ("--boundary", border, *options)
            expected = written(isokit, volume, iso, out, "portable", *same, "--threads", "1")
            tally.check(volume.name, f"{mode}: has a surface", len(expected) > 1000)
            for level, threads in product(LEVELS, ("1", "2")):
                subject = f"{volume.name}, {mode}, {level}, {threads} threads"
                found = written(isokit, volume, iso, out, level, *same, "--threads", threads)
                if found:
                    tally.check(subject, "the same bytes", found == expected)
                else:
                    tally.skip(subject, "this machine has not got these instructions")
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
