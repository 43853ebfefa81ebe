"""The files of a recording: one file, or those of a rosbag2 folder, unpacked where compressed."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml
import zstandard

from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import plain

_METADATA = "metadata.yaml"
PACKED = ".zstd"
"""What ends the name of a compressed file: rosbag2 packs with nothing else."""

_LONGEST = 1 << 28  # bytes of a message that are believed
_SPARE = 1 << 30  # bytes that unpacking leaves free on the disk


class RecordingFiles:
    """The files of a recording.

    Args:
        path: A file or a folder.
        suffixes: Those of files that can be read.

    Attributes:
        files: The files, in the order of their times; what was compressed lies unpacked in a
            temporary folder for as long as this object lives.
        described: Whether a file of metadata lists them.

    Raises:
        InputFileError: It is no recording, or one of its files is missing or cannot be unpacked.
    """

    def __init__(self, path: Path, suffixes: tuple[str, ...]) -> None:
        self._valid = f"valid: a file of {', '.join(suffixes)}, or a folder of such files"
        if not path.exists():
            raise InputFileError(path, f"does not exist; {self._valid}")
        information = _information(path / _METADATA)
        self.described = information is not None
        self._packed = information is not None and _mode(information) == "message"
        files = _listed(path, information, suffixes) if path.is_dir() else [path]
        if not files:
            raise InputFileError(path, f"holds no recording; {self._valid}")
        self._check(files, suffixes)
        self._folder: TemporaryDirectory[str] | None = None
        self.files = [self._unpacked(file) for file in files]

    def _check(self, files: list[Path], suffixes: tuple[str, ...]) -> None:
        for file in files:
            if _suffix(file) not in suffixes or not file.is_file():
                raise InputFileError(file, f"is no recording; {self._valid}")

    def message(self, data: bytes) -> bytes:
        """Return a message's bytes, unpacked where each is compressed by itself.

        Args:
            data: Its bytes in the file.

        Raises:
            ValueError: They are damaged, or would be more than any message's.
        """
        if not self._packed:
            return data
        try:
            if zstandard.frame_content_size(data) > _LONGEST:
                raise ValueError(f"a message of more than {_LONGEST} bytes")
            return zstandard.decompress(data, max_output_size=_LONGEST)
        except zstandard.ZstdError as error:
            raise ValueError(f"a message cannot be unpacked: {error}") from error

    def _unpacked(self, file: Path) -> Path:
        if file.suffix != PACKED:
            return file
        self._folder = self._folder or TemporaryDirectory(prefix="recording_")
        copy = Path(self._folder.name, file.stem)
        try:
            with file.open("rb") as source, copy.open("wb") as target:
                for part in zstandard.ZstdDecompressor().read_to_iter(source):
                    target.write(part)
                    if shutil.disk_usage(copy).free < _SPARE:
                        raise InputFileError(file, "cannot be unpacked: the disk is full")
        except (zstandard.ZstdError, OSError) as error:
            raise InputFileError(file, f"cannot be unpacked: {error}") from error
        return copy


def _information(metadata: Path) -> dict[str, Any] | None:
    """Return what a folder's metadata says; None where it has none."""
    if not metadata.is_file():
        return None
    try:
        found = plain(metadata.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [Path(name).name for name in found["relative_file_paths"]]
        return {**found, "relative_file_paths": names}
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise InputFileError(metadata, f"is no metadata of rosbag2: {error}") from error


def _mode(information: dict[str, Any]) -> str:
    return str(information.get("compression_mode", "")).lower()


def _suffix(file: Path) -> str:
    return Path(file.name.removesuffix(PACKED)).suffix


def _listed(
    folder: Path, information: dict[str, Any] | None, suffixes: tuple[str, ...]
) -> list[Path]:
    if information is not None:
        return [folder / name for name in information["relative_file_paths"]]
    return sorted((file for file in folder.iterdir() if _suffix(file) in suffixes), key=_number)


def _number(file: Path) -> tuple[int, str]:
    """Return what sorts the files of a recording: `run_10.mcap` comes after `run_9.mcap`."""
    digits = file.name.split(".")[0].rpartition("_")[2]
    return (int(digits) if digits.isdecimal() else 0), file.name
