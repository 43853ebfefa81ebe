"""Long computations beside the executor, which answers meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import TypeVar

from arjuna_core.ros.process import Process

T = TypeVar("T")


class Worker:
    """One thread that computes in the order of asking; an isolated process computes at once.

    So lock-step has one thread, and what it does depends on no other.

    Args:
        process: Its executor calls what takes the results.
    """

    def __init__(self, process: Process) -> None:
        self._process = process
        self._pool = None if process.isolated else ThreadPoolExecutor(max_workers=1)

    def run(self, work: Callable[[], T], done: Callable[[Callable[[], T]], object]) -> None:
        """Compute, then call `done` in the executor.

        Args:
            work: Shares nothing that a callback of a node changes.
            done: Takes a function that returns what the work did, or raises what it raised.
        """
        if self._pool is None:
            done(work)
            return

        def hand_over(future: Future[T]) -> None:
            self._process.later(partial(done, future.result))

        self._pool.submit(work).add_done_callback(hand_over)

    def destroy(self) -> None:
        """Wait for the work at hand, and forget the rest."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
