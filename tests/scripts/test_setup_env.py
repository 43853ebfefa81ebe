"""The steps that the set-up repeats and skips; the contents of the lock file."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scripts import setup_env
from scripts.lock import for_linux, with_extras, with_hashes
from scripts.steps import Step, StepError, run
from tests.helpers.files import write_all, written

PIN = re.compile(
    r"^([A-Za-z0-9_.-]+)==([^ ;]+)( ; python_version [<>=]+ '[0-9.]+(\.\*)?')?"
    r"( --hash=sha256:[0-9a-f]{64})+(  # [a-z ]+)?$"
)


def locked() -> dict[str, str]:
    """Return the lock file's packages and their last version."""
    lines = [each for each in setup_env.LOCK.read_text().splitlines() if not each.startswith("#")]
    matches = [PIN.match(line) for line in lines]
    assert all(matches), [line for line, match in zip(lines, matches, strict=True) if not match]
    return {match[1].lower(): match[2] for match in matches if match}


def test_the_lock_file_pins_every_line_and_names_no_index() -> None:
    assert len(locked()) > 100
    assert "://" not in setup_env.LOCK.read_text()


def test_every_direct_dependency_is_in_the_lock_file() -> None:
    text = (setup_env.ROOT / "pyproject.toml").read_text()
    section = text[text.index("dependencies = [") : text.index("[project.scripts]")]
    names = {name.lower() for name in re.findall(r'"([A-Za-z][\w-]*)', section)}
    assert names - set(locked()) == {"arjuna-interfaces"}


def test_the_message_packages_are_built_with_the_locked_ros() -> None:
    text = (setup_env.MESSAGES / "pyproject.toml").read_text()
    pins = dict(re.findall(r'"(ros-[a-z-]+)(?:\[\w+\])?==([\w.]+)"', text))
    assert pins
    assert pins == {name: locked()[name] for name in pins}


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Point the set-up at a small tree of its own."""
    messages = tmp_path / "arjuna_interfaces"
    files = {
        "arjuna_interfaces/nav2_msgs/msg/Costmap.msg": "uint8[] data\n",
        "arjuna_nav/navfn.py": "from numba import njit\n",
        "pyproject.toml": "[project]\n",
        "requirements.lock": "numpy==2.4.6\nruff==0.17.6\noptuna==5  # tune\n",
        ".venv/bin/python": "",
    }
    write_all(tmp_path, files)
    (tmp_path / ".setup").mkdir()
    monkeypatch.setattr(setup_env, "ROOT", tmp_path)
    monkeypatch.setattr(setup_env, "STATE", tmp_path / ".setup")
    monkeypatch.setattr(setup_env, "MESSAGES", messages)
    monkeypatch.setattr(setup_env, "LOCK", tmp_path / "requirements.lock")
    monkeypatch.setattr(setup_env, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(setup_env, "PYTHON", tmp_path / ".venv" / "bin" / "python")
    return tmp_path


def test_a_stamp_holds_until_what_it_depends_on_changes_or_has_gone(checkout: Path) -> None:
    setup_env.write_stamp("packages", "a")
    assert setup_env.stamp_holds("packages", "a")
    assert not setup_env.stamp_holds("packages", "b")
    assert not setup_env.stamp_holds("messages", "a")
    (checkout / ".venv" / "bin" / "python").unlink()
    assert not setup_env.stamp_holds("packages", "a")


@pytest.mark.parametrize(
    ("file", "text", "again"),
    [
        ("arjuna_interfaces/nav2_msgs/msg/Costmap.msg", "int8[] data\n", ["messages"]),
        ("requirements.lock", "numpy==2.4.6\nruff==0.17.7\n", ["packages", "ours", "kernels"]),
        ("arjuna_nav/navfn.py", "from numba import njit, prange\n", ["kernels"]),
        ("arjuna_interfaces/build/lib/made", "", []),
        ("arjuna_interfaces/x.egg-info/made", "", []),
        ("arjuna_interfaces/rosidl_build/__pycache__/made", "", []),
    ],
)
def test_only_the_steps_that_depend_on_a_file_run_again(
    checkout: Path, file: str, text: str, again: list[str]
) -> None:
    before = setup_env.keys()
    written(checkout, text, file)
    steps = zip(("packages", "messages", "ours", "kernels"), before, setup_env.keys(), strict=True)
    assert [step for step, old, new in steps if new != old] == again


def test_another_extra_installs_nothing_else_again(checkout: Path) -> None:
    before = setup_env.keys(), setup_env.extra_key("view")
    tune = setup_env.extra_key("tune")
    setup_env.LOCK.write_text(setup_env.LOCK.read_text().replace("optuna==5", "optuna==6"))
    assert (setup_env.keys(), setup_env.extra_key("view")) == before
    assert setup_env.extra_key("tune") != tune


def test_extras_that_are_there_are_kept_up_to_date(checkout: Path) -> None:
    setup_env.write_stamp("extra-view", "a")
    assert setup_env.kept_extras({"tune"}) == ["view"]
    assert setup_env.kept_extras({"view"}) == []


def test_what_numba_compiled_goes_when_a_module_has_gone(checkout: Path) -> None:
    wing = checkout / "arjuna_nav" / "planners"
    compiled = wing / "__pycache__" / "navfn.plan-1.py311.nbi"
    compiled.parent.mkdir(parents=True)
    compiled.touch()
    (wing / "descent.py").touch()
    setup_env.forget_moved()
    (wing / "new.py").touch()
    setup_env.forget_moved()
    assert compiled.exists()
    (wing / "descent.py").rename(wing / "new.py")
    setup_env.forget_moved()
    assert not compiled.exists()


def test_a_folder_that_is_no_environment_is_not_overwritten(checkout: Path) -> None:
    with pytest.raises(StepError, match="is not an environment that this made; move it away"):
        setup_env.create_environment()


def test_a_failed_step_shows_its_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sh", "-c", "echo no space left; exit 3"]
    with pytest.raises(StepError, match=r"packing failed; the whole log is .*x\.log"):
        run(Step("packing", command, tmp_path / "x.log"))
    assert "no space left" in capsys.readouterr().out


def test_a_short_step_says_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(Step("nothing", ["true"], tmp_path / "x.log"))
    assert capsys.readouterr().out == ""


def test_a_universal_resolution_is_cut_down_to_linux() -> None:
    text = (
        "colorama==1 ; sys_platform == 'win32'\n"
        "librt==2 ; platform_python_implementation != 'PyPy'\n"
        "mypy==3 ; python_full_version < '3.11' and platform_python_implementation != 'PyPy'\n"
        "greenlet==4 ; python_full_version < '3.11' and (platform_machine == 'win32'"
        " or platform_machine == 'x86_64')\n"
        "exact==5 ; python_full_version < '3.11.5'\n"
    )
    assert for_linux(text) == (
        "librt==2\n"
        "mypy==3 ; python_version < '3.11'\n"
        "greenlet==4 ; python_version < '3.11'\n"
        "exact==5 ; python_full_version < '3.11.5'\n"
    )


def test_a_pinned_line_names_the_extras_that_alone_need_it() -> None:
    source = (
        "scipy\nyourdfpy\n# extra: tune\noptuna\n# extra: view (in a browser)\nembreex\nrerun\n"
    )
    resolved = (
        "embreex==1\n    # via\n    #   -r requirements.in\n    #   yourdfpy\n"
        "mako==2\n    # via optuna\n"
        "numpy==3 ; python_version < '3.11'\n    # via\n    #   optuna\n    #   scipy\n"
        "optuna==4\n    # via -r requirements.in\n"
        "pyarrow==5\n    # via\n    #   optuna\n    #   rerun\n"
        "rerun==6\n    # via -r requirements.in\n"
        "scipy==7\n    # via -r requirements.in\n"
        "yourdfpy==8\n    # via -r requirements.in\n"
    )
    assert with_extras(resolved, source).splitlines() == [
        "embreex==1  # view",
        "mako==2  # tune",
        "numpy==3 ; python_version < '3.11'",
        "optuna==4  # tune",
        "pyarrow==5  # tune view",
        "rerun==6  # view",
        "scipy==7",
        "yourdfpy==8",
    ]


PYLOCK = """
[[packages]]
name = "numba"
version = "1.0"
sdist = { url = "https://x/numba-1.0.tar.gz", hashes = {sha256 = "0" } }
wheels = [
    { url = "https://x/numba-1.0-cp311-cp311-manylinux_2_x86_64.whl", hashes = {sha256 = "a"} },
    { url = "https://x/numba-1.0-cp39-cp39-manylinux_2_x86_64.whl", hashes = {sha256 = "b"} },
    { url = "https://x/numba-1.0-cp313-cp313t-manylinux_2_x86_64.whl", hashes = {sha256 = "c"} },
    { url = "https://x/numba-1.0-cp311-cp311-musllinux_1_2_x86_64.whl", hashes = {sha256 = "d"} },
    { url = "https://x/numba-1.0-cp311-cp311-manylinux_2_aarch64.whl", hashes = {sha256 = "e"} },
    { url = "https://x/numba-1.0-cp38-abi3-manylinux2014_x86_64.whl", hashes = {sha256 = "f"} },
]

[[packages]]
name = "xacro"
version = "2.0"
sdist = { url = "https://x/xacro-2.0.tar.gz", hashes = {sha256 = "9" } }
"""


def test_a_pinned_line_has_the_hashes_of_the_files_that_fit() -> None:
    pylock = re.sub(r'sha256 = "(.)"', lambda match: f'sha256 = "{match[1] * 64}"', PYLOCK)
    assert with_hashes("numba==1.0 ; python_version < '3.11'  # view\nxacro==2.0\n", pylock) == (
        f"numba==1.0 ; python_version < '3.11' --hash=sha256:{'a' * 64} --hash=sha256:{'f' * 64}"
        f"  # view\nxacro==2.0 --hash=sha256:{'9' * 64}\n"
    )
    with pytest.raises(StepError, match="no file of yaml==3 can be installed on Linux on x86-64"):
        with_hashes("yaml==3\n", pylock)
