"""A cluster's worker: runs in forks of a process of its own, which imports a robot once.

A Ray worker has threads, so it cannot fork whole processes. It starts `campaign --worker` beside
it and hands it one run a line; the answer is a line too. All of it is plain JSON, so that a worker
of another version can read what is asked of it, and refuse.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import platform
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

import bringup
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.whole_file import own_folder
from bringup.campaign.inputs import ELSEWHERE
from bringup.campaign.plan import LARGEST, Campaign, Run
from bringup.campaign.pool import PROGRAM, Forks, Job, LocalPool
from bringup.processes.fork import die_with

_SOURCES = ("arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav", "bringup")
_SHIPPED = ("urdf", "worlds", "maps", "params", "behavior_trees")
_BENCHMARKS = ("tests/bench", "tests/helpers")
_LIBRARIES = (
    *("google-re2", "llvmlite", "mapbox-earcut", "matplotlib", "mcap", "mujoco", "numba"),
    *("numpy", "pillow", "ros-jazzy-rclpy", "scipy", "trimesh", "xacro", "yourdfpy"),
)
Fetch = Callable[[Sequence[str]], Iterable[bytes]]
"""Returns the contents of files by their SHA-256, in order."""


@functools.cache
def identity(benchmarks: bool = False) -> dict[str, str]:
    """Return what must be the same for runs to give the same bytes: versions, and our files'."""
    root, found = Path(bringup.__file__).resolve().parents[1], hashlib.sha256()
    folders = [root / name for name in (*_SOURCES, *(_BENCHMARKS if benchmarks else ()))]
    for folder in (*folders, *map(shipped_file, _SHIPPED)):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                found.update(f"{folder.name}/{path.relative_to(folder)}\0".encode())
                found.update(hashlib.sha256(read_bytes(path, LARGEST)).digest())
    arjuna = f"{_version('arjuna')} (files {found.hexdigest()[:12]})"
    libraries = {name: _version(name) for name in _LIBRARIES}
    return {"Arjuna": arjuna, "Python": platform.python_version(), "machine": platform.machine(),
            **libraries}  # fmt: skip


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "none"


def order_of(
    job: Job, files: Mapping[str, str], inputs: Mapping[str, Any], program: Sequence[str]
) -> dict[str, Any]:
    """Return what a worker needs to do a job, as JSON carries it.

    Args:
        files: The SHA-256 of each input, by its path.
        inputs: `working`, `words`, `packages` and `modules` of the `Inputs`, as text.
    """
    one, run, words = job.campaign, job.run, inputs["words"]
    return {
        "identity": identity(one.command[:1] == ("bench",)),
        "campaign": {
            "name": one.name,
            "command": [words.get(word, word) for word in one.command],
            "result": one.result,
            "success": dict(one.success),
            "timeout": one.timeout,
        },
        "run": {**asdict(run), "options": {k: words.get(v, v) for k, v in run.options.items()}},
        "folder": str(job.folder),
        "files": files,
        **inputs,
        "program": None if program == PROGRAM else list(program),
    }


def do(order: Mapping[str, Any], fetch: Fetch, scratch: str | None = None) -> dict[str, Any]:
    """Do a run on this machine, its files meanwhile in a folder, or the system's.

    Returns:
        `outcome`, `files` (contents by path in the run's folder), `cpus` that it kept busy and
        `memory` [bytes]; only `refused`, and what differs, where versions do; only `died` where
        the process of the runs ended.
    """
    wanted = order["identity"]
    here = identity(order["campaign"]["command"][:1] == ["bench"])
    other = [name for name in wanted if here.get(name) != wanted[name]]
    if other:
        return {"refused": "; ".join(f"{k} {here.get(k)}, not {wanted[k]}" for k in other)}
    return _worker(scratch).do(order, fetch)


@functools.cache
def _worker(scratch: str | None) -> _Worker:
    return _Worker(scratch)


class _Worker:
    """The process that does a Ray worker's runs, one at a time, and the files that they need."""

    def __init__(self, scratch: str | None) -> None:
        self._folder = own_folder("worker", Path(scratch) if scratch else None)
        self._root = Path(self._folder.name)
        self._process = self._started()

    def do(self, order: Mapping[str, Any], fetch: Fetch) -> dict[str, Any]:
        """Do a run and return what `do` returns."""
        tree = self._tree(order["files"], fetch)
        folder = _below(tree, order["folder"])
        try:
            answer = self._answer({**order, "tree": str(tree)})
            return {**answer, "files": {
                str(path.relative_to(folder)): read_bytes(path, LARGEST)
                for path in sorted(folder.rglob("*")) if path.is_file()
            }}  # fmt: skip
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _answer(self, order: Mapping[str, Any]) -> dict[str, Any]:
        if self._process.poll() is not None:
            self._process = self._started()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{json.dumps(order)}\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            return {"died": f"the process that forks runs ended with {code}"}
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _started(self) -> subprocess.Popen[str]:
        return subprocess.Popen(  # noqa: S603 - our own module, no shell
            [*PROGRAM, "campaign", "--worker", str(os.getpid())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def _tree(self, files: Mapping[str, str], fetch: Fetch) -> Path:
        """Return a folder with the inputs, made once for each set of them."""
        name = hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()
        tree, blobs = self._root / "trees" / name, self._root / "blobs"
        if tree.exists():
            return tree
        blobs.mkdir(exist_ok=True)
        lacking = sorted({each for each in files.values() if not (blobs / each).exists()})
        for each, data in zip(lacking, fetch(lacking), strict=True):
            (blobs / each).write_bytes(data)
            (blobs / each).chmod(0o400)
        part = Path(tempfile.mkdtemp(dir=self._root))
        for path, each in files.items():
            target = _below(part, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.hardlink_to(blobs / each)
        tree.parent.mkdir(exist_ok=True)
        return part.rename(tree)


def _below(tree: Path, path: str) -> Path:
    return tree / path.lstrip("/")


class _Runs:
    """Does runs in forks of this process."""

    def __init__(self, forks: Forks | None) -> None:
        self._forks = LocalPool(1, forks=forks)
        self._path = sys.path[1:]  # without the folder that this process was started in

    def do(self, order: Mapping[str, Any]) -> dict[str, Any]:
        """Do a run; return its outcome, the CPUs it kept busy and the memory it took [bytes]."""
        tree, program = Path(order["tree"]), order["program"]
        self._enter(tree, order)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        pool = self._forks if program is None else LocalPool(1, program)
        pool.start(_job(order, tree))
        while not (ended := pool.ended(60.0)):
            pass
        (end,) = ended
        assert end.outcome is not None
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        cpus = busy / max(end.outcome.wall_s, 0.1)
        return {"outcome": asdict(end.outcome), "cpus": cpus, "memory": 1024 * after.ru_maxrss}

    def _enter(self, tree: Path, order: Mapping[str, Any]) -> None:
        """Make this process, and so its forks, find what the run names."""
        from arjuna_sim.files.search_path import MODEL_VARIABLE, PACKAGE_VARIABLE

        working = _below(tree, order["working"])
        working.mkdir(parents=True, exist_ok=True)
        os.chdir(working)
        packages, modules = (
            [str(_below(tree, path)) for path in order[key]] for key in ("packages", "modules")
        )
        sys.path[:] = [str(working), *modules, *self._path]
        os.environ[PACKAGE_VARIABLE] = os.environ[MODEL_VARIABLE] = os.pathsep.join(packages)
        os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)


def _job(order: Mapping[str, Any], tree: Path) -> Job:
    def placed(word: Any) -> Any:
        return word.replace(ELSEWHERE, str(tree)) if isinstance(word, str) else word

    run = {**order["run"], "options": {k: placed(v) for k, v in order["run"]["options"].items()}}
    one = {**order["campaign"], "command": tuple(map(placed, order["campaign"]["command"]))}
    return Job(Campaign(**one, factors={}), Run(**run), _below(tree, order["folder"]))


def serve(forks: Forks | None, parent: int) -> None:
    """Do the runs that lines of standard input ask for, until it or the parent process ends."""
    die_with(parent)
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)  # what is printed here is no answer
        runs = _Runs(forks)
        for line in sys.stdin:
            answers.write(f"{json.dumps(runs.do(json.loads(line)))}\n")
            answers.flush()
