#!/usr/bin/env python3
"""Extracts every fixture volume in every mesh format and checks what was written.

Each volume is closed by default, so each file must be watertight for every reader and agree with
its report; with an open border the same surfaces may have an edge but must still be two-manifold.
The head phantom is also written with two surfaces, skin and bone, for the checks of names and
materials. A ball has vertices with values and colours. The meshes stay in the folder that is named, for Blender and the glTF validator.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

from check_mesh import check_file
from kit.colored import check_colored
from kit.program import PROJECT, Failed, Isokit
from kit.tally import Tally

FORMATS = (".glb", ".gltf", ".obj", ".ply", ".stl")
SEVERAL = (".glb", ".gltf", ".obj")
"""Formats that hold several surfaces in one file."""

SKIN_AND_BONE = ("-300:skin:#d8a58080", "300:bone:#e8dcc0")


@dataclass(frozen=True)
class Case:
    """One extraction."""

    name: str
    volume: Path
    isos: tuple[str, ...]
    formats: tuple[str, ...] = FORMATS


def cases(fixtures: Path) -> list[Case]:
    """The extractions to make: every volume once, the head phantom also with two surfaces."""
    found = []
    for volume in sorted(path for path in fixtures.iterdir() if path.is_file()):
        stem = volume.name.split(".")[0]
        if "head" in stem:
            found.append(Case("head", volume, ("300",)))
            found.append(Case("head_two", volume, SKIN_AND_BONE, SEVERAL))
        else:
            found.append(Case(stem, volume, ("auto",)))
    return found


def check_case(tally: Tally, isokit: Isokit, folder: Path, case: Case) -> None:
    """One volume in all its formats, closed, and once open."""
    isos = [word for iso in case.isos for word in ("--iso", iso)]
    for suffix in case.formats:
        path = folder / f"{case.name}{suffix}"
        if check_extraction(tally, isokit, case.volume, path, isos):
            verdict = isokit.run("check", path)
            sound = verdict.returncode == 0
            tally.check(path.name, "isokit: check", sound, f"exit {verdict.returncode}")
    if len(case.isos) == 1:
        path = folder / f"{case.name}_open.ply"
        check_extraction(tally, isokit, case.volume, path, [*isos, "--boundary", "open"])


def check_extraction(
    tally: Tally, isokit: Isokit, volume: Path, path: Path, options: list[str]
) -> bool:
    """Writes one file and checks it; whether there is one."""
    try:
        report = isokit.extract(volume, path, *options)
    except Failed as failure:
        return tally.check(path.name, "extracts", False, failure)
    check_file(tally, path, "open" in options, report)
    return True


def main() -> int:
    """Extracts and checks all fixtures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("isokit", type=Path, help="the program to try")
    parser.add_argument("folder", type=Path, help="where the meshes go; made if absent")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    tally = Tally("check_fixtures")
    for case in cases(PROJECT / "fixtures/volumes"):
        check_case(tally, Isokit(arguments.isokit), arguments.folder, case)
    check_colored(tally, Isokit(arguments.isokit), arguments.folder)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
