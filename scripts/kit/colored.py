"""A mesh whose vertices have values and colours, as readers that other people wrote see it.

A ball and, on another lattice with other axes, a field that is linear are written here, so the
value of each vertex is known from its place alone, and from the value its colour. What a format has
no place for is not asked. Needs trimesh and MeshLab.
"""

from pathlib import Path

import numpy as np
import pymeshlab

from kit.program import Failed, Isokit
from kit.surface import Part, parts_of, to_world
from kit.tally import Tally
from kit.units import GLTF

FORMATS = (".ply", ".glb", ".obj")
UNIT = "mm"
LOW, HIGH = 2.0, 9.0
"""Values where the colours begin and end; the field goes beyond both."""
ALPHA = 0x80
SURFACE = f"0:ball:#ff0000{ALPHA:02x}"

COLOUR = 1.51 / 255
"""Colours agree to this: isokit rounds a byte, and MeshLab cuts the decimals of OBJ to one."""

FIELD = np.array([0.5, 0.25, -0.125])
MIDDLE = 5.5


def field_at(points: np.ndarray) -> np.ndarray:
    """The field at places of the world, in RAS and millimetres."""
    return MIDDLE + points @ FIELD


def colours_of(values: np.ndarray) -> np.ndarray:
    """The colours of values, 0 to 1 in sRGB with opacity: gray, from black to white."""
    gray = np.clip((values - LOW) / (HIGH - LOW), 0, 1)
    return np.column_stack([gray, gray, gray, np.full(len(gray), ALPHA / 255)])


def linear_light(encoded: np.ndarray) -> np.ndarray:
    """Colours of sRGB in linear light; opacity is as it was."""
    light = np.where(encoded > 0.04045, ((encoded + 0.055) / 1.055) ** 2.4, encoded / 12.92)
    return np.column_stack([light[:, :3], encoded[:, 3]])


def write_nrrd(path: Path, space: str, step: float, origin: float, samples: np.ndarray) -> None:
    """A volume of f32, indexed [z, y, x], on a lattice with one step."""
    sizes = " ".join(map(str, samples.shape[::-1]))
    header = f"""NRRD0004
type: float
endian: little
encoding: raw
dimension: 3
sizes: {sizes}
space: {space}
space directions: ({step},0,0) (0,{step},0) (0,0,{step})
space origin: ({origin},{origin},{origin})
space units: "{UNIT}" "{UNIT}" "{UNIT}"

"""
    path.write_bytes(header.encode() + samples.astype("<f4").tobytes())


def places(count: int, step: float, origin: float) -> np.ndarray:
    """The places of a lattice, x, y, z of each, indexed [z, y, x]."""
    axis = origin + step * np.arange(count)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    return np.stack([x, y, z], axis=-1)


def check_colored(tally: Tally, isokit: Isokit, folder: Path) -> None:
    """Writes the ball with values and colours in all formats, and reads it with other programs."""
    ball, field = folder / "colored_ball.nrrd", folder / "colored_field.nrrd"
    around = places(25, 1.0, -12.0)
    write_nrrd(ball, "right-anterior-superior", 1.0, -12.0, 9.6 - np.linalg.norm(around, axis=-1))
    turned = places(18, 1.5, -12.5) * (-1.0, -1.0, 1.0)  # the lattice is in LPS
    write_nrrd(field, "left-posterior-superior", 1.5, -12.5, field_at(turned))
    options = ("--attribute", field, "--colormap", f"gray:{LOW}:{HIGH}")
    for suffix in FORMATS:
        path = folder / f"colored{suffix}"
        try:
            isokit.extract(ball, path, "--iso", SURFACE, *options)
        except Failed as failure:
            tally.check(path.name, "extracts", False, failure)
            continue
        check_carried(tally, path)


def check_carried(tally: Tally, path: Path) -> None:
    """The values and colours of one file for trimesh, and for MeshLab where it reads them."""
    part = parts_of(path)[0]
    suffix = path.suffix
    values = field_at(to_world(part.mesh.vertices, path, UNIT))
    colours = colours_of(values)
    if suffix != ".obj":
        compare(tally, path, "trimesh: values", values_of(part, suffix), values, 1e-4)
    wanted = linear_light(colours) if suffix in GLTF else colours
    width = 3 if suffix == ".obj" else 4  # no opacity in OBJ
    found = colours_in(part)
    found = None if found is None else found[:, :width]
    compare(tally, path, "trimesh: colours", found, wanted[:, :width], COLOUR)
    if suffix in GLTF:
        return  # MeshLab reads neither of glTF
    layers = pymeshlab.MeshSet(verbose=False)
    layers.load_new_mesh(str(path))
    mesh = layers.current_mesh()
    if suffix == ".ply":
        found = mesh.vertex_scalar_array() if mesh.has_vertex_scalar() else None
        compare(tally, path, "MeshLab: values", found, values, 1e-4)
    found = mesh.vertex_color_matrix()[:, :width] if mesh.has_vertex_color() else None
    compare(tally, path, "MeshLab: colours", found, colours[:, :width], COLOUR)


def values_of(part: Part, suffix: str) -> np.ndarray | None:
    """The numbers of the vertices as trimesh keeps them; none if there are none."""
    if suffix in GLTF:
        found = part.mesh.vertex_attributes.get("_VALUE")
        return None if found is None else np.asarray(found).reshape(-1)
    data = part.mesh.metadata["_ply_raw"]["vertex"]["data"]
    return np.asarray(data["quality"]) if "quality" in data.dtype.names else None


def colours_in(part: Part) -> np.ndarray | None:
    """The colours of the vertices as trimesh has them, 0 to 1; none if there are none."""
    visual = part.mesh.visual
    found = part.mesh.vertex_attributes.get("color")
    if found is None and visual.kind == "vertex":
        found = visual.vertex_colors
    if found is None:
        return None
    found = np.asarray(found)
    return found / np.iinfo(found.dtype).max if found.dtype.kind in "iu" else found


def compare(
    tally: Tally, path: Path, claim: str, found: np.ndarray | None, wanted: np.ndarray, slack: float
) -> None:
    """Numbers that arrived are there for every vertex and near those that are known."""
    if found is None or found.shape != wanted.shape:
        shape = "none" if found is None else found.shape
        tally.check(path.name, claim, False, f"{shape} instead of {wanted.shape}")
        return
    apart = float(np.abs(found - wanted).max())
    tally.check(path.name, claim, apart <= slack, f"{apart:.3g} apart")
