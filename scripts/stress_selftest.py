#!/usr/bin/env python3
"""Shows that the judge of `scripts/stress` can fail a mesh, and that its inputs are as said.

A sound mesh has no fault; each spoilt one has its own fault and no other. Needs numpy only.
"""

import sys
from itertools import combinations, product

import numpy as np

from kit import stress_shapes, stress_values
from kit.stress_case import IDENTITY, ITEMS, Case, in_types, seen
from kit.stress_check import CRITERIA, Allowed, Mesh, faults
from kit.stress_isokit import COUNTERS, in_type, misreported, shape_differs
from kit.stress_modes import APART, CHOICES, PLAIN, Mode, Pair, pairwise
from kit.tally import Tally

assert stress_values and stress_shapes  # they fill the list

BOX = np.zeros((3, 3, 3), np.float32)
BOX[1, 1, 1] = 2
CASE = Case("one sample", BOX, 1)
"""One sample inside: the surface is an octahedron around it."""

CORNERS = np.array(
    [[1.5, 1, 1], [0.5, 1, 1], [1, 1.5, 1], [1, 0.5, 1], [1, 1, 1.5], [1, 1, 0.5]], np.float32
)
FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
)
CLOSED = Allowed(turned_out=False)


def wrong(mesh: Mesh, case: Case = CASE, allowed: Allowed = CLOSED) -> set[str]:
    """The criteria that a mesh fails."""
    return {key for key, count in faults(mesh, case, allowed).items() if count}


def moved(vertex: int, to: list[float]) -> Mesh:
    """The octahedron with a vertex elsewhere."""
    corners = CORNERS.copy()
    corners[vertex] = to
    return Mesh(corners, FACES)


def spoilt() -> dict[str, tuple[Mesh, set[str]]]:
    """Meshes with the faults that they must have."""
    turned, doubled, other = FACES.copy(), np.vstack([FACES, FACES[:1]]), FACES.copy()
    turned[0] = turned[0, ::-1]
    other[0, 0] = 9
    two = np.vstack([FACES, np.where(FACES == 4, 4, FACES + 6)])
    apart = np.vstack([CORNERS, CORNERS + np.float32([0, 0, 0.03])])
    apart[10] = apart[4]
    unused = np.vstack([CORNERS, CORNERS[:1]])
    normals = np.full((6, 3), np.nan)
    return {
        "nothing": (Mesh(CORNERS[:0], FACES[:0]), {"empty"}),
        "a name that is not there": (Mesh(CORNERS, other), {"index", "open", "volume"}),
        "a normal that is no number": (Mesh(CORNERS, FACES, normals), {"number"}),
        "a vertex that is no number": (moved(0, [np.nan, 1, 1]), {"number", "volume"}),
        "a vertex more": (Mesh(unused, FACES), {"unused"}),
        "a triangle less": (Mesh(CORNERS, FACES[1:]), {"open", "volume"}),
        "a triangle turned": (Mesh(CORNERS, turned), {"turned", "volume"}),
        "a triangle twice": (Mesh(CORNERS, doubled), {"over", "double", "volume"}),
        "two in a vertex": (Mesh(apart, two), {"fans", "unused"}),
        "inside out": (Mesh(CORNERS, FACES[:, ::-1]), {"volume"}),
        "a vertex in another": (moved(0, [1, 1.5, 1]), {"flat"}),
        "a vertex two cells off": (moved(0, [3.5, 1, 1]), {"away"}),
        "a vertex a hair off": (moved(0, [2 + 1e-4, 1, 1]), {"away"}),
    }


def meshes(tally: Tally) -> None:
    """Sound and spoilt ones."""
    tally.check("octahedron", "no fault", wrong(Mesh(CORNERS, FACES)) == set())
    for name, (mesh, expected) in spoilt().items():
        found = wrong(mesh)
        tally.check(name, f"has {', '.join(sorted(expected))}", found == expected, found)
    seen_faults = set().union(*(expected for _, expected in spoilt().values()))
    never = set(CRITERIA) - seen_faults - {"differs", "report"}
    tally.check("criteria", "each is failed by a spoilt mesh", not never, never)
    comparisons(tally)


def comparisons(tally: Tally) -> None:
    """The two criteria that compare: a mesh with another, and with its report."""
    mesh = Mesh(CORNERS, FACES)
    tally.check("the same", "does not differ", shape_differs(mesh, Mesh(CORNERS, FACES)) == 0)
    bit = CORNERS.copy()
    bit[3, 1] = np.nextafter(bit[3, 1], np.float32(9))
    turned = FACES.copy()
    turned[5] = np.roll(turned[5], 1)
    for name, other in {
        "a bit of a place": Mesh(bit, FACES),
        "a triangle from another corner": Mesh(CORNERS, turned),
        "none": None,
    }.items():
        tally.check(name, "differs", shape_differs(mesh, other) == 1)
    normals = np.zeros((6, 3), np.float32)
    shaded, other = Mesh(CORNERS, FACES, normals), Mesh(CORNERS, FACES, normals + 1)
    tally.check("normals", "are compared where samples are the same", not shaded.same_as(other))
    tally.check("normals", "are not where types differ", shape_differs(shaded, other) == 0)
    right = {"vertices": 6, "triangles": 8} | dict.fromkeys(COUNTERS, 0)
    tally.check("a report", "is right", misreported(right, mesh, PLAIN) == 0)
    for key in right:
        wrong_by_one = right | {key: right[key] + 1}
        tally.check(f"a report, {key}", "is wrong", misreported(wrong_by_one, mesh, PLAIN) == 1)


def allowances(tally: Tally) -> None:
    """What is excused, and only there."""
    pointed = moved(0, [1, 1.5, 1])
    exact = wrong(pointed, CASE, Allowed(turned_out=False, flat=True))
    tally.check("a vertex in another", "is lawful if exact", exact == set(), exact)
    half = Case("half", np.float32([[[2, 2], [2, 2]], [[0, 0], [0, 0]]]), 1)
    sheet = np.float32([[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]])
    mesh = Mesh(sheet, np.array([[0, 1, 2], [0, 2, 3]]))
    tally.check("sheet", "ends at the border", wrong(mesh, half, Allowed(border=True)) == set())
    tally.check("sheet", "or may not", wrong(mesh, half, Allowed()) == {"open"})
    hole = Mesh(CORNERS, FACES[1:])
    tally.check("hole", "not within", "open" in wrong(hole, CASE, Allowed(border=True)))
    none, ties = Mesh(CORNERS[:0], FACES[:0]), Case("ties", BOX, 2)
    own = Allowed(on_is_either=False)
    tally.check("a tie", "may be outside", wrong(none, ties) == set())
    tally.check("a tie", "is inside of isokit", wrong(none, ties, own) == {"empty"})
    full = Case("full", BOX, 0)
    tally.check("all inside", "need not be closed", wrong(none, full) == set())
    tally.check("all inside", "is closed by isokit", wrong(none, full, own) == {"empty"})
    rim = Allowed(border=True, on_is_either=False)
    tally.check("all inside", "has no surface if open", wrong(none, full, rim) == set())
    apart = wrong(Mesh(CORNERS, FACES), ties)
    tally.check("on a tie", "is beside both sides", "away" not in apart, apart)
    low = Case("low", np.where(BOX == 2, np.float32(1), BOX), 1)
    there = Mesh(CORNERS + np.float32([0, 0, 1]), FACES)
    tally.check("beside a tie", "is in its cells", wrong(Mesh(CORNERS, FACES), low, own) == set())
    tally.check("off a tie", "is not", "away" in wrong(there, low, own), wrong(there, low, own))
    gap = BOX.copy()
    gap[2, 2, 2] = np.nan
    excused = wrong(hole, Case("gap", gap, 1), Allowed(gaps=True))
    tally.check("hole", "around a NaN", excused == set(), excused)
    tenth = tuple(map(tuple, 0.1 * np.eye(3)))
    far = Case("far", np.pad(BOX, 2), 1, directions=tenth, origin=(6.4e6,) * 3)
    place = (CORNERS.astype(np.float64) + 2) * 0.1 + 6.4e6
    tally.check("far away", "f64 is in its cells", wrong(Mesh(place, FACES), far) == set())
    coarse = wrong(Mesh(place.astype(np.float32), FACES), far)
    tally.check("far away", "f32 is not", "away" in coarse, coarse)


def inputs(tally: Tally) -> None:
    """All 25, the same in each run, and in every type that holds them."""
    tally.check("list", "has 25 items", sorted(ITEMS) == list(range(1, 26)), sorted(ITEMS))
    for number, item in ITEMS.items():
        cases = list(item.cases(True))
        names = [case.name for case in cases]
        subject = f"{number} {item.name}"
        tally.check(subject, "cases have names of their own", len(set(names)) == len(names) > 0)
        same = all(
            case.samples.tobytes() == again.samples.tobytes()
            for case, again in zip(cases, item.cases(True), strict=True)
        )
        tally.check(subject, "chance is the same again", same)
        exact = all(alike(case, other) for case in cases for other in in_types(case))
        tally.check(subject, "other types hold the same values", exact)
        views = [(seen(case.samples, case.view), case.samples) for case in cases if case.view]
        plain = all(np.array_equal(view, samples) for view, samples in views)
        tally.check(subject, "views show the same values", plain)
    whole = Case("whole", np.array([[[-1, 3]]], np.int8), 0)
    found = [case.samples.dtype.str[1:] for case in in_types(whole)]
    others = ["u1", "u2", "i2", "u4", "i4", "f4", "f8"]
    tally.check("whole numbers", "go into all types", found == others, found)
    kinds = {name: in_type(whole, Mode(dtype=name)) for name in ("own", "integer", "float")}
    found = "".join(case.samples.dtype.kind for case in kinds.values())
    tally.check("modes", "ask for types", found in ("iif", "iuf") and kinds["own"] is whole, found)
    turns = {in_type(whole, Mode(dtype="integer", simd=str(n))).name for n in range(9)}
    tally.check("modes", "ask for all types in turn", len(turns) == 5, turns)
    half = in_type(Case("half", np.array([[[0.5]]]), 0), Mode(dtype="integer"))
    tally.check("halves", "stay what they are", half.samples.dtype == np.float64)
    tally.check("frame", "is the identity", np.array_equal(IDENTITY, np.eye(3)))


def alike(case: Case, other: Case) -> bool:
    """Whether two cases have the same values less their isovalues."""
    with np.errstate(invalid="ignore"):
        one, two = (c.samples.astype(np.float64) - float(c.iso) for c in (case, other))
    # A shift of both is exact for whole numbers, which are all that are shifted.
    return np.array_equal(one, two, equal_nan=True)


def rows(tally: Tally) -> None:
    """Every two answers meet, but for those that are to stay apart, whatever the machine has."""
    for levels, floats in product((1, 2, 3), (1, 2)):
        has = {"simd": CHOICES["simd"][:levels], "floats": CHOICES["floats"][:floats]}
        paired(tally, CHOICES | has, APART, most=25)
    few = {"a": ["1", "2"], "b": ["1", "2", "3"], "c": ["1", "2"], "d": ["1", "2", "3"]}
    apart = frozenset({frozenset({("a", "2"), ("b", "3")}), frozenset({("c", "1"), ("d", "2")})})
    paired(tally, few, apart, most=19)


def paired(tally: Tally, choices: dict[str, list[str]], apart: frozenset[Pair], most: int) -> None:
    """All rows of these choices."""
    made = pairwise(choices, apart)
    for one, other in combinations(choices, 2):
        met = {(row[one], row[other]) for row in made}
        pairs = set(product(choices[one], choices[other]))
        wanted = {(x, y) for x, y in pairs if frozenset({(one, x), (other, y)}) not in apart}
        tally.check(f"{one} and {other}", "the right pairs meet", met == wanted, met ^ wanted)
    tally.check("rows", "are fewer than all", len(made) <= most, len(made))


def main() -> int:
    """All of it."""
    tally = Tally("stress_selftest", quiet=True)
    meshes(tally)
    allowances(tally)
    inputs(tally)
    rows(tally)
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
