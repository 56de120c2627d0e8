#!/usr/bin/env python3
"""One Python peer of `scripts/bench`: extracts on request and says how long each run took.

Requests and answers are JSON, one object a line, as those of the Rust example `bench` in
crates/marching-cubes. Whatever a library prints goes to stderr.
"""

import argparse
import ctypes
import gc
import json
import os
import resource
import sys
import time

import numpy as np

from kit.bench_peers import PEERS, Peer


DTYPES = {
    "u8": "u1",
    "i8": "i1",
    "u16": "u2",
    "i16": "i2",
    "u32": "u4",
    "i32": "i4",
    "f32": "f4",
    "f64": "f8",
}
"""numpy's names of types by isokit's; for both u8 is something."""


def load(peer: Peer, request: dict) -> dict:
    """Takes a volume into memory."""
    samples = np.fromfile(request["path"], dtype=DTYPES[request["dtype"]])
    peer.prepare(samples.reshape(request["dims"][::-1]), request["iso"])
    return {}


def extract(peer: Peer, request: dict) -> dict:
    """One timed run. What it made is dropped off the clock, and given back if cold."""
    warm = request["warm"]
    if not warm:
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)
    gc.disable()
    before = page_faults()
    start = time.perf_counter()
    vertices, triangles, _mesh = peer.extract(request["normals"], request["threads"], warm)
    seconds = time.perf_counter() - start
    faults = page_faults() - before
    gc.enable()
    return {"seconds": seconds, "faults": faults, "vertices": vertices, "triangles": triangles}


def save(peer: Peer, request: dict) -> dict:
    """Makes the surface and writes it to a file of numpy's."""
    vertices, triangles, made = peer.extract(request["normals"], request["threads"], False)
    points, corners, normals = peer.arrays(made)
    kept = {} if normals is None else {"normals": normals}
    np.savez(request["out"], vertices=points, triangles=corners, **kept)
    return {"vertices": vertices, "triangles": triangles}


def page_faults() -> int:
    """Pages that this process was given so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt


def main() -> int:
    """Answers until there are no more requests."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("peer", choices=sorted(PEERS), help="who is to work")
    peer = PEERS[parser.parse_args().peer]()
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # libraries in C++ print past `sys.stdout`
    operations = {"load": load, "extract": extract, "save": save}
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = operations[request["op"]](peer, request)
        except Exception as error:  # noqa: BLE001 - whatever a peer raises is its answer
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
