"""Contenders that take turns."""

import statistics
from collections.abc import Callable


def interleaved(rounds: int, contenders: dict[str, Callable[[], float]]) -> dict[str, float]:
    """The median of each one's seconds; the first round warms up."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for n in range(rounds + 1):
        for name, contender in contenders.items():
            took = contender()
            if n:
                seconds[name].append(took)
    return {name: statistics.median(times) for name, times in seconds.items()}
