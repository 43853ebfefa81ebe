"""Plans of campaigns and the files that they bring along."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import ArjunaError
from arjuna_core.files.shipped import shipped_file
from bringup.campaign.inputs import ELSEWHERE, Inputs, inputs_of
from bringup.campaign.plan import FOLDER, Campaign, CampaignError, Level, load_campaign, runs_of
from tests.helpers.files import write_all, written

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


def test_every_combination_is_run_in_the_file_s_order(tmp_path: Path) -> None:
    campaign = load_campaign(written(tmp_path, GOOD))
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
        load_campaign(written(tmp_path, GOOD.replace(old, new)))


def test_a_campaign_may_ask_nothing_of_its_results(tmp_path: Path) -> None:
    campaign = load_campaign(written(tmp_path, GOOD.replace("{succeeded: 20}", "{}")))
    assert campaign.success == {}


def test_a_level_can_be_added(tmp_path: Path) -> None:
    campaign = load_campaign(written(tmp_path, GOOD + "compare: place\n"))
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


def test_shipped_files_are_found_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
        runs_of(load_campaign(written(tmp_path, text)))


@pytest.mark.parametrize("path", sorted(shipped_file("campaigns").glob("*.yaml")), ids=str)
def test_shipped_campaigns_load(path: Path) -> None:
    assert runs_of(load_campaign(path))


@pytest.fixture
def working(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def _inputs(words: str, folder: Path, **options: str) -> Inputs:
    levels = {name: (Level(value, {name: value}),) for name, value in options.items()}
    return inputs_of(Campaign("made", ("demo", *words.split()), "r.json", levels, {}), folder)


def _names(found: Inputs, root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in found.files}


def test_a_map_brings_its_image_and_a_tree_its_file(working: Path, tmp_path: Path) -> None:
    write_all(working, {
        "maps/room.yaml": "image: the room.pgm\n", "maps/the room.pgm": "P5",
        "maps/other.pgm": "P5",
        "own.yaml": "bt_navigator: {default_nav_to_pose_bt_xml: trees/my.xml}\n",
        "trees/my.xml": "<root/>", "demo": "a file that the command's name is not",
    })  # fmt: skip
    found = _inputs("--map maps/room.yaml --out {folder}", tmp_path, params="own.yaml")
    expected = {"maps/room.yaml", "maps/the room.pgm", "own.yaml", "trees/my.xml"}
    assert _names(found, working) == expected
    assert found.words == {}


def test_packages_and_models_travel_whole(working: Path, tmp_path: Path) -> None:
    write_all(tmp_path / "ws", {
        "bot/package.xml": "<package><name>bot</name></package>", "bot/urdf/bot.xacro":
        "<robot><xacro:include filename='$(find parts)/wheel.xacro'/></robot>",
        "parts/wheel.xacro": "<mesh filename='package://parts/meshes/wheel.stl'/>",
        "parts/meshes/wheel.stl": "solid", "parts/.git/config": "", "unused/package.xml": "",
        "shelf/model.sdf": "<sdf/>", "shelf/wood.png": "png",
    })  # fmt: skip
    write_all(working, {"w.world": "<include><uri>model://shelf</uri></include>"})
    robot, ws = tmp_path / "ws" / "bot" / "urdf" / "bot.xacro", tmp_path / "ws"
    words = f"--robot={robot} --package-path {ws} --model-path {ws}"
    found = _inputs(words, tmp_path, world="w.world")
    assert _names(found, tmp_path) == {
        *("home/w.world", "ws/bot/package.xml", "ws/bot/urdf/bot.xacro", "ws/parts/wheel.xacro"),
        *("ws/parts/meshes/wheel.stl", "ws/shelf/model.sdf", "ws/shelf/wood.png"),
    }
    assert list(found.packages) == [ws]
    assert found.words == {
        f"--robot={robot}": f"--robot={ELSEWHERE}{robot}", str(ws): f"{ELSEWHERE}{ws}"
    }  # fmt: skip


def test_packages_of_one_name_stay_apart(
    working: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot finds what is around its file first; a folder to search would give it another's."""
    text = "<robot><xacro:include filename='$(find bot)/bot.gazebo'/></robot>"
    robots = [f"{ws}/bot/urdf/bot.xacro" for ws in ("one", "two")]
    for robot in robots:
        write_all(
            tmp_path, {robot: text, f"{robot[:7]}/bot.gazebo": "", f"{robot[:7]}/package.xml": ""}
        )
    assert not _inputs(" ".join(f"--robot {tmp_path / one}" for one in robots), tmp_path).packages
    write_all(tmp_path, {"lone.xacro": text})
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "two"))
    found = _inputs(f"--robot {tmp_path / 'lone.xacro'}", tmp_path)
    assert list(found.packages) == [tmp_path / "two"]
    assert tmp_path / "two/bot/bot.gazebo" in found.files


def test_what_is_found_around_a_file_for_a_path_of_elsewhere_travels(
    working: Path, tmp_path: Path
) -> None:
    """A package that is not here is taken to be the one that the file lies in."""
    write_all(tmp_path / "bot", {
        "urdf/bot.xacro": "<robot><xacro:include filename='$(find gone)/urdf/bot.gazebo'/></robot>",
        "urdf/bot.gazebo": "<mesh filename='file:///home/them/ws/bot/meshes/wheel.stl'/>",
        "meshes/wheel.stl": "solid", "meshes/unused.stl": "solid",
    })  # fmt: skip
    found = _inputs(f"--robot {tmp_path / 'bot/urdf/bot.xacro'}", tmp_path)
    assert _names(found, tmp_path / "bot") == {
        "urdf/bot.xacro", "urdf/bot.gazebo", "meshes/wheel.stl"
    }  # fmt: skip


def test_plug_ins_bring_the_modules_that_they_import(
    working: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_all(working, {
        "own.yaml": "Careful: {plugin: 'my_plugins.careful:Careful'}\n", "unused.py": "",
        "my_plugins/__init__.py": "", "my_plugins/careful.py": "import my_maths\n",
    })  # fmt: skip
    write_all(tmp_path / "lib", {"my_maths.py": "FILE = 'numbers.csv'\n", "numbers.csv": "1"})
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "lib"))
    found = _inputs("--params own.yaml", tmp_path)
    assert _names(found, tmp_path) == {
        *("home/own.yaml", "home/my_plugins/__init__.py", "home/my_plugins/careful.py"),
        *("lib/my_maths.py", "lib/numbers.csv"),
    }
    assert set(found.modules) == {working, tmp_path / "lib"}


def test_a_file_beside_the_runs_is_found(working: Path, tmp_path: Path) -> None:
    write_all(tmp_path / "out", {"parameters.yaml": "a: 1\n"})
    found = _inputs(f"--params {FOLDER}/../parameters.yaml", tmp_path / "out")
    assert list(found.files) == [tmp_path / "out" / "parameters.yaml"]


def test_a_path_that_holds_here_alone_is_refused(working: Path, tmp_path: Path) -> None:
    write_all(tmp_path, {"far.pgm": "P5"})
    write_all(working, {"room.yaml": f"image: {tmp_path / 'far.pgm'}\n"})
    with pytest.raises(CampaignError, match="which other machines lack; name it relative"):
        _inputs("--map room.yaml", tmp_path)
