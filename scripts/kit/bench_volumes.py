"""The volumes that are measured, as raw files that every contender reads. Needs numpy.

Samples lie x fastest, in this machine's byte order, one apart: what spacing and place cost is not
compared.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

NAMES = {"uint8": "u8", "int16": "i16", "uint16": "u16", "float32": "f32", "float64": "f64"}
"""numpy's names of types as isokit says them."""


@dataclass(frozen=True)
class Volume:
    """A raw file and what is needed to read it. Without a path every contender makes samples up."""

    name: str
    dims: tuple[int, int, int]
    dtype: str
    iso: float
    path: Path | None = None

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.dims[0] * self.dims[1] * self.dims[2]

    def request(self) -> dict:
        """The request to load it."""
        path = str(self.path) if self.path else None
        return {
            "op": "load",
            "path": path,
            "dims": self.dims,
            "dtype": self.dtype,
            "iso": self.iso,
        }


class Absent(Exception):
    """The data is not here; the message says which."""


class Store:
    """Makes each volume once, in a scratch folder."""

    def __init__(self, folder: Path, data: Path) -> None:
        """`data` is the folder of real volumes; it may be absent."""
        self.folder = folder
        self.data = data

    def sphere(self, n: int, dtype: str = "float32") -> Volume:
        """0.4 n − |p − (n − 1) / 2|: a sparse surface."""
        squares = (np.arange(n) - (n - 1) / 2) ** 2
        plane = squares[:, None] + squares[None, :]
        slices = (0.4 * n - np.sqrt(plane + z) for z in squares)
        return self._formula(f"sphere {n}", n, slices, dtype, 0.9 * n)

    def gyroid(self, n: int, period: float | None = None, dtype: str = "float32") -> Volume:
        """sin x cos y + sin y cos z + sin z cos x: a dense surface; six periods by default."""
        angle = 2 * np.pi * np.arange(n) / (period or n / 6)
        sin, cos = np.sin(angle), np.cos(angle)
        fixed = sin[None, :] * cos[:, None]  # indices are y, x
        slices = (
            fixed + sin[:, None] * c + cos[None, :] * s for s, c in zip(sin, cos, strict=True)
        )
        name = f"gyroid {n}" + (f" period {period:g}" if period else "")
        return self._formula(name, n, slices, dtype, 3.0)

    def shell(self, dims: tuple[int, int, int]) -> Volume:
        """A ball with a gyroid's waves of 64 samples on it, as u16: large, and rather sparse."""
        nx, ny, nz = dims
        path = self._path(f"shell {nx} {ny} {nz} uint16")
        x, y, z = (np.arange(n, dtype=np.float32) for n in dims)
        sin = [np.sin(axis * np.float32(np.pi / 32)) for axis in (x, y, z)]
        cos = [np.cos(axis * np.float32(np.pi / 32)) for axis in (x, y, z)]
        fixed = sin[0][None, :] * cos[1][:, None]  # indices are y, x
        squares = [((axis - (n - 1) / 2) / n) ** 2 for axis, n in zip((x, y, z), dims, strict=True)]
        plane = squares[0][None, :] + squares[1][:, None]
        if not path.exists():
            with path.open("wb") as file:
                for k in range(nz):
                    waves = fixed + sin[1][:, None] * cos[2][k] + cos[0][None, :] * sin[2][k]
                    ball = 0.4 - np.sqrt(plane + squares[2][k])
                    values = 32768 + 60000 * ball + 1000 * waves
                    np.clip(np.rint(values), 0, 65535).astype(np.uint16).tofile(file)
        return Volume(f"shell {nx} x {ny} x {nz}", dims, "u16", 32768.5, path)

    def nifti(self, name: str, relative: str, iso: float) -> Volume:
        """A real volume as it is stored."""
        import nibabel  # slow to import, and needed for real data only

        path = self._real(relative)
        samples = np.asarray(nibabel.load(path).dataobj)  # indices are x, y, z
        return self._write(name, samples.transpose(2, 1, 0), iso)

    def ct_head(self, iso: float) -> Volume:
        """The slices of a head in the order of their positions, in Hounsfield units."""
        import pydicom

        folder = self._real("dicom/ct_head_gantry_tilt")
        slices = []
        for path in folder.iterdir():
            data = pydicom.dcmread(path, force=True)
            if "PixelData" in data:
                slices.append(data)
        slices.sort(key=lambda data: float(data.ImagePositionPatient[2]))
        values = [
            data.pixel_array * float(data.RescaleSlope) + float(data.RescaleIntercept)
            for data in slices
        ]
        return self._write("CT head", np.rint(values).astype(np.int16), iso)

    def _real(self, relative: str) -> Path:
        path = self.data / relative
        if not path.exists():
            raise Absent(f"there is no {relative} in the data folder")
        return path

    def _formula(self, name: str, n: int, slices, dtype: str, reach: float) -> Volume:
        """Slice by slice, so that no volume has to fit twice. Integers spread over `reach`."""
        path = self._path(f"{name} {dtype}")
        kind = np.dtype(dtype)
        middle, scale = 0.0, 1.0
        if kind.kind in "iu":
            limits = np.iinfo(kind)
            middle = 0.0 if kind.kind == "i" else (limits.max + 1) / 2
            scale = 0.99 * (limits.max - middle) / reach
        if not path.exists():
            with path.open("wb") as file:
                for values in slices:
                    scaled = values * scale + middle
                    if kind.kind in "iu":
                        scaled = np.rint(scaled)
                    scaled.astype(kind).tofile(file)
        # Not a value that an integer can have, as users choose it.
        iso = middle + (0.5 if kind.kind in "iu" else 0.0)
        return Volume(name, (n, n, n), NAMES[dtype], iso, path)

    def _write(self, name: str, samples: np.ndarray, iso: float) -> Volume:
        path = self._path(name)
        if not path.exists():
            np.ascontiguousarray(samples).tofile(path)
        nz, ny, nx = samples.shape
        return Volume(name, (nx, ny, nz), NAMES[samples.dtype.name], iso, path)

    def _path(self, name: str) -> Path:
        return self.folder / f"{name.replace(' ', '_')}.raw"
