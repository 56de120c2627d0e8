#!/usr/bin/env python3
"""One Python peer of `scripts/stress`: extracts on request and writes the mesh as arrays.

Requests and answers are JSON, one object a line. Whatever a library prints goes to stderr. Memory
is limited, so that a peer that asks for too much gets an error and not the machine's last page.
"""

import argparse
import json
import os
import resource
import sys

import numpy as np

from kit.stress_case import Case, seen
from kit.stress_peers import MEMORY, PEERS


def extract(name: str, request: dict) -> dict:
    """One mesh. An exception is the peer's refusal, in its own words."""
    samples = np.load(request["path"])
    case = Case(
        request["name"],
        samples,
        request["iso"],
        directions=tuple(map(tuple, request["directions"])),
        origin=tuple(request["origin"]),
    )
    try:
        mesh = PEERS[name]().mesh(seen(samples, request["view"]), case)
    except Exception as error:  # noqa: BLE001 - whatever a peer raises is its answer
        return {"refused": f"{type(error).__name__}: {error}"}
    np.savez(request["out"], vertices=mesh.vertices, triangles=mesh.triangles)
    return {}


def main() -> int:
    """Answers until there are no more requests."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("peer", choices=sorted(PEERS), help="who is to work")
    name = parser.parse_args().peer
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # libraries in C++ print past `sys.stdout`
    for line in sys.stdin:
        print(json.dumps(extract(name, json.loads(line))), file=answers, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
