"""Times of several calls that have their turn one after the other, so that what disturbs the machine disturbs all."""

import math
import time
from collections.abc import Callable


def fastest(calls: list[Callable[[], object]], rounds: int) -> list[float]:
    """Seconds of each call, the fastest of some rounds."""
    best = [math.inf] * len(calls)
    for seconds in in_turn(calls, rounds):
        best = [min(one, other) for one, other in zip(best, seconds, strict=True)]
    return best


def in_turn(calls: list[Callable[[], object]], rounds: int) -> list[list[float]]:
    """Seconds of each call in each round."""
    found = []
    for _ in range(rounds):
        seconds = []
        for call in calls:
            began = time.perf_counter()
            call()
            seconds.append(time.perf_counter() - began)
        found.append(seconds)
    return found
