"""The tables of the data folder's manifest, and what it says only in words.

Standard library only.
"""

import re
from dataclasses import dataclass
from pathlib import Path

VOLUME = re.compile(r"\.(nii|nii\.gz|nrrd|nhdr|mha|mhd|npy|npy\.bz2|raw|raw\.bz2)$")
"""Names of the volumes that isokit reads."""

DTYPES = {
    "uint8": "u8",
    "u1": "u8",
    "8-bit unsigned integer": "u8",
    "16-bit unsigned integer": "u16",
    "16-bit signed integer": "i16",
    "32-bit signed integer": "i32",
    "int16": "i16",
    ">i2": "i16",
    "int32": "i32",
    "float32": "f32",
}

RAW = {
    "volvis/vismale_head_128x256x256_u8.raw.bz2": "128,256,256 u8 1.57774,0.995861,1.00797",
    "volvis/Bucky_32x32x32_u8.raw": "32,32,32 u8 1,1,1",
    "volvis/tooth/tooth.raw": "103,94,161 u16be 1,1,1",
    "metaimage/HeadMRVolume.raw": "48,62,42 u8 4,4,4",
    "nrrd/pynrrd/BallBinary30x30x30.raw": "30,30,30 i16 1,1,1",
}
"""How headerless files are to be read: dims, dtype, spacing."""

SHEARED = {-300.0: 173587.0, 300.0: 117335.0}
"""Areas of `shear_gantry_tilt`, whose shear the table ignores, by isovalue."""

MISTAKEN = {"metaimage/frogtissue.mhd": (0.0, 29.0)}
"""Ranges that the manifest has wrong: its own line about the same volume as VTI says 0..29, and so do
the bytes."""


@dataclass(frozen=True)
class Facts:
    """What a volume must be found to be."""

    path: str
    dims: tuple[int, ...]
    dtype: str
    range: tuple[float, float]
    spacing: tuple[float, ...] = ()


@dataclass(frozen=True)
class Reference:
    """A line of the table of reference isosurfaces."""

    path: str
    iso: float
    triangles: int
    points: int
    area: float


def rows(text: str) -> list[list[str]]:
    """The cells of every table row."""
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]


def volumes(text: str) -> list[Facts]:
    """The lines about one volume in a format that isokit reads."""
    found = []
    for cells in rows(text.split("## Reference isosurfaces")[0]):
        path, dims = cells[0], cells[2]
        if path.startswith("malformed/") or not VOLUME.search(path) or not dims:
            continue
        low, high = re.fullmatch(r"(-?[^.]+(?:\.\d+)?)\.\.(-?.+)", cells[5]).groups()
        found.append(
            Facts(
                path=path,
                dims=tuple(map(int, dims.split("x"))),
                dtype=DTYPES[cells[3]],
                range=MISTAKEN.get(path, (float(low), float(high))),
                spacing=tuple(map(float, cells[4].split(","))) if cells[4] else (),
            )
        )
    return found


def references(text: str) -> tuple[list[Reference], int]:
    """The reference isosurfaces of formats that isokit reads, and how many others there are."""
    lines = rows(text.split("## Reference isosurfaces")[1])[1:]
    found = [
        Reference(cells[0], float(cells[3]), int(cells[4]), int(cells[5]), float(cells[6]))
        for cells in lines
        if VOLUME.search(cells[0])
    ]
    return found, len(lines) - len(found)


def raw_options(path: str) -> list[str]:
    """The options that a headerless file needs; none for others."""
    if path not in RAW:
        return []
    dims, dtype, spacing = RAW[path].split()
    return ["--dims", dims, "--dtype", dtype, "--spacing", spacing]


def told_in_words() -> list[Facts]:
    """Files of the folders that the manifest describes as a whole, and of raw data."""
    dtypes = ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64")
    facts = [
        Facts(f"nifti/dtypes/{name}.nii", (3, 3, 3), short(name), (0, 26)) for name in dtypes
    ]
    for suffix in ("hdr", "hdr.gz", "nii", "nii.gz"):
        facts.append(Facts(f"nifti/pair/minimal.{suffix}", (64, 64, 10), "u8", (0, 63)))
    facts.append(Facts("nifti/pair/minimal_extended_hdr.nii", (8, 8, 1), "f64", (0, 0)))
    ball = "nrrd/pynrrd/BallBinary30x30x30"
    for tail in (
        ".nhdr .nrrd .raw .nii.gz _bz2.nrrd _gz.nrrd _gz_lineskip.nrrd _byteskip_minus_one.nhdr "
        "_gz_byteskip_minus_one.nrrd _byteskip_minus_one_nifti.nhdr"
    ).split():
        facts.append(Facts(ball + tail, (30, 30, 30), "i16", (0, 257)))
    for name, dims, dtype in (
        ("test1d_ascii", (27, 1, 1), "u8"),
        ("test2d_ascii", (3, 9, 1), "u16"),
        ("test_customFields", (27, 1, 1), "u8"),
    ):
        facts.append(Facts(f"nrrd/pynrrd/{name}.nrrd", dims, dtype, (1, 27)))
    value = 0.76903426
    facts.append(Facts("nrrd/pynrrd/test_simple4d_raw.nrrd", (1, 1, 1), "f64", (value, value)))
    facts.append(Facts("volvis/tooth/tooth.raw", (103, 94, 161), "u16", (0, 1300)))
    facts.append(Facts("metaimage/HeadMRVolume.raw", (48, 62, 42), "u8", (0, 255)))
    return facts


def orientations(data: Path) -> list[Facts]:
    """One brain in its storage orders; the name of a file says which axis of it is where."""
    sizes = dict.fromkeys("RL", 64) | dict.fromkeys("AP", 79) | dict.fromkeys("SI", 67)
    return [
        Facts(
            path=str(path.relative_to(data)),
            dims=tuple(sizes[letter] for letter in path.name[:3]),
            dtype="u8",
            range=(0.0, 92.55388),
        )
        for path in sorted((data / "nifti/orient").glob("*.nii.gz"))
    ]


def short(dtype: str) -> str:
    """numpy's name for a type as isokit says it."""
    return re.sub(r"^(u?)(int|float)", lambda found: found[1] or found[2][0], dtype)
