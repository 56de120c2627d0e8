"""Items 1 to 12 of the stress list: values on which extractors break. Needs numpy."""

from collections.abc import Iterator

import numpy as np

from kit.stress_case import Case, ball, board, chance, gyroid, item, tiles


@item(1, "all samples on the isovalue")
def all_ties(quick: bool) -> Iterator[Case]:
    """Nothing but ties."""
    yield Case("u16", np.full((6, 5, 4), 7, np.uint16), 7)
    yield Case("f32", np.full((6, 5, 4), 0.1, np.float32), float(np.float32(0.1)))


@item(2, "one sample on the isovalue")
def one_tie(quick: bool) -> Iterator[Case]:
    """One tie below, one above."""
    for sign in (-1, 1):
        samples = np.full((5, 5, 5), sign, np.float32)
        samples[2, 2, 2] = 0
        yield Case(f"among {sign}", samples, 0)


@item(3, "checkerboard")
def checkerboard(quick: bool) -> Iterator[Case]:
    """Every edge is cut."""
    n = 9 if quick else 33
    yield Case("i8", np.where(board(n), 1, -1).astype(np.int8), 0)
    yield Case("f32", np.where(board(n), 1, -1).astype(np.float32), 0.25)


@item(4, "integers from -3 to 3, volumes of 7³")
def small_integers(quick: bool) -> Iterator[Case]:
    """Ties everywhere: 10,000 volumes, 64 in the small form."""
    side, stacks = (4, 1) if quick else (10, 10)
    draw = chance(4)
    for stack in range(stacks):
        volumes = draw.integers(-3, 4, (side**3, 7, 7, 7), dtype=np.int8)
        yield Case(f"{side**3} volumes, {stack}", tiles(volumes, -4), 0)


@item(5, "bytes by chance, between two and on one")
def bytes_by_chance(quick: bool) -> Iterator[Case]:
    """Noise of 8 bits."""
    n = 16 if quick else 64
    noise = chance(5).integers(0, 256, (n, n, n), dtype=np.uint8)
    yield Case("127.5", noise, 127.5)
    yield Case("128", noise, 128)


@item(6, "isovalues at the ends of the range; -0.0 and 0.0")
def ends(quick: bool) -> Iterator[Case]:
    """At and one beyond the least and the greatest sample."""
    noise = chance(6).integers(-4, 5, (7, 5, 6), dtype=np.int32)
    for iso in (-4, 4, -5, 5):
        yield Case(f"iso {iso}", noise, iso)
    zeros = np.where(chance(6).random((6, 6, 6)) < 0.5, np.float32(0), np.float32(-1))
    yield Case("0.0", zeros, 0)
    yield Case("-0.0", np.where(zeros == 0, np.float32(-0.0), zeros), 0, same_as="0.0")


@item(7, "the least and the greatest i32 in turn")
def integer_extremes(quick: bool) -> Iterator[Case]:
    """Differences that no i32 holds."""
    limits = np.iinfo(np.int32)
    yield Case("i32", np.where(board(6), limits.max, limits.min).astype(np.int32), 0)


@item(8, "±3.4e38 in turn")
def float_extremes(quick: bool) -> Iterator[Case]:
    """Differences that no f32 holds."""
    samples = np.where(board(6), np.float32(3.4e38), np.float32(-3.4e38))
    yield Case("iso 0", samples, 0)
    yield Case("iso -3e38", samples, -3e38)


@item(9, "denormal numbers")
def denormals(quick: bool) -> Iterator[Case]:
    """0 to 3 times the least number of f32 that is not 0."""
    samples = chance(9).integers(0, 4, (8, 8, 8), dtype=np.uint32).view(np.float32)
    yield Case("on a sample", samples, float(np.float32(1e-45)))
    yield Case("between samples", samples, 2e-45)


@item(10, "a little noise on a large number")
def offset_noise(quick: bool) -> Iterator[Case]:
    """16 steps of f32 within the noise: ties by rounding."""
    n = 12 if quick else 48
    samples = (1e6 + chance(10).random((n, n, n))).astype(np.float32)
    yield Case("iso on a step", samples, 1000000.5)
    yield Case("iso between steps", samples, 1000000.49)


@item(11, "a field times 1e-30 and 1e30")
def scaled(quick: bool) -> Iterator[Case]:
    """Tiny and huge values."""
    field = gyroid(17 if quick else 33)
    for factor in (1e-30, 1e30):
        yield Case(f"times {factor:g}", (field * factor).astype(np.float32), 0.1 * factor)


@item(12, "NaN: one, a slice, half of all; infinities")
def gaps(quick: bool) -> Iterator[Case]:
    """Samples without a value."""
    whole = ball(13, 0.7).astype(np.float32)
    one, layer, half = whole.copy(), whole.copy(), whole.copy()
    one[2, 6, 6] = np.nan
    layer[5] = np.nan
    half[chance(12).random(half.shape) < 0.5] = np.nan
    yield Case("one NaN", one, 0)
    yield Case("a slice of NaN", layer, 0)
    yield Case("half NaN", half, 0)
    infinite = chance(12).choice([np.inf, -np.inf, 1, -1], (8, 8, 8)).astype(np.float32)
    yield Case("infinities", infinite, 0)
