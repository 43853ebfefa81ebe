"""A campaign's scheduler on clusters of any size: runs that only pass time, on a made-up clock.

The cluster is simulated, the scheduler is not: `run_all` plans, starts, records and writes each run
as it does on Ray. The CPU time that it takes passes on the made-up clock too, and with it the wait
for the disk at each outcome, and what a task costs a driver of Ray, both measured before.
"""

from __future__ import annotations

import argparse
import heapq
import importlib.util
import resource
import threading
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bringup.campaign.outcome import Outcome, write_outcome
from bringup.campaign.plan import Campaign, Level, runs_of
from bringup.campaign.pool import Ended, Job
from bringup.campaign.runner import run_all
from tests.helpers.ray_cluster import ray_cluster

_MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 10, 100, 1000])
    parser.add_argument("--runs", type=int, default=100_000, help="of a campaign (%(default)s)")
    parser.add_argument("--seconds", type=float, default=15.0, help="a run takes (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Run a campaign of runs that pass time on clusters of some sizes.

    Returns:
        `task_s` of Ray's CPU time in the driver, `disk_s` of waiting for an outcome to be on the
        disk, and by number of workers the `efficiency`, the share of their time that they run, and
        the driver's `memory_mb`.
    """
    figures: dict[str, Any] = {"task_s": _cost_of_a_task(), "disk_s": _wait_for_the_disk()}
    cost = figures["task_s"] + figures["disk_s"]
    print(f"a run costs {1e3 * figures['task_s']:.2f} ms of Ray's and waits "
          f"{1e3 * figures['disk_s']:.2f} ms for the disk")  # fmt: skip
    for workers in arguments.workers:
        with TemporaryDirectory(dir=_MEMORY) as folder:
            efficiency = _efficiency(workers, arguments.runs, arguments.seconds, cost, folder)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        figures[str(workers)] = {"efficiency": efficiency, "memory_mb": memory}
        print(f"{workers:5} workers: {efficiency:.3f}, {memory:.0f} MB")
    return figures


class _Sleepers:
    """Workers that pass time on a made-up clock, which the scheduler's own work moves on.

    A run takes its time, more or less by a tenth; a worker takes the next of the queue by itself.
    """

    def __init__(self, workers: int, seconds: float, cost: float) -> None:
        self.slots, self.capacity = workers, 2 * workers + 1
        self._seconds, self._cost = seconds, cost
        self._rng = np.random.default_rng(0)
        self._free = [0.0] * workers
        self._ends: list[tuple[float, int, Job]] = []
        self._count = 0
        self.now, self.busy = 0.0, 0.0
        self._cpu = time.process_time()

    def start(self, job: Job) -> None:
        self._pass()
        length = self._seconds * self._rng.uniform(0.9, 1.1)
        end = max(self.now, heapq.heappop(self._free)) + length
        heapq.heappush(self._free, end)
        heapq.heappush(self._ends, (end, self._count, job))
        self._count += 1
        self.busy += length
        self.now += self._cost

    def ended(self, timeout: float) -> list[Ended]:
        self._pass()
        self.now = max(self.now, min(self._ends[0][0], self.now + timeout))
        found = []
        while self._ends and self._ends[0][0] <= self.now:
            job = heapq.heappop(self._ends)[2]
            job.folder.mkdir()
            name, levels = job.run.name, job.run.levels
            found.append(Ended(job, Outcome(name, levels, True, "", self._seconds, {"x": 1.0})))
        self._cpu = time.process_time()  # what ran here ran on the workers
        return found

    def stop(self) -> None:
        self._ends.clear()

    def _pass(self) -> None:
        now = time.process_time()
        self.now += now - self._cpu
        self._cpu = now


def _wait_for_the_disk(count: int = 100) -> float:
    """Return how long an outcome takes to be on the disk, but for the CPU time [s]."""
    with TemporaryDirectory() as folder:
        start, cpu = time.perf_counter(), time.process_time()
        for number in range(count):
            write_outcome(Path(folder) / str(number), Outcome("made", {}, True, "", 1.0, {}))
        return (time.perf_counter() - start - time.process_time() + cpu) / count


def _cost_of_a_task(count: int = 2000, ahead: int = 20) -> float:
    """Return the CPU time that Ray takes in a driver for a task with a run's order and answer [s].

    0 where Ray is not installed.
    """
    if importlib.util.find_spec("ray") is None:
        return 0.0
    with ray_cluster({}) as cluster:
        import ray

        ray.init(address=cluster.address, log_to_driver=False, logging_level="error")
        answer = {"outcome": {}, "files": {"r.json": bytes(2000)}}
        task = ray.remote(num_cpus=1, max_retries=0, name="made")(lambda order: answer)
        order, going = {"files": {}, "words": "x" * 2000}, list[Any]()
        ray.get(task.remote(order))
        start = time.process_time()
        for _ in range(count):
            going.append(task.remote(order))
            if len(going) >= ahead:
                done, going = ray.wait(going, num_returns=1)
                ray.get(done)
        ray.get(going)
        cost = (time.process_time() - start) / count
        ray.shutdown()
    return cost


def _efficiency(workers: int, count: int, seconds: float, cost: float, folder: str) -> float:
    levels = tuple(Level(str(number), {"seed": number}) for number in range(count))
    campaign = Campaign("made", ("demo", "{folder}"), "r.json", {"seed": levels}, {})
    runs, pool = runs_of(campaign), _Sleepers(workers, seconds, cost)
    outcomes = run_all(campaign, runs, Path(folder), pool, lambda one: None, threading.Event())
    assert len(outcomes) == count
    return pool.busy / (workers * max(pool.now, max(pool._free)))
