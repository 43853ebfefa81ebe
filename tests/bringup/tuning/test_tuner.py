"""Tuning: the space of parameters and its search."""

from __future__ import annotations

import dataclasses
import random
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from arjuna_core.param import ParamInfo
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import CampaignError
from bringup.campaign.pool import Ended, Job, LocalPool
from bringup.tuning.picture import PICTURE, write_picture
from bringup.tuning.plan import Known, Tuning, Value, dimensions_of, load_tuning
from bringup.tuning.study import FILE, Study, Tried
from bringup.tuning.tuner import BEST, Tuner

_FILE = """
command: drive {folder}
result: r.json
success: {reached: true}
factors:
  seed: [0, 1]
minimize: time
parameters:
  driver:
    speed: {low: 0.1, high: 2.0}
    idle: {low: 0.0, high: 1.0}
    model: [beam, field]
confirm:
  seed: {first: 10, count: 2}
"""
_NOW: dict[str, Value] = {"driver: speed": 0.5, "driver: idle": 0.5, "driver: model": "field"}
# It drives faster with more speed, and misses its goal above 1.5 m/s; `idle` does nothing.
_PROGRAM = """
import json, pathlib, sys
import yaml
folder = pathlib.Path(sys.argv[2])
files = [sys.argv[i + 1] for i, word in enumerate(sys.argv) if word == "--params"]
values = yaml.safe_load(open(files[-1]))["driver"]["ros__parameters"]
result = {"reached": values["speed"] <= 1.5, "time": 10.0 / values["speed"]}
(folder / "r.json").write_text(json.dumps(result))
"""


def _known(files: object) -> Known:
    return {
        "driver": {
            "speed": (0.5, ParamInfo("Speed.", "m/s", 0.0, 5.0)),
            "idle": (0.5, ParamInfo("Nothing.")),
            "model": ("field", ParamInfo("Which.", choices=("beam", "field"))),
        }
    }


def _tuning(folder: Path, trials: int = 4, text: str = _FILE) -> Tuning:
    folder.mkdir(exist_ok=True)
    path = folder / "made.yaml"
    path.write_text(text, encoding="utf-8")
    return dataclasses.replace(load_tuning(path, _known), trials=trials)


def _outcomes(values: Mapping[str, Any]) -> list[Outcome]:
    """Return what the stand-in would find, without a process."""
    speed = float(values["driver: speed"])
    reached = speed <= 1.5
    figures = {"time": 10.0 / speed} if speed > 0.3 else {}
    return [Outcome("0", {}, reached, "" if reached else "missed", 1.0, figures)]


def _studied(tuning: Tuning, folder: Path, trials: int) -> Study:
    study = Study(tuning, folder)
    for _ in range(len(study.tried()), trials):
        values = study.proposal(len(study.tried()))
        study.add(values, _outcomes(values))
    return study


def test_it_finds_the_fastest_that_succeeds_and_what_mattered(tmp_path: Path) -> None:
    study = _studied(_tuning(tmp_path), tmp_path, 40)
    first, best = study.tried()[0], study.ranked()[0]
    assert first.values == _NOW
    assert best.failed == 0
    assert 1.2 < float(best.values["driver: speed"]) <= 1.5
    shares = study.importance()
    assert next(iter(shares)) == "driver: speed"
    assert sum(shares.values()) == pytest.approx(1.0)


def test_failed_runs_and_missing_figures_rank_last(tmp_path: Path) -> None:
    study = Study(_tuning(tmp_path), tmp_path)
    for speed in (0.5, 1.9, 0.2, 1.0):
        values = {**_NOW, "driver: speed": speed}
        study.add(values, _outcomes(values))
    assert [one.number for one in study.ranked()] == [3, 0, 2, 1]
    assert study.tried()[2].figure == float("inf")
    assert study.importance() == {}


def test_a_resumed_study_is_the_one_that_was_never_broken_off(tmp_path: Path) -> None:
    whole = _studied(_tuning(tmp_path), tmp_path, 14).tried()
    (tmp_path / FILE).unlink()
    for trials in (5, 12, 14):
        parts = _studied(_tuning(tmp_path), tmp_path, trials).tried()
    assert parts == whole


def test_a_folder_is_of_one_tuning(tmp_path: Path) -> None:
    _studied(_tuning(tmp_path), tmp_path, 1)
    with pytest.raises(CampaignError, match="has the trials of another tuning"):
        Study(_tuning(tmp_path, text=_FILE.replace("high: 2.0", "high: 3.0")), tmp_path)
    (tmp_path / FILE).write_text("no study\n", encoding="utf-8")
    with pytest.raises(CampaignError, match="is no study"):
        Study(_tuning(tmp_path), tmp_path)


def _tuner(tuning: Tuning, folder: Path, stop: threading.Event | None = None) -> Tuner:
    pool = LocalPool(2, (sys.executable, "-c", _PROGRAM))
    return Tuner(tuning, folder, pool, stop or threading.Event())


def test_trials_are_run_reported_and_resumed(tmp_path: Path) -> None:
    reported: list[Tried] = []
    assert _tuner(_tuning(tmp_path, 2), tmp_path).run(reported.append)
    assert (reported[0].number, reported[0].failed) == (0, 0)
    assert reported[0].figure == pytest.approx(20.0)
    assert (tmp_path / "trials" / "0001" / "1_1" / "outcome.json").exists()
    best = (tmp_path / BEST).read_text(encoding="utf-8")
    assert best.startswith("# made: trial ")
    again: list[Tried] = []
    tuner = _tuner(_tuning(tmp_path, 3), tmp_path)
    assert tuner.run(again.append)
    assert again[:2] == reported
    assert len(again) == 3
    write_picture(tmp_path, _tuning(tmp_path), tuner.study)
    assert (tmp_path / PICTURE).read_bytes().startswith(b"\x89PNG")


class _Shuffled:
    """A pool without processes, whose runs end in an order of its own."""

    slots = 4

    def __init__(self, order: int, capacity: int = 4) -> None:
        self._rng, self.capacity = random.Random(order), capacity
        self._going: list[Job] = []
        self.most = 0

    def start(self, job: Job) -> None:
        self._going.append(job)
        self.most = max(self.most, len({job.folder.parent for job in self._going}))

    def ended(self, timeout: float) -> list[Ended]:
        job = self._going.pop(self._rng.randrange(len(self._going)))
        text = (job.folder.parent / "parameters.yaml").read_text(encoding="utf-8")
        values = {f"driver: {k}": v for k, v in
                  yaml.safe_load(text)["driver"]["ros__parameters"].items()}  # fmt: skip
        (outcome,) = _outcomes(values)
        job.folder.mkdir(exist_ok=True)
        return [Ended(job, dataclasses.replace(outcome, name=job.run.name))]

    def stop(self) -> None:
        self._going.clear()


def _tried_on(pool: _Shuffled, folder: Path, at_once: int, trials: int = 16) -> list[Tried]:
    tuner = Tuner(_tuning(folder, trials), folder, pool, threading.Event(), at_once)
    assert tuner.run(lambda one: None)
    return tuner.study.tried()


def test_trials_side_by_side_do_not_depend_on_who_ends_first(tmp_path: Path) -> None:
    pools = [_Shuffled(order) for order in (1, 2)]
    first, second = (_tried_on(pool, tmp_path / f"{n}", 3) for n, pool in enumerate(pools))
    assert first == second
    assert [pool.most for pool in pools] == [3, 3]
    parts = [_tried_on(_Shuffled(3), tmp_path / "parts", 3, trials) for trials in (5, 16)]
    assert parts[1] == first
    assert first != _tried_on(_Shuffled(4), tmp_path / "alone", 1)


def test_the_winner_is_compared_on_runs_that_did_not_choose_it(tmp_path: Path) -> None:
    tuner = _tuner(_tuning(tmp_path), tmp_path)
    tuner.study.add(_NOW, _outcomes(_NOW))
    assert tuner.confirm() == []
    better = {**_NOW, "driver: speed": 1.0}
    tuner.study.add(better, _outcomes(better))
    lines = tuner.confirm()
    assert "second with trial 2's" in lines[0]
    assert any(line.split()[:3] == ["time", "20", "10"] for line in lines)
    assert {one.name for one in (tmp_path / "confirm" / "now").glob("*_*")} == {"0_10", "1_11"}


def test_one_broken_off_is_no_trial(tmp_path: Path) -> None:
    stop = threading.Event()
    stop.set()
    tuner = _tuner(_tuning(tmp_path), tmp_path, stop)
    assert not tuner.run(lambda one: None)
    assert tuner.study.tried() == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("minimize: time", "", "name one figure of the result"),
        ("minimize: time", "minimize: time\nmaximize: time", "name one figure of the result"),
        ("minimize: time", "minimise: time", "'minimise': did you mean 'minimize'"),
        ("minimize: time", "minimize: time\ntrials: 0", "'trials' is a whole number above 0"),
        ("minimize: time", "minimize: time\nparams: 3", "'params' is a list"),
        ("speed:", "sped:", "unknown parameter 'sped'"),
        ("{first: 10, count: 2}", "3", "'confirm': factor 'seed' is none of"),
    ],
)
def test_mistakes_of_the_file_are_named(old: str, new: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match=message):
        _tuning(tmp_path, text=_FILE.replace(old, new))


_KNOWN = {
    "driver": {
        "speed": (0.5, ParamInfo("Greatest speed.", "m/s", 0.0, 2.0)),
        "count": (100, ParamInfo("Particles.", "", 1, 5000)),
        "model": ("field", ParamInfo("Which model.", choices=("beam", "field"))),
        "regulated": (True, ParamInfo("Whether bends slow down.")),
        "names": (("a",), ParamInfo("A list.")),
    }
}


def _one(key: str, given: Any) -> Any:
    found, problems = dimensions_of({"driver": {key: given}}, _KNOWN)
    return problems[0] if problems else found[0]


def test_ranges_and_choices_are_read_with_the_value_of_now() -> None:
    speed = _one("speed", {"low": 0, "high": 1.5})
    assert (speed.name, speed.now, speed.low, speed.high) == ("driver: speed", 0.5, 0.0, 1.5)
    assert (speed.unit, speed.whole, speed.log) == ("m/s", False, False)
    count = _one("count", {"low": 10, "high": 1000, "log": True})
    assert count.whole
    assert count.log
    assert _one("model", ["beam", "field"]).choices == ("beam", "field")
    assert _one("speed", [0.5, 1]).choices == (0.5, 1)
    assert not _one("regulated", [False, True]).whole


@pytest.mark.parametrize(
    ("key", "given", "problem"),
    [
        ("sped", [1.0], "unknown parameter 'sped'; did you mean 'speed'"),
        ("speed", 0.7, "'speed' is no range; valid: {low, high}"),
        ("speed", {"low": 0.1}, "'speed' is no range"),
        ("speed", {"low": 0.1, "high": 0.7, "step": 1}, "'speed' is no range"),
        ("speed", {"low": "a", "high": 0.7}, "'speed' must be float, got 'a' (str)"),
        ("speed", {"low": 0.9, "high": 0.2}, "low lies below high"),
        ("speed", {"low": 0.0, "high": 0.7, "log": True}, "above 0 for log"),
        ("speed", {"low": 0.1, "high": 9.0}, "'speed' is 9.0; the greatest valid is 2.0 m/s"),
        ("speed", {"low": 0.6, "high": 0.9}, "is 0.5 now, outside 0.6 to 0.9: widen"),
        ("speed", [0.5, 7.0], "'speed' is 7.0; the greatest valid is 2.0 m/s"),
        ("speed", [0.5, True], "'speed' must be float, got True (bool)"),
        ("count", {"low": 1.5, "high": 10}, "'count' must be int, got 1.5 (float)"),
        ("model", ["beam", "laser"], "'model' is 'laser'; valid: beam, field"),
        ("model", ["beam"], "is 'field' now, which its values leave out"),
        ("model", {"low": 0, "high": 1}, "list its values"),
        ("regulated", {"low": 0, "high": 1}, "list its values"),
        ("names", ["a"], "no number, truth or word"),
    ],
)
def test_mistakes_are_named(key: str, given: Any, problem: str) -> None:
    assert problem in _one(key, given)


def test_every_mistake_is_named_at_once() -> None:
    space = {"diver": {"speed": [1.0]}, "driver": {"speed": 1, "cont": [1]}}
    _, problems = dimensions_of(space, _KNOWN)
    assert len(problems) == 3
    assert "no node 'diver'; did you mean 'driver'" in problems[0]


@pytest.mark.parametrize("space", [None, {}, {"driver": {}}, {"driver": 1}, [1]])
def test_a_space_of_nothing_is_refused(space: Any) -> None:
    assert dimensions_of(space, _KNOWN)[1]
