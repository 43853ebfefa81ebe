"""Expanding xacro macros in a process of its own, whose time and memory are limited.

It reads a request (JSON) on its standard input and writes an answer on its standard output; nothing
of arjuna_sim is imported but the search for packages, so that it starts at once.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xacro
from defusedxml import DefusedXmlException, minidom
from xacro import substitution_args

from arjuna_sim.files.search_path import SearchPath, home

CPU_SECONDS = 1
_MEMORY_BYTES = 400_000_000
_FILE_BYTES = 5_000_000
_OUTPUT_BYTES = 5_000_000
_TRUTH = xacro.get_boolean_value
_INCLUDE = xacro.process_include
_CALL = xacro.handle_macro_call
_FILES = xacro.get_include_files


class Expansion:
    """One file's expansion: xacro with its gaps bridged and every bridge noted.

    Args:
        path: The file.
        arguments: Values of xacro arguments.
        search: Where packages are looked for.
    """

    def __init__(self, path: Path, arguments: dict[str, str], search: SearchPath) -> None:
        self._path = path
        self._arguments = arguments
        self._search = search
        self._missing = False
        self._used: set[str] = set()
        self.notes: list[str] = []

    def run(self) -> str:
        """Return the URDF."""
        xacro.open = self._open_data
        xacro.parse = _parse
        xacro.get_include_files = self._files
        xacro.process_include = self._include
        xacro.handle_macro_call = self._call
        xacro.get_boolean_value = self._truth
        substitution_args._eval_arg = self._argument
        substitution_args._eval_find = self._package
        substitution_args._eval_dict["find"] = self._package
        document: Any = xacro.process_file(str(self._path), mappings=dict(self._arguments))
        for name in sorted(set(self._arguments) - self._used):
            self._note(f"argument '{name}' is used nowhere")
        text: str = document.toprettyxml(indent="  ")
        if len(text) > _OUTPUT_BYTES:
            raise xacro.XacroException(f"it grows beyond {_OUTPUT_BYTES} characters")
        return text

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def _open_data(self, name: str) -> Any:
        """Open a file of values, which may lie around the robot or in a package only."""
        files = [self._path, *(Path(file) for file in xacro.filestack)]
        allowed = [*map(home, files), *self._search.packages, *self._search.models]
        if not any(Path(name).resolve().is_relative_to(folder.resolve()) for folder in allowed):
            raise xacro.XacroException(f"'{name}' leads out of {allowed[0]}")
        return _open(name)

    def _package(self, name: str) -> str:
        files = [Path(file) for file in reversed(xacro.filestack)]
        found = (self._search.package(file, name) for file in files or [self._path])
        folder = next((folder for folder in found if folder is not None), None)
        if folder is None:
            folder = self._path.resolve().parent.parent
            self._note(f"package '{name}' does not exist; --package-path DIR finds it in DIR")
        return str(folder)

    def _argument(self, name: str, args: dict[str, str]) -> str:
        self._used.add(name)
        if name not in args:
            self._note(f"argument '{name}' has no value, so it is empty; {name}:=VALUE gives one")
            args[name] = ""
        return args[name]

    def _truth(self, value: Any, condition: Any) -> bool:
        is_missing = value == "" and condition is not None  # of an `if`, not of a property
        return False if is_missing else bool(_TRUTH(value, condition))

    def _files(self, spec: str, symbols: Any) -> Iterator[str]:
        for name in _FILES(spec, symbols):
            if os.path.realpath(name) in map(os.path.realpath, xacro.filestack):
                raise xacro.XacroException(f"'{name}' includes itself")
            yield name

    def _include(self, element: Any, macros: Any, symbols: Any, evaluate: Any) -> None:
        depth = len(xacro.filestack)
        try:
            _INCLUDE(element, macros, symbols, evaluate)
        except xacro.XacroException as error:
            if not isinstance(error.exc, FileNotFoundError) or len(xacro.filestack) != depth:
                raise
            self._missing = True
            self._note(f"include: '{error.exc.filename}' does not exist, so it is left out")
            xacro.replace_node(element, by=None)

    def _call(self, node: Any, macros: Any, symbols: Any) -> bool:
        name = node.tagName
        try:
            return bool(_CALL(node, macros, symbols))
        except xacro.XacroException as error:
            if not self._missing or f"unknown macro name: {name}" not in str(error):
                raise
            self._note(f"macro <{name}> does not exist, so it is left out")
            xacro.replace_node(node, by=None)
            return True


def _open(name: str) -> Any:
    """Open a file for xacro: only a plain one of a sane size, never a device or a pipe."""
    status = Path(name).stat()
    if not stat.S_ISREG(status.st_mode) or status.st_size > _FILE_BYTES:
        raise OSError(0, f"is no file of at most {_FILE_BYTES} bytes", name)
    return Path(name).open(encoding="utf-8")


def _parse(text: Any, name: str | None = None) -> Any:
    """Stand in for xacro's parser, which would expand entities."""
    if text is None:
        assert name is not None
        try:
            with _open(name) as file:
                text = file.read()
        except OSError as error:
            xacro.filestack.pop()
            raise xacro.XacroException(f"{error.strerror}: {name}", exc=error) from error
    return minidom.parseString(text, forbid_dtd=True) if isinstance(text, str) else text


def _limit(kind: int, value: int) -> None:
    with contextlib.suppress(ValueError, OSError):  # some systems have no such limit
        resource.setrlimit(kind, (value, value))


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    search = SearchPath(*(tuple(map(Path, request[key])) for key in ("packages", "models")))
    expansion = Expansion(Path(request["path"]), request["arguments"], search)
    try:
        text = expansion.run()
    except DefusedXmlException as error:
        kind = type(error).__name__
        return {"error": f"a file declares a DTD or entities ({kind}); plain XML is valid"}
    except RecursionError:
        return {"error": "macros or includes call themselves without end"}
    except MemoryError:
        return {"error": f"it takes more than {_MEMORY_BYTES // 1_000_000} MB"}
    except Exception as error:  # noqa: BLE001 - macros are code: they can raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        return {"error": "; ".join([reason, *expansion.notes])}
    return {"text": text, "notes": expansion.notes, "files": list(xacro.all_includes)}


def main() -> None:
    """Answer one request."""
    request = json.load(sys.stdin)
    _limit(resource.RLIMIT_AS, _MEMORY_BYTES)
    _limit(resource.RLIMIT_CPU, CPU_SECONDS)
    _limit(resource.RLIMIT_FSIZE, 0)
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        answer = json.dumps(_answer(request))
    sys.stdout.write(answer)


if __name__ == "__main__":
    main()
