"""Expanding xacro macros of one file, as a process whose time and memory are limited.

It reads a request (JSON) on its standard input and answers on its standard output. Of arjuna_sim it
imports no more than it needs, so that it starts at once.

xacro itself is as it came. It reads files through the `open` that stands in its namespace and finds
packages through `ament_index_python`: both are given to it here.
"""

from __future__ import annotations

import builtins
import contextlib
import io
import json
import re
import resource
import signal
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import xacro
from defusedxml import DefusedXmlException, ElementTree, minidom
from xacro import XacroException

from arjuna_core.files.input_file import read_text
from arjuna_sim.files.search_path import SearchPath, home_folder
from arjuna_sim.model.notes import NoteKind

_MEMORY_BYTES = 400_000_000
_FILE_BYTES = 5_000_000
_OUTPUT_BYTES = 5_000_000
_CONDITIONS = ("xacro:if", "xacro:unless")
_REMEDIES = (
    ("unknown macro name", "<xacro:include> a file that defines it, or correct its name"),
    ("is not defined when evaluating", "<xacro:property> or <xacro:arg> defines it"),
    ("Undefined parameters", "a call of its macro must give it a value, or params a default"),
    ("Undefined block", "params names it with a star, *NAME, and the call of its macro holds it"),
    ("when evaluating expression", "what stands in ${} is Python"),
)
_VALUE = re.compile(r"=\s*(\"[^\"]*\$\([^\"]*\"|'[^']*\$\([^']*')")
"""An attribute's value that asks for arguments, by `arg` or `eval`."""
_UNKNOWN = re.compile(r"unknown macro name: (\S+)")
_BARE = re.compile(r"<!--.*?-->|<(macro|property)\s+name=", re.DOTALL)
"""What xacro read before 2020 without its prefix, outside comments."""


class Arguments(dict[str, str]):
    """Values of `$(arg NAME)`: one that has none is empty, and noted.

    Attributes:
        used: The names that were asked for.
        missing: Those of them that had no value.
    """

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.used: set[str] = set()
        self.missing: list[str] = []

    def __getitem__(self, name: str) -> str:
        self.used.add(name)
        return super().__getitem__(name)

    def __missing__(self, name: str) -> str:
        if hasattr(builtins, name):  # a function in $(eval ...)
            raise KeyError(name)
        self.missing.append(name)
        self[name] = ""
        return ""


class Expansion:
    """One file's expansion; what is missing is left out and noted.

    Attributes:
        off: The arguments that are false by default, but for those that are some tag's text alone.
    """

    def __init__(self, path: Path, search: SearchPath) -> None:
        self._path = path
        self._search = search
        self._is_incomplete = False
        self._unknown: set[str] = set()
        self._choosing: set[str] = set()  # the arguments in attributes, as a condition's value
        self.notes: dict[tuple[str, str], None] = {}
        self.off: list[str] = []
        index = ModuleType("ament_index_python.packages")
        index.get_package_share_directory = self._package  # type: ignore[attr-defined]
        sys.modules[index.__name__] = index
        xacro.open = self._open

    def expand(self, given: dict[str, str]) -> str:
        """Return the URDF for the values of xacro arguments.

        Raises:
            XacroException: It cannot be expanded.
        """
        arguments = Arguments(given)
        try:
            document: Any = xacro.process_file(str(self._path), mappings=arguments)
        except XacroException as error:
            unknown = _UNKNOWN.search(str(error))
            if unknown is None or not self._is_incomplete or unknown[1] in self._unknown:
                raise
            self._unknown.add(unknown[1])  # an include that is missing would have it
            self._note(f"macro <{unknown[1]}> does not exist, so it is left out")
            return self.expand(given)
        for name in arguments.missing:
            text = f"argument '{name}' has no value, so it is empty; {name}:=VALUE gives one"
            self._note(text, NoteKind.CHANGED)
        self.off = [
            name
            for name in sorted(self._choosing & arguments.used - set(given))
            if arguments.get(name, "").lower() in ("false", "0")
        ]
        for name in sorted(set(given) - arguments.used):
            self._note(f"argument '{name}' is used nowhere", NoteKind.IGNORED)
        text = str(document.toprettyxml(indent="  "))
        if len(text) > _OUTPUT_BYTES:
            raise XacroException(f"it grows beyond {_OUTPUT_BYTES} characters")
        return text

    def _note(self, text: str, kind: NoteKind = NoteKind.MISSING) -> None:
        self.notes[(kind.value, text)] = None

    def _package(self, name: str) -> str:
        files = [Path(file) for file in reversed(xacro.filestack)]
        found = (self._search.package(file, name) for file in files)
        folder = next((folder for folder in found if folder is not None), None)
        if folder is None:
            folder = self._path.resolve().parent.parent
            self._note(f"package '{name}' does not exist; --package-path DIR finds it in DIR")
        return str(folder)

    def _open(self, name: str) -> io.StringIO:
        """Open a file that xacro parses, which it puts on its stack before, or a file of values."""
        path, *above = (Path(file).resolve() for file in (name, *reversed(xacro.filestack)))
        if path != above[0]:
            self._confine(name)
            return io.StringIO(read_text(path, _FILE_BYTES))
        if path in above[1:]:
            raise XacroException(f"'{name}' includes itself")
        if len(above) > 1 and not path.exists():
            self._is_incomplete = True
            self._note(f"include: '{name}' does not exist, so it is left out")
            return io.StringIO("<robot/>")
        return io.StringIO(self._bridged(read_text(path, _FILE_BYTES)))

    def _confine(self, name: str) -> None:
        """Refuse a file of values that lies neither around the robot nor in a package."""
        folders = [*map(home_folder, map(Path, xacro.filestack))]
        allowed = [*folders, *self._search.packages, *self._search.models]
        if not any(Path(name).resolve().is_relative_to(folder.resolve()) for folder in allowed):
            raise XacroException(f"'{name}' leads out of {allowed[0]}")

    def _bridged(self, text: str) -> str:
        """Leave out calls of unknown macros, and let conditions that are empty be false."""
        for value in _VALUE.findall(text):
            self._choosing.update(re.findall(r"\w+", value))
        for tag in filter(None, _BARE.findall(text)):
            said = f"<{tag}> without its prefix is nothing to xacro; <xacro:{tag}> is what it reads"
            self._note(said, NoteKind.BROKEN)
        if not any(tag in text for tag in (*_CONDITIONS, *self._unknown)):
            ElementTree.fromstring(text, forbid_dtd=True)
            return text
        document = minidom.parseString(text, forbid_dtd=True)
        for tag in self._unknown:
            for element in document.getElementsByTagName(tag):
                xacro.replace_node(element, by=None)
        for element in (e for tag in _CONDITIONS for e in document.getElementsByTagName(tag)):
            value = element.getAttribute("value").strip()
            if re.fullmatch(r"\$\([^(){}']*\)", value):
                element.setAttribute("value", f"${{'{value}' or False}}")
            elif re.fullmatch(r"\$\{[^{}]*\}", value):
                element.setAttribute("value", f"${{({value[2:-1]}) or False}}")
        bridged = str(document.toxml())
        document.unlink()  # else its cycles hold the memory while xacro parses again
        return bridged


def _limit(kind: int, value: int) -> None:
    with contextlib.suppress(ValueError, OSError):  # some systems have no such limit
        resource.setrlimit(kind, (value, value))


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    search = SearchPath(*(tuple(map(Path, request[key])) for key in ("packages", "models")))
    expansion = Expansion(Path(request["path"]), search)
    try:
        text = expansion.expand(request["arguments"])
    except DefusedXmlException as error:
        kind = type(error).__name__
        return {"error": f"a file declares a DTD or entities ({kind}); plain XML is valid"}
    except RecursionError:
        return {"error": "macros or includes call themselves without end"}
    except Exception as error:  # noqa: BLE001 - macros are code: they can raise anything
        if MemoryError in (type(error), type(error.__context__)):
            return {"error": f"it takes more than {_MEMORY_BYTES // 1_000_000} MB"}
        reason = " ".join(str(error).split()) or type(error).__name__
        remedies = [remedy for text, remedy in _REMEDIES if text in reason][:1]
        notes = (text for _, text in expansion.notes)
        return {"error": "; ".join([reason, *remedies, *notes])}
    files = list(xacro.all_includes)
    return {"text": text, "notes": list(expansion.notes), "files": files, "off": expansion.off}


def main() -> None:
    """Answer a request, within the limits."""
    request, out = json.load(sys.stdin), sys.stdout
    signal.setitimer(signal.ITIMER_PROF, 1.0)  # [s] of computing, after which it is killed
    _limit(resource.RLIMIT_AS, _MEMORY_BYTES)
    _limit(resource.RLIMIT_FSIZE, 0)
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        answer = _answer(request)
    json.dump(answer, out)


if __name__ == "__main__":
    main()
