"""The rows that compare isokit with other programs. Standard library only."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from statistics import median

from kit.bench_measure import RUST_PEERS, Bench, Entry, Series, extract
from kit.bench_peers import PEERS
from kit.bench_volumes import Absent, Store, Volume

EDGES = "vtk Flying Edges"
THREADS = (1, 2)


def fields(bench: Bench, store: Store) -> Iterator[Volume]:
    """The sparse and the dense surface that everything is tried on."""
    n = 128 if bench.quick else 256
    yield store.sphere(n)
    yield store.gyroid(n)


def against_edges(
    bench: Bench, volume: Volume, row: str, threads: int, normals: bool, warm: bool, **wanted: float
) -> None:
    """One line: the same surface by us and by Flying Edges."""
    request = extract(volume, threads=threads, normals=normals, warm=warm)
    entries = [Entry(who, volume, request, warm) for who in ("isokit", EDGES)]
    ours, theirs = bench.run(entries)
    with_normals = "normals" if normals else "no normals"
    bench.compare(
        ours,
        theirs,
        row=row,
        work=f"{volume.name} {volume.dtype}, {with_normals}, {'warm' if warm else 'cold'}, "
        f"{threads} thread{'s' * (threads > 1)}, vs Flying Edges",
        at_least=True,
        remark=counts(ours, theirs),
        **wanted,
    )


def synthetic(bench: Bench, store: Store) -> None:
    """Sphere and gyroid, cold and warm, with and without normals, on one thread and on two."""
    wanted = {False: {"must": 3.0, "aim": 6.0}, True: {"must": 5.0, "aim": 9.0}}
    for volume in fields(bench, store):
        with bench.workers():
            for normals in (True, False):
                for threads in THREADS:
                    for warm in (False, True):
                        limits = wanted[warm] if normals else {}
                        settings = (threads, normals, warm)
                        against_edges(bench, volume, "synthetic", *settings, **limits)


def defaults(bench: Bench, store: Store) -> None:
    """What who changes no option gets: a closed border, what the trilinear interpolant connects, and
    vertices on quintics; and NaN an error, as the program has it.
    """
    for volume in fields(bench, store):
        with bench.workers():
            plain = extract(volume)
            own = {"boundary": "closed", "topology": "trilinear", "placement": "quintic"}
            entries = [
                Entry("isokit", volume, plain | own),
                Entry("isokit", volume, plain | own | {"nan": "error"}),
                Entry(EDGES, volume, plain),
            ]
            library, program, theirs = bench.run(entries)
            for ours, whose in ((library, "library"), (program, "program, NaN refused")):
                bench.compare(
                    ours,
                    theirs,
                    row="defaults",
                    work=f"{volume.name} f32, defaults of the {whose}, cold, 1 thread, "
                    "vs Flying Edges",
                    at_least=True,
                )


def scans(bench: Bench, store: Store, row: str) -> Iterator[Volume]:
    """Those that there are, in the types that they came in."""
    makers = (
        lambda: store.nifti("engine", "volvis/engine.nii.gz", 80),
        lambda: store.nifti("bonsai", "volvis/bonsai.nii.gz", 40),
        lambda: store.ct_head(300),
    )
    for make in makers:
        try:
            yield make()
        except Absent as absent:
            bench.skip(row, absent)


def real(bench: Bench, store: Store) -> None:
    """Scans against Flying Edges."""
    for volume in scans(bench, store, "real"):
        with bench.workers():
            for threads in THREADS:
                settings = (threads, True, False)
                against_edges(bench, volume, "real", *settings, must=3.5, aim=8.0)


@dataclass(frozen=True)
class Change:
    """An option whose cost is measured, and beside what."""

    option: str
    request: dict
    normals: bool = True
    warm: bool = True
    limits: dict[str, float] = field(default_factory=dict)

    def what(self) -> str:
        """For the table."""
        kind, memory = "gradient" if self.normals else "no", "warm" if self.warm else "cold"
        return f"{kind} normals, {memory}, 1 thread, {self.option} vs without"


TRILINEAR = Change(
    "--topology trilinear", {"topology": "trilinear"}, limits={"must": 1.10, "aim": 1.03}
)
CUBIC = Change("--placement cubic", {"placement": "cubic"}, False, limits={"must": 1.15})
MATCHING = {"gradient": "matching"}
CHANGES = (
    TRILINEAR,
    replace(TRILINEAR, warm=False),
    CUBIC,
    replace(CUBIC, warm=False),
    Change("--placement cubic", {"placement": "cubic"}),
    Change("--placement cubic --normals matching", {"placement": "cubic"} | MATCHING),
    Change("--placement quintic", {"placement": "quintic"}, False),
    Change("--placement quintic", {"placement": "quintic"}),
    Change("--placement quintic --normals matching", {"placement": "quintic"} | MATCHING),
    Change("--diagonals fitted", {"diagonals": "fitted"}),
)
"""The two with limits in used memory, where little else takes time, and in fresh memory, as commands have it."""


def modes(bench: Bench, store: Store) -> None:
    """What topology, placement, normals and diagonals cost, on scans and on all together."""
    seconds: dict[str, list[list[list[float]]]] = {change.what(): [] for change in CHANGES}
    for volume in scans(bench, store, "modes"):
        with bench.workers():
            for change in CHANGES:
                plain = extract(volume, normals=change.normals, warm=change.warm)
                requests = (plain | change.request, plain)
                done = bench.run([Entry("isokit", volume, one, change.warm) for one in requests])
                bench.compare(
                    *done,
                    row="modes",
                    work=f"{volume.name} {volume.dtype}, {change.what()}",
                    at_least=False,
                    **change.limits,
                )
                if all(done):
                    seconds[change.what()].append([series.seconds for series in done])
    for change in CHANGES:
        measured = seconds[change.what()]
        if len(measured) > 1:
            sides = zip(*measured, strict=True)
            # The last rounds, as many as the scan with the fewest has.
            rounds = min(len(series) for series, _ in measured)
            last = ([series[-rounds:] for series in side] for side in sides)
            ours, theirs = ([sum(runs) for runs in zip(*side, strict=True)] for side in last)
            bench.add(
                [a / b for a, b in zip(ours, theirs, strict=True)],
                f"{1e3 * median(ours):.1f} ms",
                f"{1e3 * median(theirs):.1f} ms",
                row="modes",
                work=f"all scans together, {change.what()}",
                at_least=False,
                **change.limits,
            )


def threads(bench: Bench, store: Store) -> None:
    """Two threads against one, warm."""
    for volume in fields(bench, store):
        with bench.workers():
            entries = [
                Entry("isokit", volume, extract(volume, threads=count, warm=True), warm=True)
                for count in THREADS
            ]
            one, two = bench.run(entries)
            bench.compare(
                two,
                one,
                row="threads",
                work=f"{volume.name} f32, normals, warm, 2 threads vs 1",
                at_least=True,
                must=1.8,
                aim=1.95,
            )


def peers(bench: Bench, store: Store) -> None:
    """Every peer there is, as much like for like as it can be told."""
    for volume in fields(bench, store):
        with bench.workers():
            entries = [
                Entry("isokit", volume, extract(volume, normals=normals, threads=count))
                for normals in (True, False)
                for count in THREADS
            ]
            entries += [Entry(name, volume, extract(volume)) for name in RUST_PEERS]
            entries.append(Entry("isosurface", volume, extract(volume, normals=False)))
            entries += [
                Entry(name, volume, extract(volume, normals=normals, threads=count))
                for name, peer in PEERS.items()
                for normals in peer.normals
                for count in peer.threads
            ]
            done = bench.run(entries)
            same = {settings(one): one for one in done[:4] if one}
            for theirs in done[4:]:
                if theirs:
                    ours = same.get(settings(theirs))
                    bench.compare(ours, theirs, **peer_line(volume, theirs), at_least=True)


def settings(series: Series) -> tuple[bool, int]:
    """What has to be the same for a comparison."""
    return series.request["normals"], series.request["threads"]


def peer_line(volume: Volume, theirs: Series) -> dict[str, str]:
    """What is said of a comparison with a peer."""
    normals, count = settings(theirs)
    peer = PEERS.get(theirs.who)
    note = peer.note if peer else ""
    if theirs.who == "fast-surface-nets":
        note = "one vertex per cell; normals not of unit length"
    made = "{vertices:,} vertices, {triangles:,} triangles".format(**theirs.answers[-1])
    return {
        "row": "peers",
        "work": f"{volume.name} f32, {'normals' if normals else 'no normals'}, cold, "
        f"{count} thread{'s' * (count > 1)}, vs {theirs.who}",
        "remark": "; ".join(filter(None, (made, note))),
    }


def counts(ours: Series | None, theirs: Series | None) -> str:
    """What both made, or how they differ."""
    if not (ours and theirs):
        return ""
    made = [
        "{vertices:,} vertices, {triangles:,} triangles".format(**one.answers[-1])
        for one in (ours, theirs)
    ]
    return made[0] if made[0] == made[1] else f"{made[0]}; theirs {made[1]}"
