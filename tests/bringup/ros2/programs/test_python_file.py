"""Programs that `ros2 run` knows: rviz2 and Python files."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bringup.ros2.main import main
from bringup.ros2.programs import rviz2
from bringup.ros2.verbs.remedies import module_remedy

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


@pytest.mark.parametrize(
    ("module", "remedy"),
    [
        ("cv9", "'pip install cv9' may bring it; of your own: 'source install/setup.bash'"),
        ("rqt_plot", "'arjuna view' has plots"),
        ("somebodys_msgs.msg", "'arjuna messages FOLDER'"),
        ("json.wibble", "'json' has no such part"),
    ],
)
def test_a_module_that_a_program_lacks_is_named_with_its_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], module: str, remedy: str
) -> None:
    path = tmp_path / "listing.py"
    path.write_text(f"import sys\nimport {module}\nprint(sys)\n")
    assert main(["run", str(path)]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"{path}, line 2: the module '{module.partition('.msg')[0]}")
    assert remedy in said


def test_modules_are_named_as_pip_does() -> None:
    assert module_remedy("cv2").startswith("'pip install opencv-python' may bring it")
