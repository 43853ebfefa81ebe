"""The files that a campaign names, and those that these name, are found; no others travel."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.campaign.inputs import ELSEWHERE, Inputs, inputs_of
from bringup.campaign.plan import FOLDER, Campaign, CampaignError, Level


@pytest.fixture
def working(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def _write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def _inputs(words: str, folder: Path, **options: str) -> Inputs:
    levels = {name: (Level(value, {name: value}),) for name, value in options.items()}
    return inputs_of(Campaign("made", ("demo", *words.split()), "r.json", levels, {}), folder)


def _names(found: Inputs, root: Path) -> set[str]:
    return {str(path.relative_to(root)) for path in found.files}


def test_a_map_brings_its_image_and_a_tree_its_file(working: Path, tmp_path: Path) -> None:
    _write(working, {
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
    _write(tmp_path / "ws", {
        "bot/package.xml": "<package><name>bot</name></package>", "bot/urdf/bot.xacro":
        "<robot><xacro:include filename='$(find parts)/wheel.xacro'/></robot>",
        "parts/wheel.xacro": "<mesh filename='package://parts/meshes/wheel.stl'/>",
        "parts/meshes/wheel.stl": "solid", "parts/.git/config": "", "unused/package.xml": "",
        "shelf/model.sdf": "<sdf/>", "shelf/wood.png": "png",
    })  # fmt: skip
    _write(working, {"w.world": "<include><uri>model://shelf</uri></include>"})
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


def test_plug_ins_bring_the_modules_that_they_import(
    working: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _write(working, {
        "own.yaml": "Careful: {plugin: 'my_plugins.careful:Careful'}\n", "unused.py": "",
        "my_plugins/__init__.py": "", "my_plugins/careful.py": "import my_maths\n",
    })  # fmt: skip
    _write(tmp_path / "lib", {"my_maths.py": "FILE = 'numbers.csv'\n", "numbers.csv": "1"})
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "lib"))
    found = _inputs("--params own.yaml", tmp_path)
    assert _names(found, tmp_path) == {
        *("home/own.yaml", "home/my_plugins/__init__.py", "home/my_plugins/careful.py"),
        *("lib/my_maths.py", "lib/numbers.csv"),
    }
    assert set(found.modules) == {working, tmp_path / "lib"}


def test_a_file_beside_the_runs_is_found(working: Path, tmp_path: Path) -> None:
    _write(tmp_path / "out", {"parameters.yaml": "a: 1\n"})
    found = _inputs(f"--params {FOLDER}/../parameters.yaml", tmp_path / "out")
    assert list(found.files) == [tmp_path / "out" / "parameters.yaml"]


def test_a_path_that_holds_here_alone_is_refused(working: Path, tmp_path: Path) -> None:
    _write(tmp_path, {"far.pgm": "P5"})
    _write(working, {"room.yaml": f"image: {tmp_path / 'far.pgm'}\n"})
    with pytest.raises(CampaignError, match="which other machines lack; name it relative"):
        _inputs("--map room.yaml", tmp_path)
