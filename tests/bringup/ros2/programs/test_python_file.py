"""Programs that `ros2 run` knows: rviz2 and Python files."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bringup.ros2.main import main
from bringup.ros2.programs import rviz2

MAIN = "import sys\n\ndef main():\n    print('ran', *sys.argv[1:])\n"


@pytest.mark.parametrize(
    "ending",
    ["", "if __name__ == '__main__':\n    main()\n", "main()\n", "sys.exit(main())\n"],
)
def test_main_is_called_once_whether_or_not_the_file_calls_it(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    ending: str,
) -> None:
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    monkeypatch.setattr(sys, "path", list(sys.path))
    path = tmp_path / "listing.py"
    path.write_text(MAIN + ending)
    if "exit" in ending:
        with pytest.raises(SystemExit, match=r"^$"):
            main(["run", str(path), "a", "--ros-args", "-p", "b:=1"])
    else:
        assert main(["run", str(path), "a", "--ros-args", "-p", "b:=1"]) == 0
    assert capsys.readouterr().out == "ran a --ros-args -p b:=1\n"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "class Talker:\n    pass\n\ndef helper():\n    pass\n",
            "defines Talker, helper and calls",
        ),
        ("", "defines nothing and calls none of it"),
        ("def main(:\n", "is no Python: "),
        (
            "import nowhere.at_all\nprint()",
            "the module nowhere is not installed; 'python -m pip install now",
        ),
        ("def main():\n    import sklearnx", "pip install sklearnx'"),
        (
            "import some_robot_msgs.msg\nprint()",
            "some_robot_msgs is not installed; put the package's source",
        ),
        ("import rqt_plot\nprint()", "rqt_plot is not installed; 'arjuna view' has plots"),
        (None, "cannot be read: No such file"),
    ],
)
def test_what_cannot_run_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str | None, problem: str
) -> None:
    path = tmp_path / "listing.py"
    if text is not None:
        path.write_text(text)
    assert main(["run", str(path)]) == 1
    assert problem in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "options"),
    [
        ([], []),
        (["-d", "nav2.rviz"], ["--config", "nav2.rviz"]),
        (["--display-config", "a.rviz", "-f", "odom"], ["--config", "a.rviz", "--frame", "odom"]),
        (["-d", "a.rviz", "-s", "none", "--ros-args", "-r", "__node:=r"], ["--config", "a.rviz"]),
        (["-d", "nowhere/b.rviz", "-f", "odom"], ["--frame", "odom"]),
    ],
)
def test_its_options_are_the_view_s(
    given: list[str], options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("nav2.rviz", "a.rviz"):
        (tmp_path / name).touch()
    started: list[object] = []
    monkeypatch.setattr(rviz2, "arjuna", lambda command, words: started.append((command, words)))
    rviz2.main(given)
    assert started == [("view", options)]
