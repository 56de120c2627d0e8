"""Interleaved measuring, and what comes of it. Standard library only."""

import itertools
import statistics
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field

from kit.bench_goal import Goal
from kit.bench_volumes import Volume
from kit.bench_worker import COLD, Failed, Worker
from kit.program import PROJECT

RUST_PEERS = ("fast-surface-nets", "isosurface")

ENOUGH = 3.0
"""Seconds after which no more rounds follow those that were asked for."""

MOST = 5
"""And never more than so many times as many rounds."""

PATIENCE = 20.0
"""Seconds in all for which rounds follow while what they measure is not steady."""

MOST_UNSTEADY = 20
"""And then never more than so many times as many rounds."""

STEADY = 0.1
"""The middle half of the times of one contender, as a share of their median, if it is."""


@dataclass(frozen=True)
class Entry:
    """One of the things that are measured in turn: who does what on which volume."""

    who: str
    volume: Volume
    request: dict
    warm: bool = False


@dataclass
class Series:
    """The answers of one entry, a run each, in the order of the rounds."""

    who: str
    volume: str
    request: dict
    answers: list[dict] = field(default_factory=list)

    @property
    def seconds(self) -> list[float]:
        """All times."""
        return [answer["seconds"] for answer in self.answers]

    @property
    def median(self) -> float:
        """The middle time."""
        return statistics.median(self.seconds)

    @property
    def is_steady(self) -> bool:
        """Whether the times are close to each other."""
        low, middle, high = quartiles(self.seconds)
        return high - low <= STEADY * middle


@dataclass
class Result:
    """A line of the table: how two series compare, and what was wanted."""

    row: str
    work: str
    ours: str
    theirs: str
    ratio: float
    low: float
    high: float
    at_least: bool
    must: float | None = None
    aim: float | None = None
    remark: str = ""

    @property
    def goal(self) -> Goal:
        """What was wanted."""
        return Goal(self.must, self.aim, self.at_least)

    def verdict(self) -> str:
        """Whether the ratio is what was wanted, and by how much it is not."""
        return self.goal.verdict(self.ratio)

    def spread(self) -> str:
        """The ratio and the range of its middle half, for people."""
        digits = 2 if self.ratio >= 0.5 else 4
        return f"{self.ratio:.{digits}f} ({self.low:.{digits}f}-{self.high:.{digits}f})"

    def as_dict(self) -> dict:
        """For the data."""
        return asdict(self) | {"verdict": self.verdict()}


class Bench:
    """One run: its settings, its workers, and all that it measured."""

    def __init__(self, rounds: int, quick: bool, absent: dict[str, str]) -> None:
        """`absent` has the peers that are not installed, with the reason."""
        self.rounds = rounds
        self.quick = quick
        self.absent = absent
        self.results: list[Result] = []
        self.series: list[Series] = []
        self.skipped: list[str] = []
        self.facts: dict[str, str] = {}
        self.failed = False
        self._workers: dict[tuple[str, bool, Volume], Worker] = {}

    @contextmanager
    def workers(self) -> Iterator[None]:
        """Inside, every contender has one process per volume and mode; at the end they are gone."""
        try:
            yield
        finally:
            for worker in self._workers.values():
                worker.close()
            self._workers.clear()

    def run(self, entries: list[Entry]) -> list[Series | None]:
        """All entries in turn, round by round: A B C A B C. None for a contender that failed.

        A first round is not counted: it starts processes, reads volumes and fills what warm runs
        reuse. What is short is measured more often: rounds follow each other for `ENOUGH` seconds. What is
        not steady, as when somebody else takes the machine for a while, is too: until `PATIENCE` is over.
        """
        taken = [Series(entry.who, entry.volume.name, entry.request) for entry in entries]
        alive = [self._answer(entry) is not None for entry in entries]
        begin = time.monotonic()
        for number in itertools.count():
            measured = [one for one, lives in zip(taken, alive, strict=True) if lives]
            if self._is_enough(number, time.monotonic() - begin, measured):
                break
            for n, entry in enumerate(entries):
                answer = self._answer(entry) if alive[n] else None
                alive[n] = answer is not None
                if answer is not None:
                    taken[n].answers.append(answer)
        done = [one if lives else None for one, lives in zip(taken, alive, strict=True)]
        self.series += [one for one in done if one]
        return done

    def _is_enough(self, number: int, seconds: float, measured: list[Series]) -> bool:
        """Whether nothing is to be measured once more after so many rounds."""
        if number < self.rounds:
            return False
        if self.quick or seconds > PATIENCE or number >= MOST_UNSTEADY * self.rounds:
            return True
        is_over = seconds > ENOUGH or number >= MOST * self.rounds
        return is_over and all(series.is_steady for series in measured)

    def compare(self, ours: Series | None, theirs: Series | None, **line: object) -> None:
        """Adds a line: their time by ours, if more is better, or ours by theirs.

        Each ratio is of two runs of one round, so that what slows both down cancels.
        """
        if not (ours and theirs):
            return
        pairs = list(zip(ours.seconds, theirs.seconds, strict=True))
        at_least = bool(line["at_least"])
        ratios = [b / a if at_least else a / b for a, b in pairs]
        self.add(ratios, f"{milliseconds(ours)}", f"{milliseconds(theirs)}", **line)

    def add(self, ratios: list[float], ours: str, theirs: str, **line: object) -> None:
        """Adds a line with the median of the ratios and the range of their middle half."""
        low, middle, high = quartiles(ratios)
        result = Result(ours=ours, theirs=theirs, ratio=middle, low=low, high=high, **line)
        self.results.append(result)
        print(
            f"{result.row:10} {result.work}: {ours} against {theirs}: "
            f"{result.spread()} {result.verdict()}".rstrip(),
            flush=True,
        )

    def skip(self, what: str, why: object) -> None:
        """Says what was not measured; never silently."""
        self.skipped.append(f"{what}: {why}")
        print(f"skip {what}: {why}", flush=True)

    def fresh(self, entry: Entry) -> dict | None:
        """The answer of a process that has done nothing before."""
        answer = self._answer(entry)
        worker = self._workers.pop((entry.who, entry.warm, entry.volume), None)
        if worker:
            worker.close()
        return answer

    def _answer(self, entry: Entry) -> dict | None:
        """One run; None, and a line, if it failed. The reason is kept for the table."""
        if entry.who in self.absent:
            return None
        key = (entry.who, entry.warm, entry.volume)
        try:
            worker = self._workers.get(key)
            if worker is None:
                worker = self._workers[key] = start(entry.who, entry.warm)
                worker.ask(entry.volume.request())
            return worker.ask(entry.request)
        except Failed as failure:
            self.skip(f"{entry.who}, {entry.volume.name}", failure)
            self.failed |= entry.who == "isokit"  # a peer may fail, what is measured may not
            broken = self._workers.pop(key, None)
            if broken:
                broken.close()
            return None


def start(who: str, warm: bool) -> Worker:
    """A process for a contender. Cold, freed memory goes back to the system: see `COLD`."""
    if who == "isokit" or who in RUST_PEERS:
        program = PROJECT / "target/release/examples/bench"
        return Worker([str(program), who], {} if warm else COLD)
    return Worker([sys.executable, str(PROJECT / "scripts/bench_peer.py"), who])


def extract(volume: Volume, **changes: object) -> dict:
    """The request for a surface; one thread, normals and cold unless changed."""
    usual = {"op": "extract", "iso": volume.iso, "threads": 1, "normals": True, "warm": False}
    return usual | changes


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """The median between the ends of the middle half."""
    if len(values) == 1:
        return values[0], values[0], values[0]
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, middle, high


def milliseconds(series: Series) -> str:
    """Median and spread of a series for people."""
    low, middle, high = (1e3 * value for value in quartiles(series.seconds))
    digits = 1 if middle >= 10 else 2
    return f"{middle:.{digits}f} ms ({low:.{digits}f}-{high:.{digits}f})"
