"""A campaign's file: its meaning, and the mistakes in one."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from bringup.campaign.plan import CampaignError, load_campaign, runs_of

GOOD = """
command: bench goals --json {folder}/r.json
result: r.json
success: {succeeded: 20}
factors:
  seed: {first: 3, count: 2}
  place:
    room: {world: a room.world, map: room.yaml}
    office: {world: office.world}
"""


def _file(folder: Path, text: str) -> Path:
    path = folder / "made.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_combination_is_run_in_the_file_s_order(tmp_path: Path) -> None:
    campaign = load_campaign(_file(tmp_path, GOOD))
    runs = runs_of(campaign)
    assert [run.name for run in runs] == ["0_3_room", "1_3_office", "2_4_room", "3_4_office"]
    assert runs[2].levels == {"seed": "4", "place": "room"}
    assert runs[2].words(campaign, Path("/out")) == [
        *("bench", "goals", "--json", "/out/r.json"),
        *("--seed", "4", "--world", "a room.world", "--map", "room.yaml"),
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("command:", "comand:", "'comand': did you mean 'command'"),
        ("result: r.json\n", "", "'result' is missing"),
        ("{folder}/r.json", "r.json", "write {folder} for it"),
        ("{first: 3, count: 2}", "{first: 3, count: 0}", "'first' and 'count' are whole numbers"),
        ("{first: 3, count: 2}", "7", "factor 'seed' is none of"),
        ("{succeeded: 20}", "20", "'success' is a mapping"),
        ("result: r.json", "result: r.json\ntimeout: -1", "'timeout' is a number of seconds"),
        (
            "result: r.json",
            "result: r.json\ncompare: plac",
            "'compare' names no factor: 'plac'; did",
        ),
        (GOOD, "[1, 2]", "is no mapping; valid keys: command"),
        (GOOD, "[[[[", "is no YAML"),
    ],
)
def test_mistakes_are_named(old: str, new: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match=message.replace("{", "\\{").replace("[", "\\[")):
        load_campaign(_file(tmp_path, GOOD.replace(old, new)))


def test_a_level_can_be_added(tmp_path: Path) -> None:
    campaign = load_campaign(_file(tmp_path, GOOD + "compare: place\n"))
    more = campaign.with_level("place", "mine", ["world=my.world", "param=a:=b=c"])
    assert campaign.conditions == []
    assert len(runs_of(more)) == 6
    run = runs_of(more)[2]
    assert (run.name, run.levels) == ("2_3_mine", {"seed": "3", "place": "mine"})
    assert run.options == {"seed": 3, "world": "my.world", "param": "a:=b=c"}
    with pytest.raises(ArjunaError, match="no factor 'plac'; did you mean 'place'"):
        campaign.with_level("plac", "mine", [])
    with pytest.raises(ArjunaError, match="'place' has a level 'room'; valid: a new name"):
        campaign.with_level("place", "room", [])
    with pytest.raises(ArjunaError, match="'world' is no option of a level; valid: NAME=VALUE"):
        campaign.with_level("place", "mine", ["world"])


def test_shipped_files_are_found_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    campaign = load_campaign(Path("campaigns/navigation_suite.yaml"))
    words = runs_of(campaign)[0].words(campaign, tmp_path)
    assert words[words.index("--world") + 1] == str(shipped_file("worlds/arjuna_room.world"))
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "arjuna_room.world").touch()
    assert "worlds/arjuna_room.world" in runs_of(campaign)[0].words(campaign, tmp_path)


def test_too_many_runs_are_refused(tmp_path: Path) -> None:
    text = GOOD.replace("count: 2", "count: 1000000000")
    with pytest.raises(ArjunaError, match="more than 100000 runs"):
        runs_of(load_campaign(_file(tmp_path, text)))


@pytest.mark.parametrize("path", sorted(shipped_file("campaigns").glob("*.yaml")), ids=str)
def test_shipped_campaigns_load(path: Path) -> None:
    assert runs_of(load_campaign(path))
