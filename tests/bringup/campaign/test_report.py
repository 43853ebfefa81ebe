"""A campaign's page and what a paper prints of it: of the same runs always the same bytes."""

from __future__ import annotations

import base64
import hashlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import Campaign, Level, runs_of
from bringup.campaign.report import PAGE, PAPER, write_page

_DIGESTS = """
import sys
from pathlib import Path
from tests.bringup.campaign.test_report import digests, made, write
write(Path(sys.argv[1]), made(), float(sys.argv[2]))
print(digests(Path(sys.argv[1])))
"""


def made() -> Campaign:
    def levels(*labels: str) -> tuple[Level, ...]:
        return tuple(Level(label, {}) for label in labels)

    factors = {
        "scene": levels("room", "a & b"),
        "controller": levels("shipped", "mine"),
        "seed": levels(*map(str, range(8))),
    }
    return Campaign(
        "made", ("x", "{folder}"), "r.json", factors, {"ok": True}, ("time",), compare="controller"
    )


def result(levels: dict[str, str]) -> tuple[bool, float]:
    """Return a run's success and time: mine is slower by a second, and fails once."""
    seed, mine = int(levels["seed"]), levels["controller"] == "mine"
    return not (mine and levels["scene"] == "room" and seed == 3), 10.0 + seed**2 + mine


def write(folder: Path, campaign: Campaign, wall: float = 1.0) -> None:
    outcomes = []
    for run in runs_of(campaign):
        success, time = result(dict(run.levels))
        reason = "" if success else "touches 1 < 2"
        outcomes.append(Outcome(run.name, run.levels, success, reason, wall, {"time": time}))
        if not success:
            (folder / run.name).mkdir(parents=True, exist_ok=True)
            for file in ("goal_1.mcap", "goal_1.png", "log.txt"):
                (folder / run.name / file).touch()
    write_page(folder, campaign, outcomes)


def digests(folder: Path) -> dict[str, str]:
    paths = [folder / PAGE, *sorted((folder / PAPER).iterdir())]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    write(folder, made())
    return folder


def test_another_process_writes_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-c", _DIGESTS, str(tmp_path), "7.0"]
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        env={"PYTHONHASHSEED": "3", "SOURCE_DATE_EPOCH": "1", "PYTHONPATH": str(Path.cwd())},
    )
    found = digests(folder)
    assert done.stdout.strip() == str(found)
    assert set(found) == {
        *(PAGE, "results.md", "results.tex", "differences.md", "differences.tex"),
        *("success.pdf", "time.pdf"),
    }


def rows(path: Path) -> list[list[str]]:
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in path.open()]


def test_results_are_shown_by_condition_and_by_what_is_compared(folder: Path) -> None:
    head, _, *found = rows(folder / PAPER / "results.md")
    assert head == ["scene", "controller", "runs", "success", "95 % interval", "time"]
    assert [row[:4] for row in found] == [
        ["all runs", "shipped", "16", "16 of 16"],
        ["all runs", "mine", "16", "15 of 16"],
        ["room", "shipped", "8", "8 of 8"],
        ["room", "mine", "8", "7 of 8"],
        ["a & b", "shipped", "8", "8 of 8"],
        ["a & b", "mine", "8", "8 of 8"],
    ]
    assert found[2][4] == "67.6 to 100.0 %"
    assert found[2][5].startswith("28 [")


def test_differences_are_taken_between_runs_of_one_seed_and_scene(folder: Path) -> None:
    head, _, *found = rows(folder / PAPER / "differences.md")
    assert head[2:] == ["pairs", "only shipped", "only this", "p", "time"]
    assert found == [
        ["all runs", "mine", "16", "1", "0", "1.000", "1 *"],
        ["room", "mine", "8", "1", "0", "1.000", "1 *"],
        ["a & b", "mine", "8", "0", "0", "1.000", "1 *"],
    ]


def test_the_page_leads_to_what_shows_a_run_that_failed(folder: Path) -> None:
    page = (folder / PAGE).read_text(encoding="utf-8")
    links = re.findall(r'href="([^"]*)"', page)
    run = "11_room_mine_3"
    assert links == [f"{run}/", f"{run}/goal_1.mcap", f"{run}/goal_1.png"]
    assert all((folder / link).exists() for link in links)
    assert "touches 1 &lt; 2" in page


def test_the_page_has_its_pictures_within_it(folder: Path) -> None:
    page = (folder / PAGE).read_text(encoding="utf-8")
    pictures = re.findall(r'alt="(\w+)" src="data:image/png;base64,([^"]*)"', page)
    assert [name for name, _ in pictures] == ["success", "time"]
    assert all(base64.b64decode(data).startswith(b"\x89PNG") for _, data in pictures)
