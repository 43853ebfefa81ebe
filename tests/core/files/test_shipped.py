"""Files of packages: found below the environment's prefixes, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import package_file


@pytest.mark.parametrize(
    ("package", "named", "found"),
    [
        ("robot", "trees/a.xml", True),
        ("robot", "trees/b.xml", False),
        ("other", "trees/a.xml", False),
        ("", "robot/trees/a.xml", False),
        ("robot", "../robot/trees/a.xml", False),
        ("../share/robot", "trees/a.xml", False),
    ],
)
def test_a_file_is_of_a_packages_share(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, named: str, found: bool
) -> None:
    file = tmp_path / "share" / "robot" / "trees" / "a.xml"
    file.parent.mkdir(parents=True)
    file.write_text("<root/>", encoding="utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'none'}:{tmp_path}")
    assert package_file(package, named) == (file if found else None)
    assert package_file("robot", str(file)) is None
