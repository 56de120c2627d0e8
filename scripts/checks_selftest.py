#!/usr/bin/env python3
"""Shows that the check scripts can fail: each is given sound and spoilt input.

A check that passes whatever it is given proves nothing, so every claim that a check script makes
about a mesh is made here about a mesh of which it is false.
"""

import argparse
import copy
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh

import check_data
from check_mesh import check_file
from check_ties import mesh_faults
from kit import colored
from kit.manifest import Facts
from kit.program import PROJECT, Failed
from kit.spoilt import (
    SPOILT,
    UNIT,
    holed,
    inside_out,
    report_of,
    sphere,
    split,
    write,
    write_colored,
)
from kit.surface import euler
from kit.tally import Record, Tally
from kit.units import file_unit

FORMATS = (".glb", ".obj", ".ply", ".stl")
COLOURS = {"skin": "#d8a58080", "bone": "#e8dcc0ff"}


def failing(path: Path, report: dict | None = None, open_border: bool = False) -> set[str]:
    """The claims of check_mesh that do not hold for a file."""
    record = Record()
    check_file(record, path, open_border, report)
    return {claim for _, claim, holds, _ in record.claims if not holds}


def test_check_mesh(tally: Tally, folder: Path) -> None:
    """Sound files pass with every reader, spoilt ones fail where they are spoilt."""
    report = report_of({"ball": sphere()})
    for suffix in FORMATS:
        found = failing(write(folder / f"sound{suffix}", sphere()), report)
        tally.check(f"sound{suffix}", "nothing fails", not found, found)
    for spoil, expected in SPOILT.items():
        found = failing(write(folder / f"{spoil.__name__}.ply", spoil()))
        tally.check(spoil.__name__, "fails where it is spoilt", expected <= found, found)
    found = failing(folder / "holed.ply", open_border=True)
    tally.check("holed", "may be open if that is allowed", not found, found)
    found = failing(folder / "absent.ply")
    tally.check("absent", "fails to load", "trimesh: loads" in found, found)
    cut = folder / "cut.stl"
    cut.write_bytes((folder / "sound.stl").read_bytes()[:-25])
    found = failing(cut)
    tally.check("cut", "fails to load", bool(found & {"trimesh: loads", "MeshLab: loads"}), found)


def test_report(tally: Tally, folder: Path) -> None:
    """Every number of the report is compared, and places are compared in the volume's world."""
    path = write(folder / "reported.ply", sphere())
    sound = report_of({"ball": sphere()})
    for key in ("vertices", "triangles", "area", "volume", "bounds"):
        wrong = copy.deepcopy(sound)
        value = wrong["surfaces"][0][key]
        wrong["surfaces"][0][key] = (np.asarray(value) * 1.01 + 1).tolist()
        found = failing(path, wrong)
        tally.check(f"wrong {key}", "fails alone", found == {f"report: {key}"}, found)
    two = report_of({"ball": sphere(), "other": sphere()})
    found = failing(path, two)
    tally.check("missing surface", "fails", "report: as many surfaces" in found, found)
    found = failing(write(folder / "z_up.obj", sphere(), y_up=False), sound)
    tally.check("z up in OBJ", "fails by place alone", found == {"report: bounds"}, found)
    found = failing(write(folder / "unscaled.glb", sphere(), unit="m"), sound)
    places = {f"report: {key}" for key in ("area", "volume", "bounds")}
    tally.check("millimetres in GLB", "fail by size", found == places, found)


def test_colored(tally: Tally, folder: Path) -> None:
    """Values and colours of vertices are compared, and missed."""
    values = {"trimesh: values", "MeshLab: values"}
    colours = {"trimesh: colours", "MeshLab: colours"}
    for suffix, spoil, expected in (
        (".ply", "", set()),
        (".glb", "", set()),
        (".obj", "", set()),
        (".ply", "values", values),
        (".ply", "valueless", values),
        (".ply", "colours", colours),
        (".ply", "colourless", colours),
        (".obj", "colours", colours),
        (".obj", "colourless", colours),
        (".glb", "values", {"trimesh: values"}),
        (".glb", "encoded", {"trimesh: colours"}),
    ):
        record = Record()
        colored.check_carried(record, write_colored(folder / f"colored{suffix}", spoil))
        found = {claim for _, claim, holds, _ in record.claims if not holds}
        subject = f"colored{suffix} {spoil}".strip()
        tally.check(subject, "fails where it is spoilt", found == expected, found)


def test_ties_and_data(tally: Tally) -> None:
    """The parts of the other scripts that decide."""
    flat = sphere()
    flat.vertices[flat.faces[0, 0]] = flat.vertices[flat.faces[0, 1]]
    tally.check("check_ties", "a sound mesh has no fault", not mesh_faults(sphere(), ""))
    for name, mesh in (("hole", holed()), ("flat triangles", flat), ("inside out", inside_out())):
        tally.check("check_ties", f"sees {name}", bool(mesh_faults(mesh, "")))
    tally.check("check_ties", "lets an open one end", not mesh_faults(holed(), "", is_open=True))
    tally.check("check_ties", "but be flat nowhere", bool(mesh_faults(flat, "", is_open=True)))
    points = np.random.default_rng(0).normal(0, 50, (500, 3)).astype(np.float32)
    moved = points.copy()
    ulp = np.spacing(np.abs(points).max())
    moved[3, 1] += ulp / 2
    tally.check("check_data", "an ulp is near", check_data.unmatched(moved[::-1], points) == 0)
    moved[3, 1] += 4 * ulp
    tally.check("check_data", "five are not", check_data.unmatched(moved, points) == 1)
    moved[3] = moved[4]
    tally.check("check_data", "one point for two is not", check_data.unmatched(moved, points) > 0)
    tally.check("check_data", "a sphere has characteristic 2", euler(sphere()) == 2)
    test_facts(tally)


class Spoken:
    """An isokit that says one thing about every volume."""

    def __init__(self, info: dict | None) -> None:
        """Says nothing, and fails, for none."""
        self.info = info

    def json(self, *_arguments: object) -> dict:
        """What it says."""
        if self.info is None:
            raise Failed("exit 1")
        return self.info


def test_facts(tally: Tally) -> None:
    """Facts about a volume are compared one by one."""
    facts = Facts("some.nii", (4, 5, 6), "i16", (-10, 300), (1.0, 1.0, 2.5))
    sound = {"dims": [4, 5, 6], "dtype": "i16", "range": [-10, 300], "spacing": [1, 1, 2.5]}
    wrong = {"dims": [6, 5, 4], "dtype": "u16", "range": [-9, 300], "spacing": [1, 1, 1]}
    for spoilt in (None, *wrong):
        info = sound | ({spoilt: wrong[spoilt]} if spoilt else {})
        record = Record()
        check_data.check_facts(record, Spoken(info), Path(), facts)
        found = {claim for _, claim, holds, _ in record.claims if not holds}
        expected = {spoilt} if spoilt else set()
        tally.check("check_data", f"facts with {spoilt} wrong", found == expected, found)
    record = Record()
    check_data.check_facts(record, Spoken(None), Path(), facts)
    tally.check("check_data", "a volume that does not open fails", not record.claims[0][2])


def outcome(*command: object) -> tuple[int, str]:
    """Exit code and failed lines of a script in another interpreter."""
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    lines = [line[5:] for line in done.stdout.splitlines() if line.startswith("FAIL ")]
    return done.returncode, "; ".join(lines) or done.stderr[-300:]


def test_blender(tally: Tally, folder: Path) -> None:
    """Blender agrees about sound files and disagrees about spoilt ones."""
    script = PROJECT / "scripts/check_blender.py"
    report = folder / "ball.json"
    report.write_text(json.dumps(report_of({"ball": sphere()})))
    sound = [write(folder / f"ball{suffix}", sphere()) for suffix in FORMATS]
    code, failed = outcome(sys.executable, script, "--report", report, *sound)
    tally.check("check_blender", "sound files pass", code == 0, failed)
    spoilt = {
        "Blender: bounds of the report": write(folder / "turned.obj", sphere(), y_up=False),
        "Blender: same place": write(folder / "large.glb", sphere(), unit="m"),
        "Blender: outside is out": write(folder / "inside_out.ply", inside_out()),
        "Blender: triangles": write(folder / "holed.obj", holed()),
        "Blender: vertices": write(folder / "split.ply", split()),
        "Blender: same normals": bent_normals(folder / "bent.ply"),
    }
    for claim, path in spoilt.items():
        code, failed = outcome(sys.executable, script, "--report", report, sound[2], path)
        tally.check(path.name, f"fails: {claim}", code == 1 and claim in failed, failed)
    test_materials(tally, folder, script)
    test_carried(tally, folder, script)


def bent_normals(path: Path) -> Path:
    """The sphere with normals that are not its own."""
    mesh = sphere()
    bent = trimesh.Trimesh(
        mesh.vertices, mesh.faces, vertex_normals=mesh.vertex_normals + (0.3, 0, 0), process=False
    )
    bent.export(path, vertex_normal=True)
    return path


def test_materials(tally: Tally, folder: Path, script: Path) -> None:
    """Names, alpha and colour of materials are compared."""
    meshes = {"skin": sphere(), "bone": sphere().apply_scale(0.5)}
    report = folder / "two.json"
    report.write_text(json.dumps(report_of(meshes)))
    sound = write_two(folder / "two.glb", meshes, COLOURS)
    wanted = [f"--material={name}:{colour}" for name, colour in COLOURS.items()]
    code, failed = outcome(sys.executable, script, "--report", report, *wanted, sound)
    tally.check("two.glb", "sound materials pass", code == 0, failed)
    for claim, colours in {
        "Blender: alpha": COLOURS | {"skin": "#d8a580ff"},
        "Blender: colour": COLOURS | {"bone": "#e80000ff"},
        "Blender: blended only if translucent": COLOURS | {"skin": "#d8a580ff"},
    }.items():
        path = write_two(folder / "spoilt.glb", meshes, colours)
        code, failed = outcome(sys.executable, script, "--report", report, *wanted, path)
        tally.check("spoilt.glb", f"fails: {claim}", code == 1 and claim in failed, failed)


def test_carried(tally: Tally, folder: Path, script: Path) -> None:
    """Values and colours are missed, and compared with the report and the first file."""
    sound = [write_colored(folder / f"colored{suffix}") for suffix in (".ply", ".obj")]
    mesh = trimesh.load_mesh(sound[0], process=False)
    values = colored.field_at(mesh.vertices)
    ends = [float(values.min()), float(values.max())]
    stated = {"attribute": {"range": ends}, "colormap": {}}
    report = folder / "colored.json"
    report.write_text(json.dumps(report_of({"ball": mesh}) | {"vertex_colors": stated}))
    code, failed = outcome(sys.executable, script, "--report", report, *sound)
    tally.check("colored", "sound files pass", code == 0, failed)
    for spoil, claim in {
        "valueless": "Blender: vertices have values",
        "values": "Blender: values of the report",
        "colourless": "Blender: vertices have colours",
        "colours": "Blender: same colours",
    }.items():
        path = write_colored(folder / f"spoilt_{spoil}.ply", spoil)
        code, failed = outcome(sys.executable, script, "--report", report, sound[0], path)
        tally.check(path.name, f"fails: {claim}", code == 1 and claim in failed, failed)


def write_two(path: Path, meshes: dict[str, trimesh.Trimesh], colours: dict[str, str]) -> Path:
    """Several surfaces in one GLB, each with its name and its material."""
    scene = trimesh.Scene()
    for name, mesh in meshes.items():
        mesh = mesh.copy()
        mesh.vertices = mesh.vertices[:, [0, 2, 1]] * (1, 1, -1) * file_unit(".glb", UNIT)
        mesh.visual = trimesh.visual.TextureVisuals(material=material(name, colours[name]))
        _ = mesh.vertex_normals
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    scene.export(path)
    return path


def material(name: str, colour: str) -> trimesh.visual.material.PBRMaterial:
    """A glTF material, whose factors are linear, of an sRGB colour."""
    *encoded, alpha = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5, 7))
    linear = [((value + 0.055) / 1.055) ** 2.4 for value in encoded]
    return trimesh.visual.material.PBRMaterial(
        name=name,
        baseColorFactor=np.array([*linear, alpha]),
        alphaMode="BLEND" if alpha < 1 else "OPAQUE",
    )


def test_validator(tally: Tally, folder: Path) -> None:
    """A GLB whose bounds are wrong, one that is cut, one that is none, one that only warns."""
    script = PROJECT / "scripts/validate_gltf.mjs"
    sound = write(folder / "valid.glb", sphere())
    data = sound.read_bytes()
    names = ("lying", "cut", "foreign", "padded")
    lying, cut, foreign, padded = (folder / f"{name}.glb" for name in names)
    at = data.index(b'"max":[') + len(b'"max":[')
    lying.write_bytes(data[:at] + b"9" + data[at + 1 :])
    cut.write_bytes(data[:-100])
    foreign.write_text("solid\n")
    padded.write_bytes(lengthened(data))
    tally.check("valid.glb", "passes", outcome("node", script, sound)[0] == 0)
    for path in (lying, cut, foreign, padded):
        code, failed = outcome("node", script, sound, path)
        tally.check(path.name, "fails", code == 1 and path.name in failed, failed)


def lengthened(data: bytes) -> bytes:
    """A GLB whose last chunk is longer than the buffer in it: a warning, not an error."""
    words = np.frombuffer(data, dtype="<u4").copy()
    binary = 5 + words[3] // 4
    words[[2, binary]] += 8
    return words.tobytes() + bytes(8)


def main() -> int:
    """Tries the check scripts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--importers", action="store_true", help="also the checks with Blender and the validator"
    )
    arguments = parser.parse_args()
    tally = Tally("checks_selftest")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        test_check_mesh(tally, folder)
        test_report(tally, folder)
        test_colored(tally, folder)
        test_ties_and_data(tally)
        if arguments.importers:
            test_blender(tally, folder)
            test_validator(tally, folder)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
