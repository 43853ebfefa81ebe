"""Claims: recordings are found, unpacked and listed; other files are refused by name."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import InputFileError
from tests.core.bags.recordings import MS, Cdr, times, write_numbers, write_words


@pytest.mark.parametrize("packed", ["NONE", "FILE", "MESSAGE"])
@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_compressed_recordings_give_the_same_messages(
    storage: str, packed: str, tmp_path: Path
) -> None:
    bag = Bag(write_words(tmp_path / "bag", storage, packed))
    found = list(bag.messages())
    assert [message.time // MS for message in found] == list(range(2000))
    assert found[7].data == Cdr().text("word 7").bytes()
    assert (bag.counts["/word"], bag.storage, bag.problems) == (2000, storage.lower(), [])


@pytest.mark.parametrize("packed", ["FILE", "MESSAGE"])
def test_what_cannot_be_unpacked_is_named(packed: str, tmp_path: Path) -> None:
    folder = write_words(tmp_path / "bag", "SQLITE3", packed)
    if packed == "FILE":
        (folder / "bag.db3.zstd").write_bytes(b"no archive" * 100)
        with pytest.raises(InputFileError, match=r"bag\.db3\.zstd: cannot be unpacked"):
            Bag(folder)
        return
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE messages SET data = x'28b52ffd00' WHERE id = 3")
    database.close()
    bag = Bag(folder)
    assert len(times(bag)) == 1999
    assert any("/word: a message cannot be unpacked" in line for line in bag.problems)


@pytest.mark.parametrize("name", ["missing.mcap", "text.mcap", "notes.txt", "empty"])
def test_what_is_no_recording_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "text.mcap").write_text("no recording")
    (tmp_path / "notes.txt").write_text("no recording")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputFileError, match=name):
        Bag(tmp_path / name)


def test_a_missing_file_of_a_folder_is_named(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    shutil.move(tmp_path / "bag" / "bag_0.mcap", tmp_path / "elsewhere.mcap")
    with pytest.raises(InputFileError, match=r"bag_0\.mcap"):
        Bag(tmp_path / "bag")
