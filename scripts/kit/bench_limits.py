"""The rows that compare isokit with what the machine allows, and with itself.

Standard library only.
"""

from statistics import linear_regression, median

from kit.bench_measure import Bench, Entry, Series, extract, milliseconds
from kit.bench_volumes import Store, Volume

THREADS = (1, 2)
BYTES = {"u8": 1, "i8": 1, "u16": 2, "i16": 2, "u32": 4, "i32": 4, "f32": 4, "f64": 8}


def random(dtype: str, n: int) -> Volume:
    """As many bytes of any type, made up by the contender: 512 MiB at n = 512."""
    value = 1.5 if dtype in ("f32", "f64") else 9.5
    return Volume(f"random {dtype}", (n, n, 4 * n // BYTES[dtype]), dtype, value)


def machine(bench: Bench, store: Store) -> None:
    """The rates of the memory: read, copied, and written for the first time."""
    volume = random("f32", 256 if bench.quick else 512)
    size = volume.count * 4
    with bench.workers():
        for threads in THREADS:
            requests = (
                {"op": "read", "threads": threads},
                {"op": "copy", "threads": threads},
                {"op": "fill", "threads": threads, "parts": [size]},
            )
            for one in bench.run([Entry("isokit", volume, request) for request in requests]):
                if one:
                    name = f"{one.request['op']}, {threads} thread{'s' * (threads > 1)}"
                    rate = f"{size / one.median / 1e9:.1f} GB/s"
                    bench.facts[name] = rate
                    print(f"{'machine':10} {name}: {rate}", flush=True)


def classify(bench: Bench, store: Store) -> None:
    """One bit per sample, against the mere reading of the same bytes."""
    for dtype in BYTES:
        volume = random(dtype, 256 if bench.quick else 512)
        with bench.workers():
            for threads in THREADS:
                requests = (
                    {"op": "classify", "iso": volume.iso, "threads": threads},
                    {"op": "read", "threads": threads},
                )
                ours, read = bench.run([Entry("isokit", volume, one) for one in requests])
                bench.compare(
                    ours,
                    read,
                    row="classify",
                    work=f"{dtype}, {threads} thread{'s' * (threads > 1)}, vs a pure read",
                    at_least=False,
                    must=1.4,
                    aim=1.15,
                )


def many(bench: Bench, store: Store) -> None:
    """Eight isovalues in one call against the first of them: classified and counted."""
    n = 128 if bench.quick else 256
    # Spheres in steps of 1/64 of the volume's width; gyroids from -0.8 to 0.6.
    for volume, step in ((store.sphere(n), n / 64), (store.gyroid(n), 0.2)):
        isos = [volume.iso + step * k for k in (0, -1, 1, -2, 2, -3, 3, -4)]
        with bench.workers():
            for threads in THREADS:
                requests = [
                    {"op": "count", "isos": some, "threads": threads} for some in (isos, isos[:1])
                ]
                all_of_them, one = bench.run([Entry("isokit", volume, each) for each in requests])
                bench.compare(
                    all_of_them,
                    one,
                    row="many",
                    work=f"{volume.name} f32, classified and counted, {threads} "
                    f"thread{'s' * (threads > 1)}, 8 isovalues in one call vs 1",
                    at_least=False,
                    must=2.0,
                    aim=1.3,
                )


def index(bench: Bench, store: Store) -> None:
    """The index: made in one pass; and then, a surface in time that follows its share of bricks."""
    n = 128 if bench.quick else 512
    volume = store.sphere(n)
    with bench.workers():
        for threads in THREADS:
            requests = [{"op": op, "threads": threads} for op in ("index", "read")]
            ours, read = bench.run([Entry("isokit", volume, request) for request in requests])
            bench.compare(
                ours,
                read,
                row="index",
                work=f"{volume.name} f32, {threads} thread{'s' * (threads > 1)}, "
                "making the index vs a pure read",
                at_least=False,
            )
        pairs = []
        for radius in (0.01, 0.05, 0.1, 0.2, 0.3, 0.4):
            request = extract(volume, warm=True) | {"iso": (0.4 - radius) * n}
            entries = [
                Entry("isokit", volume, request | known, warm=True)
                for known in ({"index": True}, {})
            ]
            ours, without = bench.run(entries)
            if ours and without:
                pairs.append((ours, without))
    if len(pairs) < 2:
        return
    shares = [100 * ours.answers[-1]["active"] for ours, _ in pairs]
    slope, start = linear_regression(shares, [1e3 * ours.median for ours, _ in pairs])
    for share, (ours, without) in zip(shares, pairs, strict=True):
        bench.compare(
            ours,
            without,
            row="index",
            work=f"{volume.name} f32, through {share:.1f} % of the bricks, normals, warm, "
            "1 thread, with the index vs without",
            at_least=True,
            remark=f"nearest line: {start:.2f} ms + {slope:.2f} ms per %",
        )


def bound(bench: Bench, store: Store) -> None:
    """Large volumes, sparse and dense, against reading them and filling as much memory."""
    n = 256 if bench.quick else 512
    for volume, must, aim in ((store.sphere(n), 2.0, 1.3), (store.gyroid(n), 4.0, 2.0)):
        with bench.workers():
            sized = bench.run([Entry("isokit", volume, extract(volume))])[0]
            if sized is None:
                continue
            parts = sized.answers[-1]["parts"]
            for threads in THREADS:
                requests = (
                    extract(volume, threads=threads),
                    {"op": "bound", "threads": threads, "parts": parts},
                    {"op": "read", "threads": threads},
                    {"op": "fill", "threads": threads, "parts": parts},
                )
                ours, least, read, fill = bench.run(
                    [Entry("isokit", volume, request) for request in requests]
                )
                made = "{vertices:,} vertices, {triangles:,} triangles"
                bench.compare(
                    ours,
                    least,
                    row="bound",
                    work=f"{volume.name} f32, normals, cold, {threads} "
                    f"thread{'s' * (threads > 1)}, vs the bound",
                    at_least=False,
                    must=must,
                    aim=aim,
                    remark=f"{made.format(**sized.answers[-1])}; bound: "
                    f"read {milliseconds(read)}, fill {milliseconds(fill)}"
                    if read and fill
                    else "",
                )


def memory(bench: Bench, store: Store) -> None:
    """What is in memory at most, less the input, the output and the process before."""
    n = 256 if bench.quick else 512
    shares = {"float32": 1 / 16, "int16": 1 / 8, "uint8": 1 / 4}
    for dtype, must in shares.items():
        for volume in (store.sphere(n, dtype), store.gyroid(n, dtype=dtype)):
            for threads in THREADS:
                request = extract(volume, threads=threads) | {"op": "memory"}
                # Memory varies less than time, and every run is a process and a volume anew.
                answers = [bench.fresh(Entry("isokit", volume, request)) for _ in range(3)]
                if None in answers:
                    continue
                bench.series.append(Series("isokit", volume.name, request, answers))
                above = [answer["above"] for answer in answers]
                size = answers[0]["input"]
                bench.add(
                    [one / size for one in above],
                    f"{max(above) / 2**20:.1f} MiB",
                    f"input {size / 2**20:.0f} MiB",
                    row="memory",
                    work=f"{volume.name} {volume.dtype}, {threads} thread{'s' * (threads > 1)}, "
                    "memory above input and output, as a share of the input",
                    at_least=False,
                    must=must,
                    aim=must / 2,
                )


def growth(bench: Bench, store: Store, full: bool = False) -> None:
    """Time per sample by size, warm; the gyroid's share of crossed cells is always the same.

    Small volumes are done several times in a row, until it is 2²⁶ samples: else what is measured is how a thread wakes.
    """
    sizes = [64, 128, 256] if bench.quick else [128, 256, 512] + [1024] * full
    curves = (
        ("gyroid, period 32", lambda n: store.gyroid(n, 32.0)),
        ("sphere", store.sphere),
    )
    for name, make in curves:
        with bench.workers():
            volumes = [make(n) for n in sizes]
            done = bench.run(
                [
                    Entry(
                        "isokit",
                        volume,
                        extract(volume, warm=True, runs=max(1, (1 << 26) // volume.count)),
                        warm=True,
                    )
                    for volume in volumes
                ]
            )
        pairs = [(one, volume) for one, volume in zip(done, volumes, strict=True) if one]
        if len(pairs) < 2:
            continue
        each = [[1e9 * s / volume.count for s in one.seconds] for one, volume in pairs]
        listed = ", ".join(
            f"{volume.dims[0]}³ {median(times):.3f}"
            for (_, volume), times in zip(pairs, each, strict=True)
        )
        most, least = max(each, key=median), min(each, key=median)
        bench.add(
            [a / b for a, b in zip(most, least, strict=True)],
            f"{median(most):.3f} ns per sample",
            f"{median(least):.3f}",
            row="growth",
            work=f"{name}, normals, warm, 1 thread: most by least time per sample",
            at_least=False,
            must=1.2 if "gyroid" in name else None,
            remark=f"ns per sample: {listed}",
        )
