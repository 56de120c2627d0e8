"""The modes of the program that the stress list asks for, and how few runs pair them all.

A surface is said by six options. The other choices must not change a byte of it, so a mesh is
compared with that of its plain mode and only the plain one is looked at. Standard library only.
"""

import os
import platform
import subprocess
import tempfile
from dataclasses import asdict, dataclass, replace
from itertools import combinations, product
from pathlib import Path

from kit.program import Isokit

FLUSH = """\
#include <xmmintrin.h>
__attribute__((constructor)) static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
"""
"""A library that has denormal numbers taken for 0 (DAZ, FTZ) in the process that loads it.

This is what code compiled with `-ffast-math` does to whoever loads it.
"""


@dataclass(frozen=True)
class Mode:
    """What is asked of the program."""

    topology: str = "table"
    placement: str = "linear"
    normals: str = "gradient"
    boundary: str = "closed"
    degenerate: str = "never"
    diagonals: str = "table"
    threads: str = "1"
    simd: str = "portable"
    memory: str = "whole"
    """All at once; some slices at a time; or with an index of bricks."""
    floats: str = "usual"
    dtype: str = "own"
    """Samples of the case's own type; of another type of integers or of floats that holds them."""

    @property
    def plain(self) -> "Mode":
        """The mode that must give the same bytes."""
        others = ("threads", "simd", "memory", "floats", "dtype")
        return replace(self, **{name: getattr(PLAIN, name) for name in others})

    def __str__(self) -> str:
        """As a message names it."""
        return ", ".join(asdict(self).values())

    def options(self) -> list[str]:
        """For the command line."""
        fixed = ["--nan", "outside", "--quiet"]
        memory = {"whole": [], "sliced": ["--max-memory", "512MiB"], "indexed": ["--index"]}
        named = ("topology", "placement", "normals", "boundary", "degenerate", "diagonals")
        chosen = [part for n in (*named, "threads") for part in (f"--{n}", getattr(self, n))]
        return fixed + memory[self.memory] + chosen


PLAIN = Mode()
"""The first answer to each question."""

NOT_FITTED = (("memory", "sliced"), ("dtype", "integer"), ("dtype", "float"))
"""What fitted diagonals do not meet: they need the whole mesh, and they follow normals, which are
rounded otherwise in other types.
"""

APART = frozenset(frozenset({("diagonals", "fitted"), other}) for other in NOT_FITTED)
"""Answers that do not meet."""

CHOICES = {
    "topology": ["table", "trilinear"],
    "placement": ["linear", "cubic", "quintic"],
    "normals": ["gradient", "matching"],
    "boundary": ["closed", "open"],
    "degenerate": ["never", "exact"],
    "diagonals": ["table", "fitted"],
    "threads": ["1", "2"],
    "simd": ["portable", "avx2", "avx512"],
    "memory": ["whole", "sliced", "indexed"],
    "floats": ["usual", "flushed"],
    "dtype": ["own", "integer", "float"],
}
"""All answers to each question; a machine may lack some of `simd` and `floats`."""

LISTED = replace(PLAIN, topology="trilinear", placement="quintic", threads="2", simd="")
"""The mode for volumes of the listed size: the program's own choices."""


class Modes:
    """The program and what its machine has."""

    def __init__(self, isokit: Isokit, scratch: Path) -> None:
        """Tries the instructions, and builds the library that flushes."""
        self.isokit, self.library = isokit, None
        if platform.system() == "Linux" and platform.machine() == "x86_64":
            self.library = build(scratch)
        levels = [name for name in CHOICES["simd"] if self._has(name)]
        floats = CHOICES["floats"] if self.library else ["usual"]
        self.choices = CHOICES | {"simd": levels, "floats": floats}
        self.pairs = [Mode(**row) for row in pairwise(self.choices, APART)]

    def program(self, mode: Mode) -> Isokit:
        """The program in the environment of a mode."""
        environment = {"ISOKIT_SIMD": mode.simd}
        if mode.floats == "flushed":
            environment["LD_PRELOAD"] = str(self.library)
        return Isokit(self.isokit.path, environment)

    def described(self) -> str:
        """For people: each choice and its answers."""
        return "; ".join(f"{name} {' | '.join(found)}" for name, found in self.choices.items())

    def _has(self, level: str) -> bool:
        """Whether the machine has these instructions, by the program's report."""
        volume = "fixtures/volumes/ties.npy"
        project = Path(__file__).resolve().parents[2]
        with tempfile.TemporaryDirectory() as folder:
            program = Isokit(self.isokit.path, {"ISOKIT_SIMD": level})
            report = program.extract(project / volume, Path(folder, "a.ply"), "--iso=0")
        return report["simd"] == level


def build(scratch: Path) -> Path:
    """Compiles the library that flushes, with the compiler that Rust links with."""
    source, library = scratch / "flush.c", scratch / "flush.so"
    source.write_text(FLUSH)
    subprocess.run(
        [os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", library, source], check=True
    )
    return library


Pair = frozenset[tuple[str, str]]
"""Answers to two questions."""


def pairwise(choices: dict[str, list[str]], apart: frozenset[Pair]) -> list[dict[str, str]]:
    """Rows in which every two answers to two questions meet, but for those that are to stay apart.
    Greedy, so a few more than needed. Each question needs an answer that meets all others.
    """
    names = list(choices)
    left = {
        frozenset({(a, one), (b, other)})
        for a, b in combinations(names, 2)
        for one, other in product(choices[a], choices[b])
    } - apart
    rows = []
    while left:
        row: dict[str, str] = dict(min(left, key=sorted))
        for name in names:
            if name not in row:
                rest = [one for one in choices[name] if not met(row | {name: one}) & apart]
                row[name] = max(rest, key=lambda answer: len(left & met(row | {name: answer})))
        left -= met(row)
        rows.append(row)
    return rows


def met(row: dict[str, str]) -> set[Pair]:
    """The pairs of answers in a row."""
    return {frozenset(pair) for pair in combinations(row.items(), 2)}
