"""The files that a campaign's runs read, found by what names them, to take to other machines.

A word of the command that is a file's path names it; so does a word of a text file that is a path
from that file, from the working folder or, by its end, from a folder around it, a package:// or
model:// address, $(find PACKAGE), and the name of a Python module beside the working folder or on
PYTHONPATH, as plug-ins have.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import bringup
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.shipped import environment_folders
from arjuna_sim.files.search_path import MANIFESTS, EscapeError, SearchPath, is_file
from bringup.campaign.plan import FOLDER, LARGEST, Campaign, CampaignError

ELSEWHERE = "{elsewhere}"
"""The placeholder in a carried word for the folder that stands for `/` where the inputs lie."""
_SEARCHED = ("--package-path", "--model-path")
_TEXT_MAX = 4 << 20  # [bytes] of a file that may name others
_ADDRESS = re.compile(r"(?:package|model)://([\w.-]+)|\$\(find(?:-pkg-share)?\s+([\w.-]+)\)")
_PATH = re.compile(r"[^\s\"'<>()\[\]{},;=|&]+\.[A-Za-z]\w{0,9}")
_PHRASE = re.compile(r"[\"'>:][ \t]*([^\"'<>\n]+\.[A-Za-z]\w{0,9})[ \t]*[\"'<\n]")
_NAME = re.compile(r"[A-Za-z_]\w*")
_NAMES_MODULES = (".yaml", ".yml", ".py", ".xml")
_ROOT = Path(bringup.__file__).resolve().parents[1]


@dataclass
class Inputs:
    """Files to carry; elsewhere they lie below a folder that stands for `/`.

    Attributes:
        working: Where relative paths begin.
        words: The words of the command that are absolute paths, as they are elsewhere.
        packages: Folders in which packages and models are searched.
        modules: Folders in which Python modules are searched.
    """

    working: Path
    files: dict[Path, None] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)
    packages: dict[Path, None] = field(default_factory=dict)
    modules: dict[Path, None] = field(default_factory=dict)


def inputs_of(campaign: Campaign, folder: Path) -> Inputs:
    """Return what the runs of a campaign, in its folder, read.

    Raises:
        CampaignError: A file names another by a path that holds on this machine alone, or they are
            too large.
        InputFileError: A file cannot be read.
    """
    search = _Search(Path.cwd(), folder)
    levels = (level for levels in campaign.factors.values() for level in levels)
    options = (pair for level in levels for pair in level.options.items())
    search.add_words(campaign.command[1:])
    for name, value in options:
        search.add_words((f"--{name}", str(value)))
    search.close()
    return search.inputs


class _Search:
    """Finds inputs, and what they name in turn."""

    def __init__(self, working: Path, folder: Path) -> None:
        self.inputs = Inputs(working)
        self._run = folder / "run"
        self._waiting: list[Path] = []
        self._modules = dict(_modules(working))

    def add_words(self, words: Iterable[str]) -> None:
        """Add the files and folders that words of a command name."""
        before = ""
        for word in words:
            head, _, name = word.rpartition("=")
            path = _joined(self.inputs.working, name.replace(FOLDER, str(self._run)))
            if path.is_file():
                self._add(path)
            elif before in _SEARCHED and path.is_dir():
                self.inputs.packages[path] = None
            elif before.startswith("--") and path.is_dir():
                self._add_folder(path)
            if Path(name).is_absolute() and path.exists():
                self.inputs.words[word] = f"{head}{'=' if head else ''}{ELSEWHERE}{path}"
            before = word

    def close(self) -> None:
        """Add all that the files name, and what these name.

        Raises:
            CampaignError: As `inputs_of`.
        """
        given = tuple(self.inputs.packages)
        search, size = SearchPath.of(given, given), 0
        folders = *search.packages, *search.models
        while self._waiting:
            path = self._waiting.pop()
            size += path.stat().st_size
            if size > LARGEST:
                raise CampaignError(path, f"makes the inputs larger than {LARGEST >> 20} MB")
            for manifest in _manifests(path):
                self._add(manifest)
            text = _text(path)
            for name in dict.fromkeys(filter(None, sum(_ADDRESS.findall(text), ()))):
                if (package := search.package(path, name)) is not None:
                    self._add_folder(package)
                    if path.resolve() != path:  # elsewhere no link leads to what is around it
                        self.inputs.packages[package.parent] = None
            for found in dict.fromkeys([*_PATH.findall(text), *_PHRASE.findall(text)]):
                self._add_named(path, found, search)
            if path.suffix in _NAMES_MODULES:
                for name in self._modules.keys() & set(_NAME.findall(text)):
                    self._add_module(self._modules[name])
        for root in (_joined(self.inputs.working, str(each)) for each in folders):
            if any(path.is_relative_to(root) for path in self.inputs.files):
                self.inputs.packages[root] = None

    def _add(self, path: Path) -> None:
        if path not in self.inputs.files:
            self.inputs.files[path] = None
            self._waiting.append(path)

    def _add_folder(self, folder: Path) -> None:
        for path in sorted(folder.rglob("*")):
            hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
            if path.is_file() and not hidden and path.suffix != ".pyc":
                self._add(path)

    def _add_module(self, module: Path) -> None:
        self.inputs.modules[module.parent] = None
        (self._add if module.is_file() else self._add_folder)(module)

    def _add_named(self, path: Path, name: str, search: SearchPath) -> None:
        """Add a file that another one names, or one around it that is taken in its place.

        Raises:
            CampaignError: By a path from the root: another machine has none such.
        """
        for start in (path.parent, self.inputs.working):
            found = _joined(start, name)
            if "://" in name or not is_file(found):
                continue
            if Path(name).is_absolute():
                problem = f"names {name}, which other machines lack; name it relative to this file"
                raise CampaignError(path, problem)
            self._add(found)
            return
        if "://" not in name or name.startswith("file://"):
            with contextlib.suppress(EscapeError):
                if (instead := search.find(path, name)) is not None:
                    self._add(instead)


def _joined(start: Path, name: str) -> Path:
    return Path(os.path.normpath(start / name))


def _text(path: Path) -> str:
    """Return a file's text; "" of one that is none, or too long to name others."""
    if path.stat().st_size > _TEXT_MAX:
        return ""
    data = read_bytes(path, _TEXT_MAX)
    return "" if b"\0" in data else data.decode("utf-8", "replace")


def _manifests(path: Path) -> Iterator[Path]:
    """Yield those of the packages and models around a file, which say where its paths may lead."""
    for folder in path.parents:
        yield from filter(is_file, (folder / name for name in MANIFESTS))


def _modules(working: Path) -> Iterator[tuple[str, Path]]:
    """Yield the user's own modules and packages, by name; of Arjuna's folder, modules alone."""
    for root in (*reversed(environment_folders("PYTHONPATH")), working):
        yield from ((path.stem, path) for path in root.absolute().glob("*.py"))
        if root.resolve() != _ROOT:
            yield from ((path.parent.name, path.parent) for path in root.glob("*/__init__.py"))
