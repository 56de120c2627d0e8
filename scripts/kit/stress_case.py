"""What an input of the stress list is, and the shapes that several share. Needs numpy.

Each item of the list is a function that gives its cases. Samples are indexed z, y, x. The small
form of an item has the same values and smaller volumes. Chance is seeded by the item, so every run
has the same samples.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Case:
    """A volume and an isovalue."""

    name: str
    samples: np.ndarray
    iso: float
    directions: tuple = IDENTITY
    """The steps along x, y and z in world units: spacing and orientation."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The place of the first sample."""
    view: str = ""
    """How a peer gets the samples in memory, see `seen`. A program gets a file."""
    same_as: str = ""
    """The name of a case before this one with the same values: the mesh must be the same."""

    @property
    def placed(self) -> bool:
        """Whether it has a frame of its own."""
        return self.directions != IDENTITY or any(self.origin)


@dataclass(frozen=True)
class Item:
    """One line of the list."""

    number: int
    name: str
    cases: Callable[[bool], Iterator[Case]] = field(repr=False)


ITEMS: dict[int, Item] = {}
"""All that were imported, by their numbers."""


def item(number: int, name: str) -> Callable:
    """Puts a function into the list."""

    def add(function: Callable[[bool], Iterator[Case]]) -> Callable:
        ITEMS[number] = Item(number, name, function)
        return function

    return add


TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8")
"""All that isokit takes, by numpy's names."""


def in_types(case: Case, types: tuple[str, ...] = TYPES) -> Iterator[Case]:
    """The same values in every other type that holds them. Unsigned ones hold them from 0 on."""
    for name in types:
        dtype = np.dtype(name)
        if dtype == case.samples.dtype.newbyteorder("="):
            continue
        shift = 0
        if dtype.kind != "f":
            if not is_whole(case.samples):
                continue
            least, greatest = int(case.samples.min()), int(case.samples.max())
            shift = -least if dtype.kind == "u" and least < 0 else 0
            limits = np.iinfo(dtype)
            if not limits.min <= least + shift <= greatest + shift <= limits.max:
                continue
        with np.errstate(over="ignore", invalid="ignore"):
            exact = case.samples.astype(np.float64) + shift
            samples = exact.astype(dtype)
        iso = case.iso + shift
        held = np.array_equal(samples.astype(np.float64), exact, equal_nan=dtype.kind == "f")
        if held and iso - shift == case.iso:
            yield replace(
                case, name=f"{case.name} as {name}", samples=samples, iso=iso, same_as=case.name
            )


def is_whole(samples: np.ndarray) -> bool:
    """Whether all are whole numbers."""
    if samples.dtype.kind != "f":
        return True
    return bool(np.isfinite(samples).all() and (samples == np.rint(samples)).all())


def rounded(field: np.ndarray, steps: int) -> np.ndarray:
    """A field from -1 to 1 or so in whole numbers that a byte holds."""
    return np.clip(np.rint(field * steps), -127, 127).astype(np.int8)


def seen(samples: np.ndarray, view: str) -> np.ndarray:
    """The same samples, lying otherwise in memory."""
    if view == "every second":
        spread = np.zeros([2 * n for n in samples.shape], samples.dtype)
        spread[::2, ::2, ::2] = samples
        return spread[::2, ::2, ::2]
    if view == "backwards":
        return np.ascontiguousarray(samples[::-1, ::-1, ::-1])[::-1, ::-1, ::-1]
    return samples


def chance(number: int) -> np.random.Generator:
    """The chance of an item."""
    return np.random.default_rng(number)


def lattice(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and z from -1 to 1, each of the shape of a cube of n samples."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    return x, y, z


def gyroid(n: int) -> np.ndarray:
    """One and a half periods, which never equal the isovalues used here."""
    x, y, z = (1.5 * np.pi * axis for axis in lattice(n))
    return np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)


def ball(n: int, radius: float) -> np.ndarray:
    """Positive within the radius."""
    return radius - np.sqrt(sum(axis**2 for axis in lattice(n)))


def board(n: int) -> np.ndarray:
    """True and false in turn along each axis."""
    return np.indices((n, n, n)).sum(axis=0) % 2 == 0


def tiles(volumes: np.ndarray, between: int) -> np.ndarray:
    """Small volumes, a cube number of them, side by side, with a layer around each.

    One extraction then tries them all, and each surface is closed whatever is done at borders.
    """
    count = round(len(volumes) ** (1 / 3))
    padded = np.pad(volumes, ((0, 0), (1, 0), (1, 0), (1, 0)), constant_values=between)
    _, nz, ny, nx = padded.shape
    cube = padded.reshape(count, count, count, nz, ny, nx).transpose(0, 3, 1, 4, 2, 5)
    whole = cube.reshape(count * nz, count * ny, count * nx)
    return np.pad(whole, ((0, 1),) * 3, constant_values=between)
