"""A Ray cluster behind the pool's Protocol: a run is a task, and its files come back with it."""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import shutil
import socket
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError
from arjuna_core.files.input_file import read_bytes
from bringup.campaign.inputs import inputs_of
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import LARGEST, Campaign
from bringup.campaign.pool import PROGRAM, Ended, Job
from bringup.campaign.worker import order_of

LOCAL, AUTO = "local", "auto"
_LOOPBACK = {
    "RAY_AUTH_MODE": "token",  # whoever connects must know a secret of this process
    # Ray's switch for systems whose firewalls ask: without it nodes listen on all interfaces.
    "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",
}


def address_of(given: str) -> str:
    """Return the address of a cluster; `auto` is $RAY_ADDRESS, else one of this machine alone."""
    return os.environ.get("RAY_ADDRESS", LOCAL) if given == AUTO else given


@contextlib.contextmanager
def cluster_pool(
    given: str,
    campaign: Campaign,
    jobs: int,
    show: Callable[[str], None],
    program: Sequence[str] = PROGRAM,
) -> Iterator[ClusterPool]:
    """Yield a pool of a Ray cluster's workers.

    Args:
        given: The cluster's address, `host:port`, or `auto`; see `address_of`.
        campaign: Says what a run takes.
        jobs: How many runs at a time, on a cluster of this machine alone.
        show: Takes lines about what is connected, open and refused.

    Raises:
        ArjunaError: No cluster is there, or it refuses this process.
        ModuleNotFoundError: Ray is not installed.
    """
    address = address_of(given)
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"  # it reports to its makers by default
    with contextlib.ExitStack() as stack:
        options: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
        scratch = None
        if address == LOCAL:
            scratch = tempfile.mkdtemp(prefix="arjuna-ray-")
            stack.callback(shutil.rmtree, scratch, ignore_errors=True)
            os.environ.update(_LOOPBACK)
            # With it each process of Ray's compiles all it imports: on a busy machine above 30 s.
            os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
            os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(32))
            options |= {"num_cpus": jobs, "dashboard_host": "127.0.0.1", "_temp_dir": scratch}
            options["object_store_memory"] = 256 << 20  # results in transit; more go to disk
        else:
            _check_reachable(address)
        import ray

        try:
            ray.init(address=address, **options)
        except Exception as error:  # a bare one where a node does not start in Ray's 30 s
            raise ArjunaError(f"{_none_at(address)}: {_first(error)}") from error
        stack.callback(ray.shutdown)
        pool = ClusterPool(campaign, show, program, scratch)
        show(_connected(address, pool.slots))
        yield pool


def _none_at(address: str) -> str:
    if address == LOCAL:
        return "no Ray cluster of this machine, which may be too busy or lack memory"
    return f"no Ray cluster at {address}"


def _check_reachable(address: str, within: float = 5.0) -> None:
    """Raise ArjunaError where nothing listens at an address within a time [s]; Ray would wait."""
    host, _, port = address.rpartition("://")[2].rpartition(":")
    if not host or not port.isdecimal():
        raise ArjunaError(f"'{address}' is no cluster; valid: HOST:PORT, ray://HOST:PORT or auto")
    try:
        socket.create_connection((host.strip("[]"), int(port)), within).close()
    except (OSError, OverflowError) as error:
        raise ArjunaError(f"no Ray cluster at {address}: {error}") from error


def _connected(address: str, slots: int) -> str:
    import ray

    if address == LOCAL:
        return f"a Ray cluster of this machine alone, on loopback: {slots} runs at a time"
    host = ray.util.get_node_ip_address()
    asks = os.environ.get("RAY_AUTH_MODE") == "token"
    guard = "it asks for a token" if asks else "NOTHING asks who they are: see SECURITY.md"
    return (
        f"Ray cluster at {address}: {len(_nodes())} nodes, {slots} runs at a time; this process and"
        f" Ray's own listen on {host} for its network, whose users can run programs as you; {guard}"
    )


def _nodes() -> list[dict[str, Any]]:
    import ray

    return [node for node in ray.nodes() if node["Alive"]]


class ClusterPool:
    """The workers of the Ray cluster that this process is connected to.

    Args:
        campaign: Says what a run takes; what it leaves open is measured, and planned with then.
        show: Takes a line on each node that is refused.
        program: What takes the words of a run.
        scratch: Folder for the files of running runs; None for the workers' own.
    """

    def __init__(
        self,
        campaign: Campaign,
        show: Callable[[str], None],
        program: Sequence[str] = PROGRAM,
        scratch: str | None = None,
    ) -> None:
        import ray

        self._task = ray.remote(max_retries=0)(_task())
        self._show, self._program, self._scratch = show, program, scratch
        self._going: dict[Any, Job] = {}
        self._carried: dict[Path, _Carried] = {}
        self._contents: dict[str, Any] = {}
        self._refused: dict[str, str] = {}
        self._declared = campaign.cpus, campaign.memory
        self._cpus = campaign.cpus or 1.0
        self._memory = int(1e6 * campaign.memory) or 1 << 30  # [bytes] until it is measured
        self._measured = False
        self._slots, self._slots_at = 1, -float("inf")

    @property
    def slots(self) -> int:
        """Return the number of runs that the nodes present can run at a time, at least 1."""
        now = time.monotonic()
        if now - self._slots_at > 2.0:  # [s]; each look asks the head
            slots = sum(map(self._slots_of, _nodes()))
            if not slots and self._slots:
                need = f"{self._cpus:g} CPUs and {self._memory / 1e6:.0f} MB"
                self._show(f"no node has {need} free for a run: waiting for one")
            self._slots, self._slots_at = slots, now
        return max(1, self._slots)

    def _slots_of(self, node: Mapping[str, Any]) -> int:
        has = node["Resources"]
        if node["NodeID"] in self._refused:
            return 0
        return int(min(has.get("CPU", 0) // self._cpus, has.get("memory", 0) // self._memory))

    @property
    def capacity(self) -> int:
        """The most runs to be with the cluster: no worker waits, nor does memory grow with them."""
        return 2 * self.slots + 1

    def start(self, job: Job) -> None:
        """Queue a run.

        Raises:
            ArjunaError: All nodes have been refused, or an input cannot be carried.
        """
        if self._refused and not any(map(self._slots_of, _nodes())):
            raise ArjunaError(f"no node can run this: {'; '.join(self._refused.values())}")
        carried = self._carried_of(job)
        order = order_of(job, carried.files, carried.inputs, self._program)
        options = {"num_cpus": self._cpus, "memory": self._memory, "name": job.campaign.name}
        if self._refused:
            options["label_selector"] = {"ray.io/node-id": f"!in({','.join(self._refused)})"}
        task = self._task.options(**options).remote(order, carried.contents, self._scratch)
        self._going[task] = job

    def ended(self, timeout: float) -> list[Ended]:
        """Return the jobs that ended, waiting for the first at most some time [s].

        Raises:
            ArjunaError: As `start`.
            OSError: A run's folder cannot be written.
        """
        import ray

        ray.wait(list(self._going), num_returns=1, timeout=timeout)
        ready, _ = ray.wait(list(self._going), num_returns=len(self._going), timeout=0)
        ends = [self._end(task) for task in ready]
        return [end for end in ends if end is not None]

    def stop(self) -> None:
        """End the runs in progress."""
        import ray

        for task in self._going:
            ray.cancel(task, force=True)
        self._going.clear()

    def _end(self, task: Any) -> Ended | None:
        import ray

        job = self._going.pop(task)
        try:
            answer = ray.get(task)
        except ray.exceptions.RayError as error:
            return Ended(job, None, _first(error))
        if "refused" in answer:
            if answer["node"] not in self._refused:
                self._refused[answer["node"]] = f"{answer['where']} has {answer['refused']}"
                self._show(f"refused: {self._refused[answer['node']]}")
                self._slots_at = -float("inf")
            self.start(job)
            return None
        if "died" in answer:
            return Ended(job, None, answer["died"])
        self._measure(answer["cpus"], answer["memory"])
        _write(job.folder, answer["files"])
        return Ended(job, Outcome(**answer["outcome"]))

    def _measure(self, cpus: float, memory: int) -> None:
        """Plan the runs that come with what the hungriest took, and a quarter more memory."""
        declared_cpus, declared_memory = self._declared
        if not declared_cpus:
            self._cpus = max(self._cpus, float(round(cpus)))
        if not declared_memory:
            before = self._memory if self._measured else 0
            self._memory = max(before, int(1.25 * memory))
        self._measured = True

    def _carried_of(self, job: Job) -> _Carried:
        """Return what a campaign's runs read, put into the object store once."""
        folder = job.folder.parent
        if folder not in self._carried:
            self._carried[folder] = _carried(job.campaign, folder, self._contents)
        return self._carried[folder]


@dataclass(frozen=True)
class _Carried:
    """The inputs of a campaign's runs, in the object store.

    Attributes:
        files: The SHA-256 of each, by its path.
        contents: References to the contents, by SHA-256.
        inputs: What else an order says of them.
    """

    files: Mapping[str, str]
    contents: Mapping[str, Any]
    inputs: Mapping[str, Any]


def _carried(campaign: Campaign, folder: Path, known: dict[str, Any]) -> _Carried:
    import ray

    found, files = inputs_of(campaign, folder), {}
    for path in found.files:
        data = read_bytes(path, LARGEST)
        digest = hashlib.sha256(data).hexdigest()
        files[str(path)] = digest
        if digest not in known:
            known[digest] = ray.put(data)
    folders = {"packages": found.packages, "modules": found.modules}
    named = {key: [str(each) for each in paths] for key, paths in folders.items()}
    inputs = {"working": str(found.working), "words": found.words, **named}
    return _Carried(files, {digest: known[digest] for digest in files.values()}, inputs)


def _task() -> Callable[..., dict[str, Any]]:
    """Return the function that a worker calls; it travels whole, as a worker may lack Arjuna."""

    def campaign_run(
        order: dict[str, Any], contents: dict[str, Any], scratch: str | None
    ) -> dict[str, Any]:
        import ray

        context = ray.get_runtime_context()
        where = {"node": context.get_node_id(), "where": f"node {ray.util.get_node_ip_address()}"}
        try:
            from bringup.campaign.worker import do
        except ImportError as error:
            return {"refused": f"no Arjuna that runs campaigns ({error})", **where}
        return {
            **do(order, lambda names: ray.get([contents[name] for name in names]), scratch),
            **where,
        }

    return campaign_run


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write a run's files into its folder.

    Raises:
        OSError: One cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        path = folder / name
        if not path.resolve().is_relative_to(folder.resolve()):
            raise OSError(0, f"a worker names {name!r}, outside the run's folder")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def _first(error: BaseException) -> str:
    """Return the first sentence of an error."""
    lines = [line for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
    return lines[0].split(". ")[0]
