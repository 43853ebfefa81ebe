"""Runs the rosidl generators as Python libraries, on all cores.

The steps are those of CMake's `rosidl_generate_interfaces`: definition -> .idl -> type description
with RIHS01 hash -> C structs, three type supports and Python classes.
"""

from __future__ import annotations

import contextlib
import copy
import io
import json
import multiprocessing
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rosidl_generator_py
import rosidl_generator_py.generate_py_impl
import rosidl_generator_type_description
import rosidl_parser.parser
import rosidl_pycommon
from lark.exceptions import LarkError
from rosidl_adapter import convert_to_idl
from rosidl_adapter.parser import InvalidSpecification, InvalidValue
from rosidl_generator_c import generate_c
from rosidl_parser.definition import IdlFile, IdlLocator
from rosidl_typesupport_c import generate_c as generate_typesupport_c
from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c
from rosidl_typesupport_introspection_c import generate_c as generate_introspection_c

from rosidl_build.definitions import InterfacePackage
from rosidl_build.progress import say, step
from rosidl_build.templates import remember_scans

TYPE_SUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")

_GENERATORS: dict[str, Callable[[str], Any]] = {
    "rosidl_generator_py": lambda path: rosidl_generator_py.generate_py(
        path, ["rosidl_typesupport_c"]
    ),
    "rosidl_generator_c": generate_c,
    "rosidl_typesupport_fastrtps_c": generate_typesupport_fastrtps_c,
    "rosidl_typesupport_introspection_c": generate_introspection_c,
    "rosidl_typesupport_c": lambda path: generate_typesupport_c(path, list(TYPE_SUPPORTS)),
}

# What the libraries raise, or exit by, for a definition that is wrong.
_WRONG = (
    *(InvalidSpecification, InvalidValue, LarkError, AssertionError, AttributeError, LookupError),
    *(NameError, NotImplementedError, OSError, SystemExit, TypeError, ValueError),
)

_parsed: dict[str, IdlFile] = {}
_parse_idl_file = rosidl_parser.parser.parse_idl_file


def find_prefix() -> Path:
    """Return the prefix whose `share/`, `include/` and `lib/` the ROS wheels filled.

    In pip's isolated build it is the build overlay, not `sys.prefix`.

    Raises:
        FileNotFoundError: no folder above the generators holds their templates.
    """
    for parent in Path(rosidl_pycommon.__file__).resolve().parents:
        if (parent / "share" / "rosidl_generator_c" / "resource").is_dir():
            return parent
    raise FileNotFoundError(f"no share/rosidl_generator_c above {rosidl_pycommon.__file__}")


def generate(packages: list[InterfacePackage], prefix: Path, out: Path) -> None:
    """Generate everything for `packages` (in dependency order) below `out`.

    Definitions, .idl and .json go to `out/share/PACKAGE/`, generated code to
    `out/GENERATOR/PACKAGE/`: one folder a generator, because two of them write files of one name.

    Raises:
        ValueError: A definition is wrong, or uses a type that is not there.
    """
    context = multiprocessing.get_context("fork")  # workers inherit what the parent parsed
    remember_scans()
    with step(f"parse {sum(len(p.files) for p in packages)} definitions"):
        _use_memo()
        with context.Pool(os.cpu_count(), _end_by_signal) as pool:
            tasks = [(p, file, out) for p in packages for file in p.files]
            for path, idl in pool.imap_unordered(_translate, tasks):
                _parsed[path] = idl
    with step("type hashes"):
        for package in packages:
            _arguments(package, "rosidl_generator_type_description", prefix, out)
            path = _arguments_path(package, "rosidl_generator_type_description", out)
            try:
                rosidl_generator_type_description.generate_type_hash(str(path))
            except (OSError, LookupError) as error:
                lacking = Path(getattr(error, "filename", None) or "").stem
                problem = f"there is no type '{lacking}'" if lacking else "a type holds itself"
                raise ValueError(f"{package.folder}: {problem}") from error
    _generate_code(context, packages, prefix, out)


def _generate_code(
    context: multiprocessing.context.ForkContext,
    packages: list[InterfacePackage],
    prefix: Path,
    out: Path,
) -> None:
    # Largest first keeps all cores busy to the end.
    by_size = sorted(packages, key=lambda package: -len(package.files))
    tasks = [(package, name, prefix, out) for package in by_size for name in _GENERATORS]
    pending = {package.name: len(_GENERATORS) for package in packages}
    with step("generate code"), context.Pool(os.cpu_count(), _end_by_signal) as pool:
        for name in pool.imap_unordered(_run_generator, tasks):
            pending[name] -= 1
            if not pending[name]:
                say(f"generated {name}")


def _end_by_signal() -> None:
    """Let a worker end by a signal alone, whatever handler the parent has."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _use_memo() -> None:
    """Parse each .idl once: every generator parses all of them, and parsing is most of its time."""
    rosidl_pycommon.parse_idl_file = _memoised_parse
    rosidl_generator_type_description.parse_idl_file = _memoised_parse
    rosidl_generator_py.generate_py_impl.parse_idl_file = _memoised_parse


def _memoised_parse(locator: IdlLocator) -> IdlFile:
    # A copy, since templates are free to change what they are given.
    return copy.deepcopy(_parsed[str(locator.get_absolute_path())])


def _translate(task: tuple[InterfacePackage, Path, Path]) -> tuple[str, IdlFile]:
    package, file, out = task
    with _one_error(package.folder / file):
        return _translated(package, file, out / "share" / package.name)


@contextlib.contextmanager
def _one_error(path: Path) -> Iterator[None]:
    """Raise ValueError for all that is wrong: a pool hangs by an exit, and by most other errors."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            yield
    except _WRONG as error:
        last = said.getvalue().strip().rpartition("\n")[2]
        reason = last if isinstance(error, SystemExit) else " ".join(str(error).split())
        raise ValueError(f"{path}: {reason}") from error


def _translated(package: InterfacePackage, file: Path, share: Path) -> tuple[str, IdlFile]:
    (share / file.parent).mkdir(parents=True, exist_ok=True)
    shutil.copyfile(package.folder / file, share / file)
    convert_to_idl(package.folder, package.name, file, share)
    locator = IdlLocator(str(share), str(file.with_suffix(".idl")))
    return str(locator.get_absolute_path()), _parse_idl_file(locator)


def _run_generator(task: tuple[InterfacePackage, str, Path, Path]) -> str:
    package, generator, prefix, out = task
    arguments = _arguments(package, generator, prefix, out)
    _write_visibility_header(package.name, generator, prefix, out)
    with _one_error(package.folder):
        _GENERATORS[generator](str(arguments))
    return package.name


def _arguments_path(package: InterfacePackage, generator: str, out: Path) -> Path:
    return out / "arguments" / f"{generator}__{package.name}.json"


def _arguments(package: InterfacePackage, generator: str, prefix: Path, out: Path) -> Path:
    """Write the arguments file of one generator for one package."""
    share = out / "share" / package.name
    hashing = generator == "rosidl_generator_type_description"
    target = share if hashing else out / generator / package.name
    idl = [file.with_suffix(".idl") for file in package.files]
    content = {
        "package_name": package.name,
        "output_dir": str(target),
        "template_dir": str(prefix / "share" / generator / "resource"),
        "idl_tuples": [f"{share}:{file}" for file in idl],
        "target_dependencies": [],
    }
    if hashing:
        content["include_paths"] = [
            f"{path.name}:{path}" for root in (prefix, out) for path in (root / "share").iterdir()
        ]
    else:
        content["type_description_tuples"] = [
            f"{file}:{share / file.with_suffix('.json')}" for file in idl
        ]
        content["ros_interface_files"] = [str(share / file) for file in package.files]
    path = _arguments_path(package, generator, out)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def _write_visibility_header(package: str, generator: str, prefix: Path, out: Path) -> None:
    """Fill in what CMake's `configure_file` would."""
    name = f"{generator}__visibility_control.h"
    template = prefix / "share" / generator / "resource" / f"{name}.in"
    if template.is_file():
        text = template.read_text(encoding="utf-8")
        text = text.replace("@PROJECT_NAME_UPPER@", package.upper())
        header = out / generator / package / "msg" / name
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(text.replace("@PROJECT_NAME@", package), encoding="utf-8")
