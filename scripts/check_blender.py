#!/usr/bin/env python3
"""Imports mesh files of one extraction into real Blender and compares what arrives.

GLB, OBJ, PLY and STL of the same surfaces must land on the same place in Blender, with the same
vertices, faces and normals, once the unit is divided out (glTF is in metres, the others keep the
unit of the volume). Each importer turns its axes by its own default; nothing is set by hand here,
because a user does not either. Materials are looked at where the format has them: GLB and OBJ.
Values and colours of vertices must arrive where the report says that there are some and the format
holds them, colours alike.

Runs in the interpreter that `scripts/test --importers` sets up, wherever it is started from.
"""

import argparse
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from kit.quiet import quiet
from kit.tally import Tally
from kit.units import GLTF, file_unit

PROJECT = Path(__file__).resolve().parents[1]
PLACE = 1e-5
"""Positions agree to this part of the size: Blender keeps f32 and turns OBJ by a matrix of f32."""
NORMAL = 0.9998
"""Least cosine between the normals of two formats: OBJ writes decimals, and turns them."""
COLOUR = 1.5 / 255
"""Colours agree to this in linear light: PLY has bytes, Blender may keep others as bytes."""
LOST = 1000
"""One vertex in so many may differ: Blender's OBJ importer loses normals of needle triangles."""

try:
    import bpy
except ImportError:
    blender = PROJECT / ".venv-blender/bin/python"
    if not blender.exists() or Path(sys.prefix) == blender.parents[1]:
        sys.exit("no Blender here: run scripts/test --importers once, it sets one up")
    os.execv(blender, [str(blender), *sys.argv])
import numpy as np
from kit.picture import render


@dataclass
class Arrived:
    """One mesh as Blender has it, in the world and the unit of the volume."""

    name: str
    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    """One per vertex: the sum over the corners that meet there, at length 1."""
    custom_normals: bool
    material: bpy.types.Material | None
    values: np.ndarray | None
    """One per vertex, where the file has them."""
    colours: np.ndarray | None
    """One per vertex, in linear light with opacity, where the file has them."""

    def bounds(self) -> np.ndarray:
        """Least and greatest corner."""
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    def volume(self) -> float:
        """Signed: negative where an importer turned the surface inside out."""
        a, b, c = (self.points[self.triangles[:, corner]] for corner in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def load(path: Path) -> None:
    """Imports one file into an empty scene with the importer's defaults."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    importers = {
        ".glb": bpy.ops.import_scene.gltf,
        ".gltf": bpy.ops.import_scene.gltf,
        ".obj": bpy.ops.wm.obj_import,
        ".ply": bpy.ops.wm.ply_import,
        ".stl": bpy.ops.wm.stl_import,
    }
    with quiet():
        importers[path.suffix.lower()](filepath=str(path))


def array(items: object, attribute: str, width: int, dtype: type) -> np.ndarray:
    """One attribute of a Blender collection, a row per item."""
    values = np.empty(len(items) * width, dtype=dtype)
    items.foreach_get(attribute, values)
    return values.reshape(-1, width)


def values_of(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """The number of each vertex, by the name that glTF or PLY has for it."""
    for name in ("_VALUE", "quality"):
        found = mesh.attributes.get(name)
        if found is not None and found.domain == "POINT":
            return array(found.data, "value", 1, np.float32)[:, 0]
    return None


def colours_of(mesh: bpy.types.Mesh, at: np.ndarray) -> np.ndarray | None:
    """The colour of each vertex, or of one corner `at` it."""
    if not mesh.color_attributes:
        return None
    attribute = mesh.color_attributes[0]
    found = array(attribute.data, "color", 4, np.float32)
    if attribute.domain == "POINT":
        return found
    colours = np.zeros((len(mesh.vertices), 4), dtype=np.float32)
    colours[at] = found
    return colours


def arrived(path: Path, unit: str | None) -> list[Arrived]:
    """The meshes of the scene, by name."""
    scale = file_unit(path.suffix, unit)
    found = []
    for item in sorted(bpy.data.objects, key=lambda item: item.name):
        if item.type != "MESH":
            continue
        mesh = item.data
        mesh.calc_loop_triangles()
        turn = np.array(item.matrix_world)
        points = array(mesh.vertices, "co", 3, np.float32).astype(float)
        at = array(mesh.loops, "vertex_index", 1, np.int32)[:, 0]
        normals = np.zeros_like(points)
        np.add.at(normals, at, array(mesh.corner_normals, "vector", 3, np.float32))
        normals = normals @ np.linalg.inv(turn[:3, :3])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        found.append(
            Arrived(
                name=item.name,
                points=(points @ turn[:3, :3].T + turn[:3, 3]) / scale,
                triangles=array(mesh.loop_triangles, "vertices", 3, np.int32),
                normals=normals / np.maximum(lengths, 1e-30),
                custom_normals=mesh.has_custom_normals,
                material=mesh.materials[0] if mesh.materials else None,
                values=values_of(mesh),
                colours=colours_of(mesh, at),
            )
        )
    return found


def check_alone(
    tally: Tally, subject: str, mesh: Arrived, surface: dict, has_normals: bool
) -> None:
    """What one mesh must be, whatever the other formats say."""
    for key, count in (("vertices", len(mesh.points)), ("triangles", len(mesh.triangles))):
        tally.check(subject, f"Blender: {key}", count == surface[key], f"{count}")
    stated = np.asarray(surface["bounds"], dtype=float)
    apart = float(np.abs(mesh.bounds() - stated).max())
    slack = PLACE * float(np.linalg.norm(stated[1] - stated[0]) + np.abs(stated).max())
    tally.check(subject, "Blender: bounds of the report", apart <= slack, f"{apart:.3g} apart")
    if surface.get("boundary_edges") == 0:
        volume = mesh.volume()
        tally.check(subject, "Blender: outside is out", volume > 0, f"volume {volume:.6g}")
    if has_normals:
        tally.check(subject, "Blender: normals came from the file", mesh.custom_normals)


def check_alike(tally: Tally, subject: str, mesh: Arrived, first: Arrived, stl: bool) -> None:
    """The same surface as the one that the first file gave, vertex by vertex."""
    size = float(np.linalg.norm(np.ptp(first.points, axis=0)) + np.abs(first.points).max())
    if stl or len(mesh.points) != len(first.points):  # STL readers number vertices anew
        apart = float(np.abs(mesh.bounds() - first.bounds()).max())
        tally.check(subject, "Blender: same bounds", apart <= PLACE * size, f"{apart:.3g} apart")
        return
    apart = float(np.abs(mesh.points - first.points).max())
    tally.check(subject, "Blender: same place", apart <= PLACE * size, f"{apart:.3g} apart")
    cosines = np.einsum("ij,ij->i", mesh.normals, first.normals)
    astray = int((cosines < NORMAL).sum())
    found = f"{astray} of {len(cosines)} differ"
    tally.check(subject, "Blender: same normals", astray <= len(cosines) // LOST, found)


def check_carried(
    tally: Tally, subject: str, mesh: Arrived, report: dict, suffix: str
) -> None:
    """The values and colours that the report speaks of, where the format holds them."""
    carried = report.get("vertex_colors") or {}
    if "attribute" in carried and suffix in (*GLTF, ".ply"):
        found = mesh.values
        if tally.check(subject, "Blender: vertices have values", found is not None):
            stated = np.asarray(carried["attribute"]["range"])
            ends = np.array([np.nanmin(found), np.nanmax(found)])
            near = bool(np.allclose(ends, stated, rtol=1e-6))
            tally.check(subject, "Blender: values of the report", near, ends)
    if "colormap" in carried or "texture" in carried:
        there = mesh.colours is not None
        tally.check(subject, "Blender: vertices have colours", there or suffix == ".stl")


def check_same_colours(tally: Tally, subject: str, mesh: Arrived, first: Arrived) -> None:
    """The colours that the first file gave, but for opacity, which OBJ does not hold."""
    if mesh.colours is None or first.colours is None or mesh.colours.shape != first.colours.shape:
        return
    apart = float(np.abs(mesh.colours - first.colours)[:, :3].max())
    tally.check(subject, "Blender: same colours", apart <= COLOUR, f"{apart:.3g} apart")


def check_material(tally: Tally, subject: str, mesh: Arrived, colour: str, gltf: bool) -> None:
    """Named like its surface, with the alpha asked for; the colour where its meaning is fixed."""
    material = mesh.material
    if not tally.check(subject, "Blender: has a material", material is not None):
        return
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    wanted = [int(colour[at : at + 2] or "ff", 16) / 255 for at in (1, 3, 5, 7)]
    alpha = shader.inputs["Alpha"].default_value
    near = abs(alpha - wanted[3]) < 1 / 255
    tally.check(subject, "Blender: alpha", near, f"{alpha:.3f}")
    if not gltf:  # MTL does not say whether Kd is linear
        return
    linear = [(c + 0.055) ** 2.4 / 1.055**2.4 if c > 0.04045 else c / 12.92 for c in wanted[:3]]
    base = list(shader.inputs["Base Color"].default_value)[:3]
    near = max(abs(a - b) for a, b in zip(base, linear)) < 1 / 255
    tally.check(subject, "Blender: colour", near, [round(value, 3) for value in base])
    blended = material.surface_render_method == "BLENDED"
    tally.check(subject, "Blender: blended only if translucent", blended == (wanted[3] < 1))


def check_file(
    tally: Tally, path: Path, report: dict, first: dict[str, Arrived], colours: dict[str, str]
) -> dict[str, Arrived]:
    """All checks of one file; returns its meshes by the names of their surfaces."""
    load(path)
    meshes = arrived(path, report["input"].get("unit"))
    surfaces = [surface for surface in report["surfaces"] if surface["triangles"] > 0]
    suffix = path.suffix.lower()
    agree = len(meshes) == len(surfaces)
    if not tally.check(path.name, "Blender: as many surfaces", agree, len(meshes)):
        return {}
    by_surface = {}
    for surface in surfaces:
        name = surface["name"]
        named = [mesh for mesh in meshes if name in mesh.name] or meshes
        mesh = by_surface[name] = min(named, key=lambda mesh: len(mesh.name))
        subject = f"{path.name} [{name}]"
        if len(meshes) > 1:
            tally.check(subject, "Blender: object has the name", name in mesh.name, mesh.name)
        check_alone(tally, subject, mesh, surface, has_normals=suffix != ".stl")
        check_carried(tally, subject, mesh, report, suffix)
        if name in first:
            check_alike(tally, subject, mesh, first[name], stl=suffix == ".stl")
            check_same_colours(tally, subject, mesh, first[name])
        if name in colours and suffix not in (".ply", ".stl"):
            material = mesh.material.name if mesh.material else None
            tally.check(subject, "Blender: material has the name", material == name, material)
            check_material(tally, subject, mesh, colours[name], suffix in GLTF)
    return by_surface


def main() -> int:
    """Checks the files of one extraction, then renders the first if asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path, help="the same surfaces, in any formats")
    parser.add_argument(
        "--report", type=Path, required=True, help="the report that `isokit extract` wrote"
    )
    parser.add_argument(
        "--material",
        action="append",
        default=[],
        metavar="NAME:#RRGGBB[AA]",
        help="a surface of GLB and OBJ files and the colour it must have; repeatable",
    )
    parser.add_argument("--render", type=Path, metavar="PNG", help="a picture of the first file")
    arguments = parser.parse_args()
    report = json.loads(arguments.report.read_text())
    colours = dict(material.split(":", 1) for material in arguments.material)
    tally = Tally("check_blender")
    first: dict[str, Arrived] = {}
    for path in arguments.files:
        meshes = check_file(tally, path, report, first, colours)
        first = first or meshes
    if arguments.render:
        load(arguments.files[0])
        render(arguments.render)
        written = arguments.render.stat().st_size
        tally.check(arguments.render.name, "Blender: picture written", written > 0, written)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
