"""Claims: clients name maps in the open folders alone, and never a hidden file of the home."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.maps_folder import MapsFolderError, map_path


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders `maps`, `home` and `work` side by side, with links between them and out."""
    root = tmp_path.resolve()
    for name in ("maps", "home/.ssh", "work", "elsewhere"):
        (root / name).mkdir(parents=True)
    (root / "home/out").symlink_to(root / "elsewhere")
    (root / "home/in").symlink_to(root / "work")
    (root / "work/room.posegraph").symlink_to(root / "elsewhere/room.posegraph")
    monkeypatch.setenv("HOME", str(root / "home"))
    monkeypatch.chdir(root / "work")
    return root


@pytest.mark.parametrize(
    ("url", "expected"),
    [
        ("a/b", "maps/a/b"),
        ("../home/a", "home/a"),
        ("~/a", "home/a"),
        ("{root}/home/a", "home/a"),
        ("file://{root}/work/a", "work/a"),
        ("~/in/a", "work/a"),
        (".hidden", "maps/.hidden"),
        ("../work/a.b", "work/a.b"),
    ],
)
def test_a_path_is_found(folders: Path, url: str, expected: str) -> None:
    assert map_path(folders / "maps", url.format(root=folders)) == folders / expected


@pytest.mark.parametrize(
    "url",
    ["/etc/passwd", "../elsewhere/a", "~/out/a", "~/.ssh/id", "~/.bashrc", "~/", "..", "~/../a"],
)
def test_a_path_elsewhere_is_refused(folders: Path, url: str) -> None:
    with pytest.raises(MapsFolderError, match=r"is no place for maps; valid: paths in .*/maps, "):
        map_path(folders / "maps", url)


def test_a_suffix_is_added_once_and_links_are_followed_after_it(folders: Path) -> None:
    for name in ("a", "a.posegraph"):
        found = map_path(folders / "maps", name, ".posegraph")
        assert found == folders / "maps/a.posegraph"
    with pytest.raises(MapsFolderError, match="is no place for maps"):
        map_path(folders / "maps", "~/../work/room", ".posegraph")


def test_the_whole_disk_is_no_home(folders: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/")
    monkeypatch.chdir("/")
    with pytest.raises(MapsFolderError, match=r"valid: paths in .*/maps, none of them hidden"):
        map_path(folders / "maps", "/etc/passwd")
