"""Meshes on which check scripts are tried: a sound one, and others spoilt in a known way.

They are written as isokit writes them, by trimesh.
"""

from pathlib import Path

import numpy as np
import trimesh

from kit import colored
from kit.surface import Y_UP
from kit.units import file_unit

UNIT = "mm"
OPEN = {"trimesh: watertight", "manifold3d: NoError", "MeshLab: no boundary edges"}


def sphere() -> trimesh.Trimesh:
    """A closed surface away from the origin, longer in each axis than in the one before."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=10)
    return mesh.apply_scale((1.0, 1.5, 2.0)).apply_translation((20, 5, -3))


def faces_changed(faces: np.ndarray) -> trimesh.Trimesh:
    """The sphere with other triangles."""
    return trimesh.Trimesh(sphere().vertices, faces, process=False)


def holed() -> trimesh.Trimesh:
    """Without its last face."""
    return faces_changed(sphere().faces[:-1])


def one_flipped() -> trimesh.Trimesh:
    """One face wound the other way."""
    faces = sphere().faces.copy()
    faces[0] = faces[0, ::-1]
    return faces_changed(faces)


def inside_out() -> trimesh.Trimesh:
    """All faces wound the other way."""
    return faces_changed(sphere().faces[:, ::-1])


def split() -> trimesh.Trimesh:
    """Every vertex written once per face."""
    mesh = sphere()
    mesh.unmerge_vertices()
    return mesh


def finned() -> trimesh.Trimesh:
    """A third face on one edge."""
    mesh = sphere()
    a, b, _ = mesh.faces[0]
    points = np.vstack([mesh.vertices, [[90, 90, 90]]])
    faces = np.vstack([mesh.faces, [[a, b, len(points) - 1]]])
    return trimesh.Trimesh(points, faces, process=False)


def not_a_number() -> trimesh.Trimesh:
    """One coordinate is NaN."""
    mesh = sphere()
    points = mesh.vertices.copy()
    points[7, 1] = np.nan
    return trimesh.Trimesh(points, mesh.faces, process=False)


SPOILT = {
    holed: OPEN,
    one_flipped: {"trimesh: winding is consistent", "manifold3d: NoError"},
    inside_out: {"trimesh: volume > 0"},
    split: OPEN,
    finned: {*OPEN, "MeshLab: two-manifold"},
    not_a_number: {"trimesh: finite", "trimesh: volume > 0", "manifold3d: NoError"},
}
"""What must fail for each; other checks may."""


def write(path: Path, mesh: trimesh.Trimesh, y_up: bool = True, unit: str = UNIT) -> Path:
    """Writes a mesh of the volume's world as isokit does, or with axes or unit wrong."""
    mesh = mesh.copy()
    if y_up and path.suffix in Y_UP:
        mesh.vertices = mesh.vertices[:, [0, 2, 1]] * (1, 1, -1)
    mesh.apply_scale(file_unit(path.suffix, unit))
    normals = {".ply": {"vertex_normal": True}, ".obj": {"include_normals": True}}
    if path.suffix != ".stl":
        _ = mesh.vertex_normals  # trimesh writes normals that it has computed
    mesh.export(path, **normals.get(path.suffix, {}))
    return path


def report_of(meshes: dict[str, trimesh.Trimesh]) -> dict:
    """The report that isokit would give."""
    surfaces = [
        {
            "name": name,
            "vertices": len(mesh.vertices),
            "triangles": len(mesh.faces),
            "boundary_edges": 0,
            "area": float(mesh.area),
            "volume": float(mesh.volume),
            "bounds": mesh.bounds.tolist(),
        }
        for name, mesh in meshes.items()
    ]
    return {"schema": "isokit.extract/1", "input": {"unit": UNIT}, "surfaces": surfaces}


def write_colored(path: Path, spoil: str = "") -> Path:
    """The sphere with the values and colours that are known, or with one of them wrong."""
    mesh = sphere()
    mesh.apply_translation(-mesh.centroid)  # to where the field has values within its colours
    values = colored.field_at(mesh.vertices)
    colours = colored.colours_of(values)
    if path.suffix == ".glb" and spoil != "encoded":
        colours = colored.linear_light(colours)
    if spoil == "values":
        values[values.argmax()] += 0.01
    if spoil == "colours":
        colours[7, 1] = (colours[7, 1] + 0.5) % 1
    if spoil != "colourless":
        mesh.visual.vertex_colors = np.round(colours * 255).astype(np.uint8)
    if spoil != "valueless":
        mesh.vertex_attributes[{".glb": "_VALUE"}.get(path.suffix, "quality")] = values.astype("f4")
    return write(path, mesh)
