"""What is wrong with a mesh, found the plain way: by sorting sides. Needs numpy.

The same function judges every tool. It knows the volume and the mesh, and nothing of who made it.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from kit.stress_case import Case

CRITERIA = {
    "index": "triangles that name a vertex which is not there",
    "number": "vertices whose coordinates or normals are not finite",
    "unused": "vertices that no triangle uses",
    "empty": "1 if there is no triangle although samples lie on both sides of the isovalue; of "
    "isokit, where one on it is inside, and closed surfaces end outside of all samples",
    "away": "used vertices that lie in no cell with samples on both sides of the isovalue",
    "open": "sides of one triangle only, away from the border of the volume",
    "turned": "sides of two triangles that both use in the same direction",
    "over": "sides of more than two triangles",
    "fans": "vertices whose triangles are not one fan",
    "flat": "triangles without area",
    "double": "triangles with the same three corners as another, equal positions merged",
    "volume": "1 if the volume within is not above 0, or not the same along x, y and z to 1e-9; "
    "for isokit's closed surfaces only",
    "differs": "meshes that are not that of the same values in another layout, type or mode",
    "report": "1 if isokit's own report counts otherwise",
}
"""What is counted, by the words of the table. All must be 0."""

AREAS = ("flat", "double")
"""The criteria on how triangles lie; the others are on what is there and how it is connected."""

AWAY = 1e-5
"""How far outside its cell a vertex may lie, in samples: in f32 those of turned lattices are rounded, by a tenth of it
on volumes of the list's extent.
"""


@dataclass(frozen=True)
class Allowed:
    """Where a surface may end, and what it may be."""

    border: bool = False
    """It may end at the volume's border."""
    gaps: bool = False
    """It may end in cells that touch a NaN."""
    turned_out: bool = True
    """It need not enclose a volume."""
    flat: bool = False
    """Triangles may have no area, and vertices lie where others do."""
    on_is_either: bool = True
    """A sample on the isovalue may be inside or outside, since tools differ there; else it is inside."""
    reach: float = 2e-3
    """Samples from the border that still count as on it."""


@dataclass
class Mesh:
    """Vertices in world coordinates x, y, z, and triangles that name them."""

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None

    def same_as(self, other: "Mesh") -> bool:
        """Whether both are the same, bit for bit."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return all(bits(one) == bits(another) for one, another in pairs)


def bits(array: np.ndarray | None) -> tuple | None:
    """Type and content."""
    return None if array is None else (array.dtype.str, array.shape, array.tobytes())


def faults(mesh: Mesh, case: Case, allowed: Allowed) -> dict[str, int]:
    """Everything that is wrong, counted."""
    found = dict.fromkeys(CRITERIA, 0)
    triangles = mesh.triangles.astype(np.int64).reshape(-1, 3)
    count = len(mesh.vertices)
    lawful = ((triangles >= 0) & (triangles < count)).all(axis=1)
    found["index"] = int((~lawful).sum())
    triangles = triangles[lawful]
    finite = np.isfinite(mesh.vertices).all(axis=1)
    sound = finite.copy()
    if mesh.normals is not None:
        sound &= np.isfinite(mesh.normals).all(axis=1)
    found["number"] = int((~sound).sum())
    is_used = np.zeros(count, bool)
    is_used[triangles] = True
    found["unused"] = int((~is_used).sum())
    found["empty"] = int(len(triangles) == 0 and crossed(case, allowed))
    with np.errstate(all="ignore"):
        free = np.zeros(count, bool)
        places = ijk(mesh.vertices, case)
        if allowed.gaps and has_nan(case.samples):
            free |= beside_gaps(places, case.samples)
        found["away"] = int((away(places, case, allowed) & is_used & finite & ~free).sum())
        connections(found, triangles, borders(places, case, allowed), free)
        if not allowed.flat:
            areas(found, triangles, mesh.vertices)
        if not allowed.turned_out and len(triangles) > 0:
            found["volume"] = int(not encloses(mesh.vertices, triangles))
    return found


def has_nan(samples: np.ndarray) -> bool:
    """Whether there are samples without a value."""
    return samples.dtype.kind == "f" and bool(np.isnan(samples).any())


def crossed(case: Case, allowed: Allowed) -> bool:
    """Whether a surface must be there: samples on both sides, in cells and all of them numbers.

    Where one on the isovalue is inside, NaN is outside; and a closed surface needs one inside only.
    """
    iso = np.float64(case.iso)
    if not allowed.on_is_either:
        inside = case.samples.astype(np.float64) >= iso
        if not allowed.border:
            return bool(inside.any())
        shape = case.samples.shape
        return min(shape) > 1 and bool(inside.any() and not inside.all())
    if has_nan(case.samples) or min(case.samples.shape) < 2:
        return False
    return bool((case.samples < iso).any() and (case.samples > iso).any())


def ijk(points: np.ndarray, case: Case) -> np.ndarray:
    """World coordinates as places in the volume, in samples along x, y, z."""
    return (points.astype(np.float64) - case.origin) @ np.linalg.inv(np.array(case.directions))


def borders(places: np.ndarray, case: Case, allowed: Allowed) -> np.ndarray:
    """For each vertex, on which of the six sides of the volume it lies, as bits."""
    bits = np.zeros(len(places), np.int64)
    if not allowed.border:
        return bits
    # What f32 cannot tell apart so far from the origin is not told apart here.
    steps = np.linalg.norm(np.array(case.directions), axis=1)
    reach = allowed.reach + np.spacing(np.float32(max(map(abs, case.origin)))) / steps.min()
    for axis, n in enumerate(reversed(case.samples.shape)):
        bits |= (np.abs(places[:, axis]) <= reach) << (2 * axis)
        bits |= (np.abs(places[:, axis] - (n - 1)) <= reach) << (2 * axis + 1)
    return bits


def away(places: np.ndarray, case: Case, allowed: Allowed) -> np.ndarray:
    """For each vertex, whether no cell that it lies in has samples on both sides of the isovalue.

    Where a sample on the isovalue may be on either side it is on both. One that is NaN, and what
    lies beyond the border, is below.
    """
    lost = np.ones(len(places), bool)
    last = np.array(case.samples.shape)
    here = np.nan_to_num(places[:, ::-1], nan=-9, posinf=-9, neginf=-9)
    here = np.clip(here, -2, last + 2.0)
    for side in product((-AWAY, AWAY), repeat=3):
        left = np.flatnonzero(lost)
        cell = np.floor(here[left] + side).astype(np.int64)
        above, below = np.zeros(len(left), bool), np.zeros(len(left), bool)
        for corner in np.ndindex(2, 2, 2):
            at = cell + corner
            within = ((at >= 0) & (at < last)).all(axis=1)
            at = np.clip(at, 0, last - 1)
            sample = case.samples[tuple(at.T)].astype(np.float64)
            above |= within & (sample >= case.iso)
            is_below = ~(sample > case.iso) if allowed.on_is_either else ~(sample >= case.iso)
            below |= ~within | is_below
        lost[left] = ~(above & below)
    return lost


def beside_gaps(places: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """For each vertex, whether its cell or one beside it touches a NaN."""
    gap = np.isnan(samples)
    padded = np.pad(gap, 2)
    near = np.zeros_like(padded)
    for shift in np.ndindex(5, 5, 5):
        near |= np.roll(padded, np.array(shift) - 2, axis=(0, 1, 2))
    there = np.nan_to_num(places, nan=-2)[:, ::-1]
    there = np.clip(np.floor(there), -2, samples.shape).astype(np.int64) + 2
    return near[tuple(there.T)] | ~np.isfinite(places).all(axis=1)


def connections(
    found: dict[str, int], triangles: np.ndarray, on: np.ndarray, free: np.ndarray
) -> None:
    """Sides and fans. A triangle that names a vertex twice has no sides of its own."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    if len(triangles) == 0:
        return
    tails, heads = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    key = low * len(on) + high
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    uses = np.diff(starts, append=len(key))
    balance = np.add.reduceat(np.where(tails < heads, 1, -1)[order], starts)
    first = order[starts]
    excused = free[low[first]] & free[high[first]]
    at_border = (on[low[first]] & on[high[first]]) != 0
    found["open"] = int(((uses == 1) & ~at_border & ~excused).sum())
    found["turned"] = int(((uses == 2) & (balance != 0) & ~excused).sum())
    found["over"] = int(((uses > 2) & ~excused).sum())
    found["fans"] = int((fans(triangles, order, uses) & ~free[used(triangles.ravel())]).sum())


def fans(triangles: np.ndarray, order: np.ndarray, uses: np.ndarray) -> np.ndarray:
    """For each used vertex, whether its triangles fall into several fans.

    A corner is a vertex in a triangle. Two corners of a vertex hang together if their triangles
    share a side that ends there.
    """
    same = np.ones(len(order), bool)
    same[np.cumsum(uses) - 1] = False
    one = order[np.flatnonzero(same)]
    other = order[np.flatnonzero(same) + 1]
    # Side n of a triangle leads from corner n to the next; number of corner = number of side.
    following = np.arange(len(order)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    vertex = triangles.ravel()
    links = []
    for ends in (one, following[one]):
        there = np.where(vertex[other] == vertex[ends], other, following[other])
        links.append(np.stack([ends, there]))
    left, right = np.concatenate(links, axis=1)
    label = np.arange(len(vertex))
    while True:
        least = np.minimum(label[left], label[right])
        before = label.copy()
        np.minimum.at(label, left, least)
        np.minimum.at(label, right, least)
        label = label[label]
        if np.array_equal(before, label):
            break
    roots = np.bincount(vertex[label == np.arange(len(label))])
    return roots[used(vertex)] > 1


def used(vertices: np.ndarray) -> np.ndarray:
    """All that are named, each once, in order. They are so many that `np.unique` takes seconds."""
    return np.flatnonzero(np.bincount(vertices))


def areas(found: dict[str, int], triangles: np.ndarray, vertices: np.ndarray) -> None:
    """Triangles without area, or twice there, once equal positions are merged."""
    finite = np.isfinite(vertices).all(axis=1)
    triangles = triangles[finite[triangles].all(axis=1)]
    if len(triangles) == 0:
        return
    places = vertices.astype(np.float64) + 0.0  # -0.0 becomes 0.0
    corners = merged(places)[triangles]
    a, b, c = corners.T
    flat = (a == b) | (b == c) | (c == a)
    p, q, r = (places[triangles[:, n]] for n in range(3))
    flat |= (np.cross(scaled(q - p), scaled(r - p)) == 0).all(axis=1)
    found["flat"] = int(flat.sum())
    solid = np.sort(corners[~flat], axis=1)
    found["double"] = len(solid) - len(np.unique(merged(solid)))


def merged(rows: np.ndarray) -> np.ndarray:
    """A number for each row, the same for equal rows. `np.unique` takes ten times as long by rows."""
    order = np.lexsort(rows.T)
    new = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    number = np.zeros(len(rows), np.int64)
    number[order[1:]] = np.cumsum(new)
    return number


def scaled(sides: np.ndarray) -> np.ndarray:
    """Sides times a power of two, so that no product vanishes; a side of length 0 stays."""
    _, power = np.frexp(np.abs(sides).max(axis=1, keepdims=True))
    return np.ldexp(sides, -power)


def encloses(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether the volume within, as flux of x, of y and of z, is above 0 and thrice the same."""
    p, q, r = (vertices[triangles[:, n]].astype(np.float64) - vertices[0] for n in range(3))
    flux = ((p + q + r) / 3 * np.cross(q - p, r - p) / 2).sum(axis=0)
    return bool((flux > 0).all() and np.ptp(flux) <= 1e-9 * flux.max())
