"""Plays runs in this process or in several."""

from __future__ import annotations

import collections
import concurrent.futures.process
import itertools
import multiprocessing
import pickle
from typing import Any, Callable, Optional

from ._play import Chunk, Plan, play_batch


class Players:
    """Plays batches (first run, runs) and hands them on in their order, in so many processes; of one in this. Whatever
    ends it, Ctrl-C among it, ends the processes at once."""

    def __init__(self, workers: int):
        self._workers = workers
        self._pool: Optional[concurrent.futures.ProcessPoolExecutor] = None

    def __enter__(self) -> "Players":
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if self._pool is None:
            return
        if error is None:
            return self._pool.shutdown()
        for process in list((getattr(self._pool, "_processes", None) or {}).values()):
            process.terminate()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def play(self, plan: Plan, bounds: "list[tuple[int, int]]", add: Callable[[Chunk], None]) -> None:
        if self._workers == 1:
            for first, runs in bounds:
                add(play_batch(plan, first, runs))
            return
        fresh = self._pool is None
        pool = self._pool = self._pool or self._started(plan)
        done = 0
        try:
            rest = iter(bounds)
            # So many at a time: what is played before it is judged waits in memory.
            waiting = collections.deque(pool.submit(play_batch, plan, *b) for b in itertools.islice(rest, 2 * self._workers))
            while waiting:
                chunk = waiting.popleft().result()
                done += 1
                waiting.extend(pool.submit(play_batch, plan, *b) for b in itertools.islice(rest, 1))
                add(chunk)
        except concurrent.futures.process.BrokenProcessPool:
            if not fresh or done > 0:
                raise
            raise RuntimeError(
                "a process of workers ended before it played a run: the script must call this under "
                '`if __name__ == "__main__":`, world and filter must be importable (not of a notebook or of stdin), '
                "and memory must suffice for all of them"
            ) from None

    def _started(self, plan: Plan) -> concurrent.futures.ProcessPoolExecutor:
        if getattr(multiprocessing.current_process(), "_inheriting", False):
            raise SystemExit(1)  # the script is being imported by a worker: the one that started it tells
        try:
            pickle.dumps(plan)
        except Exception as error:  # PicklingError, AttributeError and TypeError among others
            raise ValueError(
                f"workers = {self._workers}: world and filter cannot be handed to other processes ({error}): they must be "
                "importable, so no lambda, and nothing that is defined within a function"
            ) from None
        context = multiprocessing.get_context("spawn")
        return concurrent.futures.ProcessPoolExecutor(self._workers, mp_context=context)
