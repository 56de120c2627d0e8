"""isokit in each of its modes: a volume file in, a PLY file out. Needs numpy."""

import re
import subprocess
from pathlib import Path

import numpy as np

from kit.program import Failed
from kit.stress_case import TYPES, Case, in_types
from kit.stress_check import Allowed, Mesh, faults
from kit.stress_modes import Mode, Modes

NRRD = {"i1": "int8", "u1": "uint8", "i2": "int16", "u2": "uint16", "i4": "int32"}
NRRD |= {"u4": "uint32", "f4": "float", "f8": "double"}
"""NRRD's names of types by numpy's."""

PLY = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}
"""numpy's names of types by PLY's."""


COUNTERS = ("boundary_edges", "nonmanifold_edges", "degenerate_triangles")
"""What the program's own report says of a closed surface; all must be 0, the last but if exact."""


def judge(modes: Modes, case: Case, mode: Mode, folder: Path) -> tuple[Mesh | None, dict[str, int]]:
    """The mesh, and what is wrong with it by the checker and by the program's own report."""
    mesh, said, wrong = run(modes, case, mode, folder)
    if mesh is None:
        return None, wrong
    closed, exact = mode.boundary == "closed", mode.degenerate == "exact"
    # A sample on the isovalue alone is a solid of no volume if exact.
    allowed = Allowed(
        border=not closed, turned_out=not closed or exact, flat=exact, on_is_either=False
    )
    return mesh, faults(mesh, case, allowed) | {"report": misreported(said, mesh, mode)}


def misreported(said: dict, mesh: Mesh, mode: Mode) -> int:
    """1 if a report has other counts than the mesh, or faults that the mode must not have."""
    counts = (said["vertices"], said["triangles"])
    counters = COUNTERS[: 2 if mode.degenerate == "exact" else 3]
    own = sum(said[counter] for counter in counters) if mode.boundary == "closed" else 0
    return int(counts != (len(mesh.vertices), len(mesh.triangles)) or own > 0)


def same(modes: Modes, case: Case, mode: Mode, mesh: Mesh | None, folder: Path) -> dict[str, int]:
    """What is wrong with a mode that must give the mesh of its plain mode."""
    typed = in_type(case, mode)
    again, _, wrong = run(modes, typed, mode, folder)
    if again is None or mesh is None:
        return wrong
    if typed is not case:
        return {"differs": shape_differs(again, mesh)}
    return {"differs": int(not again.same_as(mesh))}


def in_type(case: Case, mode: Mode) -> Case:
    """The case in the type of a mode; where none of that kind holds its values, in its own."""
    if mode.dtype == "own":
        return case
    types = [name for name in TYPES if (name[0] == "f") == (mode.dtype == "float")]
    # Cases and rows differ, so all types have their turn.
    turn = sum(map(ord, f"{case.name}, {mode}")) % len(types)
    return next(in_types(case, (*types[turn:], *types[:turn])), case)


def shape_differs(one: Mesh | None, other: Mesh | None) -> int:
    """1 if two meshes differ, normals aside: those of samples of more bits are rounded later."""
    if one is None or other is None:
        return 1
    one, other = Mesh(one.vertices, one.triangles), Mesh(other.vertices, other.triangles)
    return int(not one.same_as(other))


def run(modes: Modes, case: Case, mode: Mode, folder: Path) -> tuple[Mesh | None, dict, dict]:
    """The mesh and the report of its surface, or why there is none."""
    volume = write(case, folder)
    out = folder / "mesh.ply"
    try:
        iso = f"--iso={float(case.iso)!r}"
        report = modes.program(mode).extract(volume, out, iso, *mode.options())
    except subprocess.TimeoutExpired as late:
        return None, {}, {f"no answer within {late.timeout:g} s": 1}
    except Failed as failure:
        return None, {}, {str(failure): 1}
    return read(out), report["surfaces"][0], {}


def lawful(case: Case, mode: Mode) -> bool:
    """Whether the program takes a case in a mode: slices of a file in Fortran order lie nowhere."""
    return mode.memory == "whole" or case.samples.flags.c_contiguous or case.placed


def write(case: Case, folder: Path) -> Path:
    """The volume as NPY, or as NRRD where it has a place."""
    if not case.placed:
        path = folder / "volume.npy"
        np.save(path, case.samples)
        return path
    path = folder / "volume.nrrd"
    vectors = " ".join("({!r},{!r},{!r})".format(*map(float, v)) for v in case.directions)
    header = [
        "NRRD0004",
        f"type: {NRRD[case.samples.dtype.str[1:]]}",
        "dimension: 3",
        "space dimension: 3",
        "sizes: " + " ".join(map(str, reversed(case.samples.shape))),
        f"space directions: {vectors}",
        "space origin: ({!r},{!r},{!r})".format(*map(float, case.origin)),
        "endian: little",
        "encoding: raw",
    ]
    data = np.ascontiguousarray(case.samples, case.samples.dtype.newbyteorder("<")).tobytes()
    path.write_bytes("\n".join(header).encode() + b"\n\n" + data)
    return path


def read(path: Path) -> Mesh:
    """A binary PLY of vertices and triangles."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    if "format binary_little_endian" not in header:
        raise ValueError("PLY: not binary, little-endian")
    elements = re.split(r"^element ", header, flags=re.MULTILINE)[1:]
    sections = {section.split()[0]: section for section in elements}
    at, parts = end, {}
    for name, section in sections.items():
        count = int(section.split()[1])
        if name == "face":
            kinds = re.search(r"property list (\w+) (\w+)", section)
            kind = np.dtype([("n", PLY[kinds[1]]), ("corners", PLY[kinds[2]], 3)])
        else:
            fields = re.findall(r"property (\w+) (\w+)$", section, re.MULTILINE)
            kind = np.dtype([(field, PLY[stored]) for stored, field in fields])
        parts[name] = np.frombuffer(data, kind, count, at)
        at += count * kind.itemsize
    if at != len(data) or (parts["face"]["n"] != 3).any():
        raise ValueError("PLY: not triangles alone")
    vertex = parts["vertex"]
    columns = [
        np.stack([vertex[field] for field in fields], axis=1)
        for fields in ("xyz", ("nx", "ny", "nz"))
        if set(fields) <= set(vertex.dtype.names)
    ]
    return Mesh(columns[0], parts["face"]["corners"], *columns[1:])
