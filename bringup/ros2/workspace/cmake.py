"""A CMakeLists.txt: its calls with the values of their variables, and what they install.

What ament_cmake lays down, as far as nothing has to be compiled for it.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text

_CALL = re.compile(r'^[ \t]*(\w+)\s*\(((?:"(?:[^"\\]|\\.)*"|[^()"]|\([^()]*\))*)\)', re.MULTILINE)
_VARIABLE = re.compile(r"\$\{(\w+)\}")
_HOOK = re.compile(
    r'^(?:prepend[\w-]*;|ament_prepend_unique_value )(\w+)[; ]"?'
    r'(?:(?:\$\{?AMENT_CURRENT_PREFIX\}?|@CMAKE_INSTALL_PREFIX@)/)?([^"\n]*)',
    re.MULTILINE,
)
_COMPILED = ("add_executable", "add_library", "pybind11_add_module")
_HERE = (
    *("CMAKE_CURRENT_SOURCE_DIR", "CMAKE_SOURCE_DIR", "CMAKE_CURRENT_LIST_DIR"),
    "PROJECT_SOURCE_DIR",
)
_LAUNCH_TESTS = ("add_launch_test", "add_ros_test", "add_ros_isolated_launch_test")
_COMPILED_TESTS = ("ament_add_gtest", "ament_add_gmock", "ament_add_google_benchmark")
_OF_TESTS = {
    *("TARGET", "TIMEOUT", "ARGS", "ENV", "APPEND_ENV", "WORKING_DIRECTORY", "COMMAND", "RUNNER"),
    *("PYTHON_EXECUTABLE", "LABELS", "RESULT_FILE", "OUTPUT_FILE", "SKIP_TEST"),
    *("GENERATE_RESULT_FOR_RETURN_CODE_ZERO", "SKIP_RETURN_CODE"),
}
_NO_CODE = {"INTERFACE", "ALIAS", "IMPORTED"}
_KEYWORDS = {"DESTINATION", "RENAME", "PATTERN", "REGEX", "PERMISSIONS", "FILES_MATCHING"}
_GLOB_OPTIONS = {"CONFIGURE_DEPENDS", "FOLLOW_SYMLINKS"}


class Item(NamedTuple):
    """A file or a folder of a package, and where it goes below the prefix."""

    source: Path
    target: Path
    is_program: bool = False


class Test(NamedTuple):
    """A test of a package.

    Attributes:
        kind: `pytest`, `launch` or `program`.
        words: The file, or the program, and its arguments.
        timeout: [s], None for no limit.
    """

    kind: str
    name: str
    words: list[str]
    timeout: float | None
    environment: dict[str, str]


@dataclass
class CMakeLists:
    """The result of the calls of a CMakeLists.txt.

    Attributes:
        modules: Packages of Python by name, and their folders.
        compiled: Names of what would have to be compiled.
        missing: Files and folders that are to be installed and are not there.
        hooks: Variables of the environment, and the folders below the prefix that come before.
        is_interfaces: Whether messages, services or actions are generated.
    """

    folder: Path
    values: dict[str, list[str]]
    items: list[Item] = field(default_factory=list)
    modules: dict[str, Path] = field(default_factory=dict)
    compiled: list[str] = field(default_factory=list)
    missing: list[Path] = field(default_factory=list)
    is_interfaces: bool = False
    tests: list[Test] = field(default_factory=list)
    compiled_tests: list[str] = field(default_factory=list)
    hooks: list[tuple[str, str]] = field(default_factory=list)
    _conditions: int = 0  # that the call stands in

    def follow(self, calls: Sequence[tuple[str, str]]) -> None:
        """Take calls, with their arguments as texts, one after the other."""
        at = 0
        while at < len(calls):
            name, text = calls[at]
            words = expanded(text, self.values)
            at += 1
            self._conditions += (name == "if") - (name == "endif")
            if name == "foreach":
                end, depth = at, 1
                while depth and end < len(calls):
                    depth += (calls[end][0] == "foreach") - (calls[end][0] == "endforeach")
                    end += 1
                for value in self._items_of(words[1:]):
                    self.values[words[0]] = [value]
                    self.follow(calls[at:end])
                at = end
            elif words:
                self._take(name, words)

    def _items_of(self, words: list[str]) -> list[str]:
        """Return the values of a loop."""
        if words[:2] == ["IN", "LISTS"]:
            return [value for name in words[2:] for value in self.values.get(name, ())]
        return words[2:] if words[:2] == ["IN", "ITEMS"] else words

    def _take(self, name: str, words: list[str]) -> None:
        if name == "set":
            self.values[words[0]] = words[1:]
        elif name == "list" and words[0] == "APPEND":
            self.values.setdefault(words[1], []).extend(words[2:])
        elif name == "file" and words[0].startswith("GLOB"):
            self.values[words[1]] = self._matches(words[0] == "GLOB_RECURSE", words[2:])
        elif name == "install":
            self._install(words)
        elif name == "ament_auto_package" and "INSTALL_TO_SHARE" in words:
            share = Path("share", *self.values["PROJECT_NAME"])
            for one in words[words.index("INSTALL_TO_SHARE") + 1 :]:
                self._add(one, share / Path(one).name)
        elif name == "ament_python_install_package":
            at = words.index("PACKAGE_DIR") + 1 if "PACKAGE_DIR" in words else 0
            self.modules[words[0]] = self.folder / words[at]
        elif name == "ament_environment_hooks":
            for path in filter(Path.is_file, (self.folder / word for word in words)):
                text = read_text(path).replace(
                    "@PROJECT_NAME@", "".join(self.values["PROJECT_NAME"])
                )
                self.hooks += _HOOK.findall(text)
        elif name == "rosidl_generate_interfaces":
            self.is_interfaces = True
        elif name in _LAUNCH_TESTS:
            self._test("launch", words, "")
        elif name == "ament_add_pytest_test":
            self._test("pytest", words[1:], words[0])
        elif name == "ament_add_test":
            self._test("program", words[1:], words[0])
        elif name in _COMPILED_TESTS:
            self.compiled_tests.append(words[0])
        elif name.replace("ament_auto_", "") in _COMPILED and not _NO_CODE & set(words):
            self.compiled.append(words[0])

    def _test(self, kind: str, words: list[str], name: str) -> None:
        """Take a test, whose words follow keywords."""
        parts: dict[str, list[str]] = {"": []}
        key = ""
        for word in words:
            key = word if word in _OF_TESTS else key
            parts.setdefault(key, []).extend([] if word == key else [word])
        main = parts.get("COMMAND", []) if kind == "program" else parts[""]
        if not main:
            return
        path = self.folder / main[0]
        first = str(path) if path.exists() else main[0]
        pairs = (word.partition("=") for word in parts.get("ENV", ()))
        limit = parts.get("TIMEOUT", [""])[0]
        self.tests.append(
            Test(
                kind,
                name or "".join(parts.get("TARGET", ())) or Path(first).stem,
                [first, *main[1:], *parts.get("ARGS", ())],
                float(limit) if limit.replace(".", "", 1).isdigit() else None,
                {key: value for key, _, value in pairs},
            )
        )

    def _matches(self, deep: bool, words: list[str]) -> list[str]:
        """Return the files of patterns."""
        base = self.folder / words.pop(words.index("RELATIVE") + 1) if "RELATIVE" in words else None
        found: list[str] = []
        for word in (one for one in words if one not in {*_GLOB_OPTIONS, "RELATIVE"}):
            path = self.folder / word
            pairs = path.parent.rglob(path.name) if deep else path.parent.glob(path.name)
            found += [str(one.relative_to(base) if base else one) for one in sorted(pairs)]
        return found

    def _install(self, words: list[str]) -> None:
        kind, rest = words[0], words[1:]
        if kind not in ("DIRECTORY", "FILES", "PROGRAMS") or "DESTINATION" not in rest:
            return
        end = next(at for at, word in enumerate(rest) if word in _KEYWORDS)
        sources = [one for one in rest[:end] if one != "OPTIONAL"]
        into = Path(rest[rest.index("DESTINATION") + 1].lstrip("/"))
        for one in sources:
            name = rest[rest.index("RENAME") + 1] if "RENAME" in rest else Path(one).name
            is_content = kind == "DIRECTORY" and one.endswith("/")
            target = into if is_content else into / name
            self._add(one, target, kind == "PROGRAMS", _excluded(rest), "OPTIONAL" in rest)

    def _add(
        self,
        name: str,
        target: Path,
        is_program: bool = False,
        excluded: Sequence[str] = (),
        is_optional: bool = False,
    ) -> None:
        """Take a file, or the files of a folder one by one: who looks through it follows links."""
        source = self.folder / name
        if not source.exists() and not is_optional and not self._conditions:
            self.missing.append(source)
        if source.is_file():
            self.items.append(Item(source, target, is_program))
        for each in sorted(source.rglob("*")):
            path = each.relative_to(source)
            left_out = any(fnmatch(part, one) for part in path.parts for one in excluded)
            if each.is_file() and not left_out:
                self.items.append(Item(each, target / path))


def _excluded(words: Sequence[str]) -> list[str]:
    """Return the patterns of what is left out of a folder."""
    return [
        words[at + 1]
        for at, word in enumerate(words)
        if word == "PATTERN" and words[at + 2 : at + 3] == ["EXCLUDE"]
    ]


def expanded(text: str, values: Mapping[str, list[str]]) -> list[str]:
    """Return a call's arguments, with variables replaced by their values."""

    def words() -> Iterator[str]:
        lexer = shlex.shlex(text, posix=True)
        lexer.whitespace_split, lexer.commenters, lexer.quotes = True, "", '"'
        for word in lexer:
            if (whole := _VARIABLE.fullmatch(word)) is not None:
                yield from values.get(whole[1], ())
            else:
                yield _VARIABLE.sub(lambda m: ";".join(values.get(m[1], ())), word)

    return list(words())


def read_cmake(folder: Path, name: str, site: str) -> CMakeLists:
    """Read a package's CMakeLists.txt; `site` is the folder of Python packages below the prefix.

    Raises:
        InputFileError: It cannot be read or followed.
    """
    folder = folder.resolve()
    path = folder / "CMakeLists.txt"
    text = re.sub(r"#.*", "", read_text(path))
    values = {
        **dict.fromkeys(_HERE, str(folder)),
        **dict.fromkeys(("CMAKE_PROJECT_NAME", "PROJECT_NAME"), name),
        "CMAKE_INSTALL_PREFIX": "",
        "CMAKE_INSTALL_DATADIR": "share",
        "CMAKE_INSTALL_LIBDIR": "lib",
        "PYTHON_INSTALL_DIR": site,
    }
    found = CMakeLists(folder, {key: [value] for key, value in values.items()})
    try:
        found.follow([(one.lower(), inside) for one, inside in _CALL.findall(text)])
    except (ValueError, LookupError, OSError, RuntimeError) as error:  # as of a pattern, too deep
        raise InputFileError(path, f"cannot be followed: {error}") from error
    return found
