#!/usr/bin/env python3
"""Puts mesh files through three programs that other people wrote.

trimesh says whether every edge has exactly two faces and whether their winding agrees; manifold3d
whether the surface bounds a solid, and its genus; MeshLab, with its own importer, whether the
surface is two-manifold and where its border is. They measure different things, so all three are
asked. With a report of `isokit extract`, counts, measures and bounds are compared with it too.
A file with several surfaces is checked surface by surface.
"""

import argparse
import json
import sys
from pathlib import Path

import manifold3d
import numpy as np
import pymeshlab

from kit.surface import Part, parts_of, to_world
from kit.tally import Tally

RELATIVE = 1e-4
"""Measures and bounds agree to this: the files hold f32, the report is computed from f64."""


def check_trimesh(tally: Tally, subject: str, part: Part, open_border: bool) -> None:
    """Closed, wound one way, and outside out."""
    mesh = part.mesh
    tally.check(subject, "trimesh: has triangles", len(mesh.faces) > 0, len(mesh.faces))
    tally.check(subject, "trimesh: finite", bool(np.isfinite(mesh.vertices).all()))
    tally.check(subject, "trimesh: winding is consistent", mesh.is_winding_consistent)
    if not open_border:
        tally.check(subject, "trimesh: watertight", mesh.is_watertight)
        tally.check(subject, "trimesh: volume > 0", mesh.volume > 0, f"{mesh.volume:.6g}")


def check_manifold(tally: Tally, subject: str, part: Part) -> None:
    """Bounds a solid. An open surface bounds none, so this is for closed ones only."""
    solid = manifold3d.Manifold(
        manifold3d.Mesh(
            vert_properties=np.asarray(part.mesh.vertices, dtype=np.float32),
            tri_verts=np.asarray(part.mesh.faces, dtype=np.uint32),
        )
    )
    status = solid.status()
    sound = status == manifold3d.Error.NoError
    found = f"genus {solid.genus()}" if sound else status.name
    tally.check(subject, "manifold3d: NoError", sound, found)


def check_meshlab(tally: Tally, path: Path, open_border: bool) -> None:
    """Two-manifold for MeshLab, whose layers are the surfaces of the file."""
    layers = pymeshlab.MeshSet(verbose=False)
    try:
        layers.load_new_mesh(str(path))
    except pymeshlab.PyMeshLabException as error:
        tally.check(path.name, "MeshLab: loads", False, error)
        return
    for layer in layers:
        layers.set_current_mesh(layer.id())
        found = layers.get_topological_measures()
        subject = f"{path.name} [{layer.label()}]"
        two_manifold = found["is_mesh_two_manifold"]
        tally.check(subject, "MeshLab: two-manifold", two_manifold)
        unused = found["unreferenced_vertices"]
        tally.check(subject, "MeshLab: no unused vertices", unused == 0, unused)
        if not open_border:
            border = found["boundary_edges"]
            tally.check(subject, "MeshLab: no boundary edges", border == 0, border)


def check_report(tally: Tally, path: Path, parts: list[Part], report: dict) -> None:
    """Every surface of the report is in the file, and is what the report says."""
    tally.check(path.name, "report: schema", report.get("schema") == "isokit.extract/1")
    surfaces = [surface for surface in report["surfaces"] if surface["triangles"] > 0]
    if len(parts) == 1 and len(surfaces) > 1:  # one of the files named after their surfaces
        surfaces = [surface for surface in surfaces if surface["name"] in path.stem]
    agree = len(surfaces) == len(parts)
    if not tally.check(path.name, "report: as many surfaces", agree, len(parts)):
        return
    for surface in surfaces:
        named = sorted(
            (part for part in parts if surface["name"] in part.name),
            key=lambda part: len(part.name),  # "bone" before "bone_marrow"
        )
        part = named[0] if named else parts[0]
        if len(parts) > 1 and not tally.check(
            path.name, f"report: has a surface named {surface['name']}", bool(named)
        ):
            continue
        subject = f"{path.name} [{surface['name']}]"
        compare(tally, subject, path, part, surface, report["input"].get("unit"))


def compare(
    tally: Tally, subject: str, path: Path, part: Part, surface: dict, unit: str | None
) -> None:
    """Counts exactly; area, volume and bounds within rounding."""
    mesh = part.mesh.copy()
    mesh.vertices = to_world(mesh.vertices, path, unit)
    for key, count in (("vertices", len(mesh.vertices)), ("triangles", len(mesh.faces))):
        same = count == surface[key]
        tally.check(subject, f"report: {key}", same, f"{count} of {surface[key]}")
    measures = {"area": mesh.area}
    if not surface.get("boundary_edges"):  # the volume of an open surface depends on where one stands
        measures["volume"] = mesh.volume
    for key, value in measures.items():
        near = abs(value - surface[key]) <= RELATIVE * abs(surface[key])
        tally.check(subject, f"report: {key}", near, f"{value:.7g} of {surface[key]:.7g}")
    stated = np.asarray(surface["bounds"], dtype=float)
    slack = RELATIVE * float(np.linalg.norm(stated[1] - stated[0]))
    apart = float(np.abs(mesh.bounds - stated).max())
    tally.check(subject, "report: bounds", apart <= slack, f"{apart:.3g} apart")


def check_file(tally: Tally, path: Path, open_border: bool, report: dict | None) -> None:
    """All checks of one file."""
    try:
        parts = parts_of(path)
    except Exception as error:  # whatever a reader raises, the file is at fault
        tally.check(path.name, "trimesh: loads", False, error)
        return
    tally.check(path.name, "trimesh: loads", len(parts) > 0, f"{len(parts)} surfaces")
    for part in parts:
        subject = f"{path.name} [{part.name}]"
        check_trimesh(tally, subject, part, open_border)
        if not open_border:
            check_manifold(tally, subject, part)
    check_meshlab(tally, path, open_border)
    if report is not None:
        check_report(tally, path, parts, report)


def main() -> int:
    """Checks the files that the command line names."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path, help=".glb .gltf .obj .ply .stl")
    parser.add_argument(
        "--open", action="store_true", help="a border is allowed: no watertight, no solid"
    )
    parser.add_argument("--report", type=Path, help="the report that `isokit extract` wrote")
    arguments = parser.parse_args()
    report = json.loads(arguments.report.read_text()) if arguments.report else None
    tally = Tally("check_mesh")
    for path in arguments.files:
        check_file(tally, path, arguments.open, report)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
