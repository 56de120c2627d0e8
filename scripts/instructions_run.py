#!/usr/bin/env python3
"""Counts instructions with Valgrind and compares them with those that are kept.

Started by `scripts/instructions`. The counts that are kept are in scripts/results/instructions.json, with the
compiler that they hold for: another one makes other code, so after a change of compiler they are counted and
kept anew, on the state of the project before the change that is to be judged. Exit 1 if a count rose by more
than the tolerance, or a benchmark has gone.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
KEPT = PROJECT / "scripts/results/instructions.json"
CRATES = ["isokit-marching-cubes", "isokit-refine"]
NOTE = (
    "Instructions as Valgrind counts them, of the code for AVX2, on one thread. They depend on the "
    "version of the compiler: compare only what one compiler made."
)


def counted(crate: str, home: str) -> dict[str, int]:
    """The instructions of each benchmark of a crate."""
    command = ["cargo", "bench", "--quiet", "-p", crate, "--bench", "instructions", "--"]
    run = subprocess.run(
        [*command, "--output-format=json"],
        cwd=PROJECT,
        env=os.environ | {"GUNGRAUN_HOME": home},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    summaries = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    return {name(crate, summary): instructions(summary) for summary in summaries}


def name(crate: str, summary: dict) -> str:
    """How a benchmark is named in the table."""
    return f"{crate.removeprefix('isokit-')}: {summary['function_name']} {summary['id']}"


def instructions(summary: dict) -> int:
    """What Callgrind counted in all."""
    (profile,) = (one for one in summary["profiles"] if one["tool"] == "Callgrind")
    metrics = profile["summaries"]["total"]["summary"]["Callgrind"]["Ir"]["metrics"]
    return metrics["Left"]["Int"]


def compiler() -> str:
    """The version of the compiler."""
    run = subprocess.run(["rustc", "--version"], cwd=PROJECT, capture_output=True, text=True, check=True)
    return run.stdout.strip()


def compared(now: dict[str, int], kept: dict[str, int], within: float) -> tuple[list[str], int]:
    """A line for each benchmark, and how many are worse."""
    lines, worse = [], 0
    for each in kept | now:
        before, after = kept.get(each), now.get(each)
        if before is None or after is None:
            verdict = "new" if before is None else "GONE"
        else:
            change = 100 * (after / before - 1)
            verdict = f"{change:+.2f} %" + (" ROSE" if change > within else "")
        worse += verdict.isupper() or verdict.endswith("ROSE")
        lines.append(f"{each:44} {before or 0:>13,} {after or 0:>13,}  {verdict}")
    return lines, worse


def main() -> int:
    """Counts, and compares or keeps."""
    parser = argparse.ArgumentParser(
        prog="scripts/instructions",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--keep", action="store_true", help="keep what is counted now")
    parser.add_argument("--within", type=float, default=2.0, help="percent that is let pass; default: 2")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as home:
        now: dict[str, int] = {}
        for crate in CRATES:
            now |= counted(crate, home)
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {"counts": {}}
    lines, worse = compared(now, kept["counts"], arguments.within)
    print("\n".join(lines))
    if arguments.keep:
        content = {"note": NOTE, "compiler": compiler(), "simd": "avx2", "counts": now}
        KEPT.write_text(json.dumps(content, indent=2) + "\n")
        print(f"kept in {KEPT.relative_to(PROJECT)}")
        return 0
    if kept.get("compiler") != compiler():
        print(f"kept of {kept.get('compiler')}, counted of {compiler()}: other code", file=sys.stderr)
    print(f"instructions: {worse} of {len(lines)} worse than by {arguments.within} %")
    return int(worse > 0)


if __name__ == "__main__":
    sys.exit(main())
