"""Table and data of one run of the stress list."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from kit.bench_peers import PEERS as MEASURED
from kit.data import as_json
from kit.stress_case import ITEMS
from kit.stress_check import AREAS, CRITERIA
from kit.stress_modes import NOT_FITTED
from kit.stress_peers import MEMORY, PEERS

PACKAGES = {name: MEASURED[name].packages for name in PEERS}
"""The packages that each peer is, by the names of the table."""

METHOD = """\
One checker judges every mesh as the tool made it. It counts, and all must be 0:

{criteria}

*flat* and *double* are on how triangles lie, all others on what is there and how it is connected. A
surface may end at the border of the volume, for isokit only with `--boundary open`. Peers may also
leave a hole around a NaN; isokit, with `--nan outside`, may not. Vertices that are not numbers
count for all. Orientation, normals of peers, speed and nearness to the field are not judged here.
No peer promises areas where samples equal the isovalue, so there are two totals.

An item has several volumes. *pass*: nothing is wrong with any of those that the tool takes.
*cannot*: it refuses all of them, with an exception; where it refuses some, their number is given.
A crash, or no answer within {limit} s, is a failure; and once a peer has taken as long over an item,
the rest of its volumes are not tried, and their number is given. Otherwise the cell has the faults of all
volumes, and for isokit of all modes, together. A peer has {memory} GiB of address space. VTK's SurfaceNets
take no part: they are given labels, of which most items here make nothing that is hard."""


@dataclass
class Verdict:
    """One tool on one item."""

    faults: dict[str, int] = field(default_factory=dict)
    """Counts of what is wrong, and other failures by their message."""
    judged: int = 0
    """Meshes that were looked at, or should have been there."""
    refused: dict[str, str] = field(default_factory=dict)
    """The reasons by the names of the cases."""
    untried: list[str] = field(default_factory=list)
    """The cases that were left out, because those before them took too long."""
    detail: list[dict] = field(default_factory=list)
    """The faults of each case and mode that has any."""
    seconds: float = 0.0
    """How long the item took, its checks included."""

    def add(self, case: str, mode: str, found: dict[str, int]) -> None:
        """Counts one mesh."""
        self.judged += 1
        wrong = {key: count for key, count in found.items() if count}
        for key, count in wrong.items():
            self.faults[key] = self.faults.get(key, 0) + count
        if wrong:
            self.detail.append({"case": case, "mode": mode, "faults": wrong})

    def passes(self, areas: bool = True) -> bool:
        """Whether nothing is wrong, or nothing with the connections."""
        return self.judged > 0 and not any(areas or key not in AREAS for key in self.faults)

    def cell(self) -> str:
        """For the table."""
        if self.judged == 0:
            return "cannot"
        faults = ", ".join(f"{key} {count:,}" for key, count in self.faults.items())
        some = [f"{len(self.refused)} cannot"] * bool(self.refused)
        some += [f"{len(self.untried)} not tried"] * bool(self.untried)
        tail = f" ({', '.join(some)})" if some else ""
        return (faults.replace("|", "\\|") or "pass") + tail


Results = dict[int, dict[str, Verdict]]
"""Verdicts by items and tools."""


def totals(results: Results) -> dict[str, dict[str, int]]:
    """How many items each tool passes, passes but for areas, and cannot take."""
    tools = dict.fromkeys(tool for row in results.values() for tool in row)
    found = {}
    for tool in tools:
        verdicts = [row[tool] for row in results.values() if tool in row]
        found[tool] = {
            "pass": sum(verdict.passes() for verdict in verdicts),
            "connected": sum(verdict.passes(areas=False) for verdict in verdicts),
            "cannot": sum(verdict.judged == 0 for verdict in verdicts),
            "items": len(verdicts),
        }
    return found


def last_line(results: Results) -> str:
    """The totals in one line."""
    parts = []
    for tool, count in totals(results).items():
        more = [f"{count['connected']} but for areas"] * (count["connected"] > count["pass"])
        more += [f"{count['cannot']} cannot"] * (count["cannot"] > 0)
        tail = f" ({', '.join(more)})" if more else ""
        parts.append(f"{tool} {count['pass']} of {count['items']}{tail}")
    return "; ".join(parts)


def packages(results: Results) -> list[str]:
    """Those of the peers that were asked."""
    asked = {tool for row in results.values() for tool in row if tool in PACKAGES}
    return sorted({package for tool in asked for package in PACKAGES[tool]})


def table(facts: dict, results: Results, absent: dict[str, str]) -> str:
    """Everything for people."""
    versions = "; ".join(f"{name} {version}" for name, version in facts["versions"].items())
    tools = list(dict.fromkeys(tool for row in results.values() for tool in row))
    criteria = "\n".join(f"- *{key}*: {meaning}" for key, meaning in CRITERIA.items())
    form = "small" if facts["quick"] else "full"
    parts = [
        f"# The stress list, {facts['date']}",
        "",
        f"Printed by `scripts/stress`, {form} form. {versions}.",
        "",
        METHOD.format(criteria=criteria, limit=facts["limit_s"], memory=MEMORY >> 30),
        "",
        f"| item | {' | '.join(tools)} |",
        "| --- " * (len(tools) + 1) + "|",
    ]
    for number, row in results.items():
        cells = " | ".join(row[tool].cell() for tool in tools)
        parts.append(f"| {number} {ITEMS[number].name} | {cells} |")
    summed = totals(results)
    for title, key in (("pass", "pass"), ("pass but for areas", "connected"), ("cannot", "cannot")):
        cells = " | ".join(f"**{summed[tool][key]}**" for tool in tools)
        parts.append(f"| **{title}** | {cells} |")
    parts += ["", last_line(results) + ".", "", "## Settings", "", *settings(facts, tools)]
    parts += ["", "## What was refused", ""]
    parts += [*refusals(results), *(f"- {tool}: {why}" for tool, why in absent.items())]
    return "\n".join(parts) + "\n"


def settings(facts: dict, tools: list[str]) -> Iterable[str]:
    """What each tool was told."""
    *apart, last_apart = (f"*{answer}*" for _, answer in NOT_FITTED)
    yield (
        f"- isokit: `--nan outside`; small volumes in {len(facts['rows'])} rows of modes in which "
        f"every two of these meet, but *fitted* with {', '.join(apart)} and {last_apart}; each "
        f"compared with one thread, portable, whole, usual, own: {facts['modes']}. *sliced* is "
        "`--max-memory 512MiB`, *indexed* `--index`; *flushed* runs with a library that has "
        "denormal numbers taken for 0; *integer* and *float* are other types that hold the values, "
        "where there are some. If *exact*, *flat* and *double* are not counted, and *volume* is "
        "not looked at."
    )
    if not facts["quick"]:
        yield (
            "- isokit, volumes of the listed size: its defaults on two threads, once for each type "
            "of sample that holds the values, and once more *flushed*; vertices and triangles must "
            "be the same in all."
        )
    known = facts["settings"]
    yield from (f"- {tool}: {known[tool]}" for tool in tools if tool in known)


def refusals(results: Results) -> Iterable[str]:
    """Tool, item, reason; equal reasons of an item once."""
    for number, row in results.items():
        for tool, verdict in row.items():
            reasons: dict[str, list[str]] = {}
            for case, reason in verdict.refused.items():
                reasons.setdefault(reason, []).append(case)
            for reason, cases in reasons.items():
                short = " ".join(reason.split())[:160]
                yield f"- {tool}, item {number}, {', '.join(cases)}: {short}"


def write(facts: dict, results: Results, absent: dict[str, str], folder: Path) -> None:
    """Both into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "stress.md").write_text(table(facts, results, absent))
    whole = facts | {
        "schema": "isokit.stress/1",
        "totals": totals(results),
        "absent": absent,
        "items": [
            {
                "number": number,
                "name": ITEMS[number].name,
                "tools": {
                    tool: {"passes": verdict.passes()} | vars(verdict)
                    for tool, verdict in row.items()
                },
            }
            for number, row in results.items()
        ],
    }
    (folder / "stress.json").write_text(as_json(whole))
