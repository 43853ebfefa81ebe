"""Paths that clients name: where they lead, and which are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.maps_folder import MapsFolderError, path_in_folder


@pytest.mark.parametrize("name", ["a/b.yaml", "é" * 111])
def test_a_path_leads_into_the_folder(tmp_path: Path, name: str) -> None:
    assert path_in_folder(tmp_path, name) == tmp_path.resolve() / name


@pytest.mark.parametrize(
    ("url", "problem"),
    [
        ("link/secret.yaml", "lies outside the maps folder"),
        ("a/../../b.yaml", "lies outside the maps folder"),
        (".", "lies outside the maps folder"),
        ("file:///etc/passwd", "lies outside the maps folder"),
        ("http://example.org/map.yaml", "has the scheme 'http'; valid: file"),
        ("http://[", "is no path: Invalid IPv6 URL"),
        ("", "is no path; valid: a path in"),
        ("a\0b", "is no path; valid: a path in"),
        ("é" * 112, "is no path: a name is longer than 223 bytes"),
    ],
)
def test_other_paths_are_refused_also_through_links(tmp_path: Path, url: str, problem: str) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "link").symlink_to(tmp_path)
    with pytest.raises(MapsFolderError, match=problem):
        path_in_folder(tmp_path / "maps", url)
