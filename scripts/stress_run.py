#!/usr/bin/env python3
"""Runs isokit and its peers through the stress list and says what is wrong with each mesh.

Started by `scripts/stress`, which installs the peers and builds the program. Small volumes go
through isokit in rows of modes in which every two answers to two options meet, where the program
takes both; with all threads, instructions, kinds of memory and types of samples the mesh must be
the same. Then, unless `--quick`, each volume of the listed size goes through isokit once for each
type of sample that holds its values, and once where denormal numbers are taken for 0, and, in its
own type, through each peer, in a process of its own. Table and data go to scripts/results/DATE-CPU/stress, those of the small form to target/stress.
Exit 1 if isokit fails an item.
"""

import argparse
import datetime
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from kit import bench_machine, stress_isokit, stress_output, stress_shapes, stress_values
from kit.bench_worker import Failed, Worker
from kit.program import PROJECT, Isokit
from kit.stress_case import ITEMS, Case, Item, in_types
from kit.stress_check import Allowed, Mesh, faults
from kit.stress_modes import LISTED, Modes
from kit.stress_output import Verdict
from kit.stress_peers import PEERS, SETTINGS
from kit.tally import Tally

assert stress_values and stress_shapes  # they fill the list

PEER = Allowed(border=True, gaps=True)
"""Peers may leave the border open, and holes around NaN."""


class PeerTool:
    """A peer in a process of its own, which is started again when it dies."""

    def __init__(self, name: str, scratch: Path, limit_s: float) -> None:
        """Starts nothing yet."""
        self.name, self.scratch, self.limit_s = name, scratch, limit_s
        self.worker: Worker | None = None

    def judge(self, item: Item, quick: bool) -> Verdict:
        """All cases of an item."""
        verdict, plain, taken = Verdict(), {}, 0.0
        for case in item.cases(quick):
            if taken > self.limit_s:
                verdict.untried.append(case.name)
                continue
            start = time.monotonic()
            answer = self.ask(case)
            taken += time.monotonic() - start
            if isinstance(answer, str):
                verdict.add(case.name, "", {answer: 1})
            elif "refused" in answer:
                # What some add tells where they were built.
                reason = answer["refused"].partition("Stack backtrace")[0].strip()
                verdict.refused[case.name] = reason
            else:
                with np.load(self.scratch / "peer.npz") as arrays:
                    mesh = Mesh(arrays["vertices"], arrays["triangles"])
                found = faults(mesh, case, PEER)
                plain[case.name] = mesh
                if case.same_as in plain:
                    found["differs"] = int(not mesh.same_as(plain[case.same_as]))
                verdict.add(case.name, "", found)
        return verdict

    def ask(self, case: Case) -> dict | str:
        """The answer, or how the process ended."""
        np.save(self.scratch / "peer.npy", case.samples)
        request = {
            "name": case.name,
            "path": str(self.scratch / "peer.npy"),
            "out": str(self.scratch / "peer.npz"),
            "iso": case.iso,
            "directions": case.directions,
            "origin": case.origin,
            "view": case.view,
        }
        if self.worker is None:
            command = [sys.executable, str(PROJECT / "scripts/stress_peer.py"), self.name]
            self.worker = Worker(command)
        try:
            return self.worker.ask(request, self.limit_s)
        except Failed as failure:
            self.close()
            return str(failure)

    def close(self) -> None:
        """Ends the process."""
        if self.worker is not None:
            self.worker.close()
            self.worker = None


def judge_isokit(modes: Modes, item: Item, quick: bool, scratch: Path) -> Verdict:
    """All cases of an item: small ones in all modes, then those of the listed size in all types."""
    verdict = Verdict()
    plain: dict[tuple, Mesh | None] = {}
    for case in item.cases(True):
        for mode in modes.pairs:
            if not stress_isokit.lawful(case, mode):
                continue
            name, key = f"small: {case.name}", (case.name, mode.plain)
            if key not in plain:
                plain[key], found = stress_isokit.judge(modes, case, mode.plain, scratch)
                if (case.same_as, mode.plain) in plain:
                    twin = plain[case.same_as, mode.plain]
                    found["differs"] = stress_isokit.shape_differs(plain[key], twin)
                verdict.add(name, str(mode.plain), found)
            if mode != mode.plain:
                found = stress_isokit.same(modes, case, mode, plain[key], scratch)
                verdict.add(name, str(mode), found)
    if not quick:
        listed(modes, item, verdict, scratch)
    return verdict


def listed(modes: Modes, item: Item, verdict: Verdict, scratch: Path) -> None:
    """The volumes of the listed size, in each type once, and where denormal numbers are taken for 0."""
    plain: dict[str, Mesh | None] = {}
    for case in item.cases(False):
        plain[case.name], found = stress_isokit.judge(modes, case, LISTED, scratch)
        if case.same_as in plain:
            twin = plain[case.same_as]
            found["differs"] = stress_isokit.shape_differs(plain[case.name], twin)
        verdict.add(case.name, str(LISTED), found)
        if modes.library:
            flushed = replace(LISTED, floats="flushed")
            found = stress_isokit.same(modes, case, flushed, plain[case.name], scratch)
            verdict.add(case.name, str(flushed), found)
        for other in in_types(case):
            mesh, _, wrong = stress_isokit.run(modes, other, LISTED, scratch)
            found = wrong or {"differs": stress_isokit.shape_differs(mesh, plain[case.name])}
            verdict.add(other.name, str(LISTED), found)


def timed(judge: Callable[[], Verdict]) -> Verdict:
    """A verdict that knows how long it took, with the checks."""
    start = time.monotonic()
    verdict = judge()
    verdict.seconds = time.monotonic() - start
    return verdict


def parse() -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(
        prog="scripts/stress",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="small volumes only, in a minute")
    parser.add_argument("--only", type=int, action="append", help="number of an item; repeat it")
    parser.add_argument(
        "--peer", action="append", choices=PEERS, help="a peer; repeat it; default: all"
    )
    parser.add_argument("--no-peers", action="store_true", help="isokit alone; needs numpy only")
    parser.add_argument("--out", type=Path, help="the folder to write to")
    parser.add_argument(
        "--isokit",
        type=Path,
        default=PROJECT / "target/release/isokit",
        help="the program; default: that of the release build",
    )
    parser.add_argument("--from", dest="base", type=Path, default=Path(), help=argparse.SUPPRESS)
    return parser.parse_args()


def run(arguments: argparse.Namespace, scratch: Path, absent: dict[str, str], limit_s: float):
    """The verdicts, and the modes that isokit was run in."""
    modes = Modes(Isokit(arguments.isokit), scratch)
    wanted = [] if arguments.no_peers else arguments.peer or PEERS
    peers = [PeerTool(name, scratch, limit_s) for name in wanted if name not in absent]
    results: stress_output.Results = {}
    for number in arguments.only or sorted(ITEMS):
        item = ITEMS[number]
        row = {
            "isokit": timed(lambda item=item: judge_isokit(modes, item, arguments.quick, scratch))
        }
        for peer in peers:
            row[peer.name] = timed(lambda peer=peer, item=item: peer.judge(item, arguments.quick))
        results[number] = row
        if peers:
            cells = "; ".join(f"{tool} {v.cell()} in {v.seconds:.0f} s" for tool, v in row.items())
            print(f"{number} {item.name}: {cells}", flush=True)
    for peer in peers:
        peer.close()
    return results, modes


def main() -> int:
    """Runs the list and writes."""
    arguments = parse()
    tally = Tally("stress")
    limit_s = 120
    absent = bench_machine.absent(PROJECT / ".venv-bench/absent")
    absent = {} if arguments.no_peers else {k: v for k, v in absent.items() if k in PEERS}
    with tempfile.TemporaryDirectory() as folder:
        results, modes = run(arguments, Path(folder), absent, limit_s)
    machine = bench_machine.facts()
    versions = bench_machine.versions()
    asked = ["isokit", "python", "numpy", *stress_output.packages(results)]
    facts = {
        "date": datetime.date.today().isoformat(),
        "cpu": machine["cpu"],
        "versions": {name: versions[name] for name in asked},
        "quick": arguments.quick,
        "limit_s": limit_s,
        "modes": modes.described(),
        "rows": [str(mode) for mode in modes.pairs],
        "settings": {tool: said for tool, said in SETTINGS.items() if tool not in absent},
    }
    name = f"scripts/results/{facts['date']}-{bench_machine.short(machine['cpu'])}/stress"
    folder = PROJECT / ("target/stress" if arguments.quick or arguments.only else name)
    if arguments.out:
        folder = arguments.base / arguments.out
    stress_output.write(facts, results, absent, folder)
    for number, row in results.items():
        verdict = row["isokit"]
        subject = f"{number} {ITEMS[number].name}"
        claim = f"{verdict.judged} meshes as they should be"
        tally.check(subject, claim, verdict.passes(), "" if verdict.passes() else verdict.cell())
    print(f"wrote {folder}/stress.md")
    print(stress_output.last_line(results))
    return tally.finish()


if __name__ == "__main__":
    sys.exit(main())
