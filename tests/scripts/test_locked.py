"""The lines of the lock file, by who needs them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scripts.locked import EXTRAS, INSTALLER, lines_of, wanted_extras
from scripts.setup_env import LOCK
from scripts.steps import StepError


def test_lines_are_told_apart_by_their_comments(tmp_path: Path) -> None:
    lock = tmp_path / "requirements.lock"
    lock.write_text(
        "# A header.\nnumpy==1 ; python_version < '3.11'\npyarrow==2  # campaign view\n"
        "rerun-sdk==3 ; python_version >= '3.11'  # view\n"
    )
    assert lines_of(lock) == ["numpy==1 ; python_version < '3.11'"]
    assert lines_of(lock, "campaign") == ["pyarrow==2"]
    assert lines_of(lock, "view") == ["pyarrow==2", "rerun-sdk==3 ; python_version >= '3.11'"]


def test_our_lock_file_has_no_other_extras() -> None:
    named = re.findall(r"  # ([a-z ]+)$", LOCK.read_text(), re.MULTILINE)
    assert {word for words in named for word in words.split()} == {*EXTRAS, INSTALLER}
    assert all(lines_of(LOCK, extra) for extra in EXTRAS)
    assert len(lines_of(LOCK, INSTALLER)) == 1


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (None, EXTRAS),
        ("all", EXTRAS),
        ("", ()),
        ("view", ("view",)),
        ("view,tune", ("tune", "view")),
    ],
)
def test_extras_are_all_unless_they_are_named(
    value: str | None, wanted: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("EXTRAS", raising=False)
    if value is not None:
        monkeypatch.setenv("EXTRAS", value)
    assert wanted_extras() == wanted


def test_an_unknown_extra_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EXTRAS", "view rviz")
    with pytest.raises(StepError, match="EXTRAS has no rviz; valid: campaign, dev, tune, view"):
        wanted_extras()
