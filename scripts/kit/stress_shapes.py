"""Items 13 to 25 of the stress list: places, sizes, shapes and layouts. Needs numpy."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from kit.stress_case import Case, ball, chance, gyroid, item, lattice, rounded, tiles


def diagonal(x: float, y: float, z: float) -> tuple:
    """Directions along the axes."""
    return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))


@item(13, "stretched, tiny, mirrored, turned")
def placed(quick: bool) -> Iterator[Case]:
    """Frames other than one."""
    samples = gyroid(17 if quick else 33).astype(np.float32)
    cos, sin = np.cos(0.5), np.sin(0.5)
    frames = {
        "1 : 1 : 1e6": diagonal(1.0, 1.0, 1e6),
        "1e-12": diagonal(1e-12, 1e-12, 1e-12),
        "x mirrored": diagonal(-1.0, 1.0, 2.0),
        "turned about z": ((cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)),
    }
    for name, directions in frames.items():
        yield Case(name, samples, 0.1, directions=directions)
        yield Case(f"{name}, whole", rounded(samples, 50), 5, directions=directions)


@item(14, "spacing 0.1 at 6.4e6")
def far_away(quick: bool) -> Iterator[Case]:
    """f32 has steps of 0.5 there: five samples."""
    samples = gyroid(17 if quick else 33).astype(np.float32)
    place = {"directions": diagonal(0.1, 0.1, 0.1), "origin": (6.4e6,) * 3}
    yield Case("f32", samples, 0.1, **place)
    yield Case("whole", rounded(samples, 50), 5, **place)


@item(15, "sizes of one, of two, primes, around a word")
def sizes(quick: bool) -> Iterator[Case]:
    """x by y by z samples, integers from -2 to 2."""
    draw = chance(15)
    odd = [(1, 1, 1), (1, 5, 4), (5, 1, 4), (5, 4, 1), (1, 1, 9), (2, 2, 2), (7, 11, 13)]
    words = [(nx, 3, 2) for nx in (63, 64, 65, 127, 128, 129)]
    for dims in odd + words:
        name = "×".join(map(str, dims))
        yield Case(name, draw.integers(-2, 3, dims[::-1], dtype=np.int8), 0)


@item(16, "4097 samples along x")
def long_rows(quick: bool) -> Iterator[Case]:
    """Longer rows than any buffer of a round size."""
    rows = (3, 2) if quick else (17, 9)
    yield Case("i8", chance(16).integers(-2, 3, (*rows, 4097), dtype=np.int8), 0)


@item(17, "a surface through the border")
def through_the_border(quick: bool) -> Iterator[Case]:
    """A ball that the volume cuts on all six sides."""
    field = ball(15 if quick else 65, 1.1)
    yield Case("f32", field.astype(np.float32), 0)
    yield Case("whole", rounded(field, 99), 0)


@item(18, "a sheet one sample thick")
def sheet(quick: bool) -> Iterator[Case]:
    """On labels, and a plate far thinner than a cell."""
    labels = np.zeros((9, 9, 9), np.int16)
    labels[4, 1:8, 1:8] = 1
    yield Case("labels, iso 1", labels, 1)
    yield Case("labels, iso 0.5", labels, 0.5)
    z = lattice(17)[2]
    yield Case("plate", 1e-9 - np.abs(z), 0)


@item(19, "balls that touch in a point")
def touching(quick: bool) -> Iterator[Case]:
    """Between samples, and on one."""
    for n in (16, 17, 20, 21):
        x, y, z = lattice(n)
        balls = [0.5 - np.sqrt((x - side) ** 2 + y**2 + z**2) for side in (-0.5, 0.5)]
        yield Case(f"{n}³", np.maximum(*balls), 0)
        yield Case(f"{n}³, whole", rounded(np.maximum(*balls), 99), 0)


def face_saddles(count: int) -> np.ndarray:
    """Cells whose three faces at one corner have their saddle on 0 exactly.

    With corner a and its neighbours -b, -c, -d, the corners across are bc/a, bd/a and cd/a.
    """
    draw = chance(20)
    cells = np.empty((count, 2, 2, 2), np.int16)
    for cell in cells:
        a = 2 ** int(draw.integers(0, 3))
        b, c, d = (a * int(n) for n in draw.integers(1, 9, 3))
        far = int(draw.integers(-60, 61))
        cell[:] = [[[a, -b], [-c, b * c // a]], [[-d, b * d // a], [c * d // a, far]]]
        axes = tuple(np.flatnonzero(draw.random(3) < 0.5))
        cell[:] = np.flip(cell, axes) * draw.choice([-1, 1])
    return cells


@item(20, "saddles of faces on the isovalue")
def faces_on_iso(quick: bool) -> Iterator[Case]:
    """Alone, and within a volume."""
    cells = face_saddles(64)
    for n, cell in enumerate(cells[:4]):
        yield Case(f"cell {n}", cell, 0)
    yield Case("64 cells below", tiles(cells, -1), 0)
    yield Case("64 cells above", tiles(cells, 1), 0)


def body_saddles() -> np.ndarray:
    """Cells in which a saddle of the trilinear field has the value 0 exactly.

    XYZ is 0 at its triple saddle; XYZ − X − Y − Z + 2 is 0 at its saddle (1, 1, 1).
    """
    cells = []
    for low, high in product((-1, -2, -3), (1, 2, 5)):
        z, y, x = np.meshgrid(*[(low, high)] * 3, indexing="ij")
        cells.append(x * y * z)
    for low, high in product((0, -1, -2), (2, 3, 4)):
        z, y, x = np.meshgrid(*[(low, high)] * 3, indexing="ij")
        cells.append(x * y * z - x - y - z + 2)
    cells += [-cell for cell in cells[:9]]
    return np.array(cells, np.int16)


@item(21, "saddles of cells on the isovalue")
def bodies_on_iso(quick: bool) -> Iterator[Case]:
    """Alone, and within a volume."""
    cells = body_saddles()
    yield Case("triple", cells[0], 0)
    yield Case("single", cells[10], 0)
    yield Case("27 cells below", tiles(cells, -1), 0)
    yield Case("27 cells above", tiles(cells, 1), 0)


@item(22, "scikit-image 8109 and 8116")
def reported(quick: bool) -> Iterator[Case]:
    """The grid of the first report, and integers from -1 to 1 as in the second."""
    grid = np.array([13, -1, -1, -7, -1, 1, 7, -7, 15, -9, -3, -1], np.float32)
    yield Case("8109", grid.reshape(3, 2, 2), 0)
    yield Case("8109 within", np.pad(grid.reshape(3, 2, 2), 1, constant_values=-1), 0)
    small = chance(22).integers(-1, 2, (512, 3, 2, 2), dtype=np.int8)
    yield Case("8116: 512 grids", tiles(small, -2), 0)


@item(23, "strided, backward, Fortran and big-endian layouts")
def layouts(quick: bool) -> Iterator[Case]:
    """The same values each time: the same mesh."""
    samples = chance(23).integers(-1000, 1000, (8, 7, 6), dtype=np.int16)
    yield Case("plain", samples, 0.5)
    yield Case("Fortran", np.asfortranarray(samples), 0.5, same_as="plain")
    yield Case("big-endian", samples.astype(">i2"), 0.5, same_as="plain")
    for view in ("every second", "backwards"):
        yield Case(view, samples, 0.5, view=view, same_as="plain")


@item(24, "a large volume, all inside")
def all_inside(quick: bool) -> Iterator[Case]:
    """Nothing, or with a closed border a box."""
    n = 128 if quick else 512
    yield Case(f"{n}³ u8", np.full((n, n, n), 9, np.uint8), 4)


@item(25, "any bits as f32")
def any_bits(quick: bool) -> Iterator[Case]:
    """NaN, infinities and denormals among all magnitudes."""
    n = 16 if quick else 64
    bits = chance(25).integers(0, 2**32, (n, n, n), dtype=np.uint32)
    yield Case("f32", bits.view(np.float32), 0)
