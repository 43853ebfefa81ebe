"""Compiles and links the generated C and C++ of each package, on all cores.

Five libraries and one Python extension a package, all beside the package's Python files:
`librosidl_typesupport_c` opens the other two type supports by name when a publisher is made, so the
extension links them without `--as-needed`, and their sonames make them found. Each library is one
compilation unit: reading the headers takes longer than what is in one file.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sysconfig
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from setuptools.errors import CompileError, PlatformError

from rosidl_build.definitions import InterfacePackage
from rosidl_build.progress import step

_RUNTIME = ("rosidl_runtime_c", "rcutils")
_FLAGS = ("-fPIC", "-O0")
"""-O1 takes twice as long to compile and gains nothing: a transform takes 53 us to serialize either
way, a costmap of 40 kB 29 us instead of 22."""
_FILE_LOCAL = re.compile(r"^static .*?(\w+)(?:\[\])? =", re.MULTILINE)


@dataclass(frozen=True)
class _Library:
    """One library a package: its generator, where its sources lie and what it links.

    `own` are libraries of the same package, `shared` are libraries of the ROS wheels; the library
    of the same generator of every dependency comes on top.
    """

    generator: str
    sources: tuple[str, ...]
    own: tuple[str, ...]
    shared: tuple[str, ...]


_LIBRARIES = (
    _Library(
        "rosidl_generator_c",
        ("*/detail/*__functions.c", "*/detail/*__type_support.c", "*/detail/*__description.c"),
        (),
        (),
    ),
    _Library(
        "rosidl_typesupport_fastrtps_c",
        ("*/detail/*.cpp",),
        ("rosidl_generator_c",),
        ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_fastrtps_cpp", "fastcdr", "rmw"),
    ),
    _Library(
        "rosidl_typesupport_introspection_c",
        ("*/detail/*.c",),
        ("rosidl_generator_c",),
        ("rosidl_typesupport_introspection_c",),
    ),
    _Library(
        "rosidl_typesupport_c",
        ("*/*.cpp",),
        ("rosidl_generator_c",),
        ("rosidl_typesupport_c",),
    ),
    _Library(
        "rosidl_generator_py",
        ("*/_*_s.c",),
        ("rosidl_generator_c", "rosidl_typesupport_c"),
        (),
    ),
)


@dataclass(frozen=True)
class _Object:
    """One call of the compiler."""

    source: Path
    target: Path


class Toolchain:
    """The C and C++ compilers (from CC and CXX, else gcc and g++) with the include folders."""

    def __init__(self, prefix: Path, out: Path) -> None:
        self._cc = _compiler("CC", "gcc")
        self._cxx = _compiler("CXX", "g++")
        self._prefix = prefix
        self._out = out
        python = Path(sysconfig.get_paths()["include"])
        if not (python / "Python.h").is_file():
            raise PlatformError(f"no Python.h in {python}: install your Python's development files")
        generated = [out / library.generator for library in _LIBRARIES]
        wheels = [prefix / "include", *sorted((prefix / "include").iterdir())]
        folders = [*generated, *wheels, python, Path(np.get_include())]
        self._includes = [f"-I{folder}" for folder in folders]

    def compile_object(self, item: _Object) -> None:
        """Compile one file."""
        is_cxx = item.source.suffix == ".cpp"
        compiler = [*self._cxx, "-std=c++17"] if is_cxx else self._cc
        _run([*compiler, *_FLAGS, *self._includes,
              "-c", str(item.source), "-o", str(item.target)])  # fmt: skip

    def link(
        self, target: Path, objects: Iterable[Path], libraries: Iterable[str], siblings: list[str]
    ) -> None:
        """Link a shared object with a soname, and run paths to where its libraries will lie.

        `siblings` are the packages of this build whose libraries it needs.
        """
        run_path = ["$ORIGIN", *(f"$ORIGIN/../{name}" for name in siblings)]
        run_path.append("$ORIGIN/../../..")  # site-packages/PACKAGE -> the environment's lib/
        root = target.parent.parent
        _run([
            *self._cxx, "-shared", "-s", "-o", str(target), *map(str, objects),
            # RPATH instead of RUNPATH: it also serves what our libraries load in turn.
            "-Wl,--disable-new-dtags", f"-Wl,-rpath,{':'.join(run_path)}",
            f"-Wl,-soname,{target.name}", "-Wl,--no-as-needed",
            f"-L{target.parent}", *(f"-L{root / name}" for name in siblings),
            f"-L{self._prefix / 'lib'}", *(f"-l{name}" for name in libraries),
        ])  # fmt: skip


def compile_packages(
    packages: list[InterfacePackage],
    toolchain: Toolchain,
    out: Path,
    target: Path,
    beside: Iterable[str] = (),
) -> None:
    """Compile what `generate` left in `out`; libraries go to `target/PACKAGE/`.

    Args:
        beside: Other packages whose libraries are in `target`.

    Raises:
        CompileError: the compiler or the linker failed; its output is in the message.
    """
    objects = [item for package in packages for item in _objects(package, out)]
    for package in packages:
        (target / package.name).mkdir(parents=True, exist_ok=True)
    objects.sort(key=lambda item: -item.source.stat().st_size)  # no core waits for the longest
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        with step(f"compile {len(objects)} units"):
            _run_all(pool, toolchain.compile_object, objects)
        with step("link"):
            for package in packages:
                names = [*beside, *(other.name for other in packages)]
                siblings = [name for name in names if name in package.dependencies]
                for library in _LIBRARIES:  # each links only to libraries before it
                    _link_library(package, library, toolchain, out, target, siblings)
                _link_extension(package, toolchain, out, target)


def _objects(package: InterfacePackage, out: Path) -> list[_Object]:
    """Write the compilation units of one package."""
    items = []
    for library in _LIBRARIES:
        root = out / library.generator / package.name
        sources = sorted({path for pattern in library.sources for path in root.glob(pattern)})
        unit = _object_folder(package, library.generator, out) / f"unit{sources[0].suffix}"
        unit.write_text("".join(map(_included, sources)), encoding="utf-8")
        items.append(_Object(unit, unit.with_suffix(".o")))
    folder = _object_folder(package, "extension", out)
    entry = out / "rosidl_generator_py" / package.name
    source = entry / f"_{package.name}_s.ep.rosidl_typesupport_c.c"
    items.append(_Object(source, folder / "entry.o"))
    return items


def _included(source: Path) -> str:
    """Return the lines that include a source; what is local to a description stays its own."""
    include = f'#include "{source}"\n'
    if not source.name.endswith("__description.c"):
        return include
    names = sorted(set(_FILE_LOCAL.findall(source.read_text(encoding="utf-8"))))
    own = f"{source.parent.parent.name}__{source.name.partition('__')[0]}"
    defined = "".join(f"#define {name} {name}__of__{own}\n" for name in names)
    return defined + include + "".join(f"#undef {name}\n" for name in names)


def _object_folder(package: InterfacePackage, part: str, out: Path) -> Path:
    folder = out / "objects" / package.name / part
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _link_library(
    package: InterfacePackage,
    library: _Library,
    toolchain: Toolchain,
    out: Path,
    target: Path,
    siblings: list[str],
) -> None:
    own = [f"{package.name}__{name}" for name in library.own]
    needed = [f"{name}__{library.generator}" for name in package.dependencies]
    toolchain.link(
        target / package.name / f"lib{package.name}__{library.generator}.so",
        sorted(_object_folder(package, library.generator, out).glob("*.o")),
        [*own, *needed, *library.shared, *_RUNTIME],
        siblings,
    )


def _link_extension(
    package: InterfacePackage, toolchain: Toolchain, out: Path, target: Path
) -> None:
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    toolchain.link(
        target / package.name / f"{package.name}_s__rosidl_typesupport_c{suffix}",
        [_object_folder(package, "extension", out) / "entry.o"],
        [*(f"{package.name}__{library.generator}" for library in _LIBRARIES), *_RUNTIME],
        [],
    )


def _compiler(variable: str, default: str) -> list[str]:
    command = shlex.split(os.environ.get(variable) or default)
    if shutil.which(command[0]) is None:
        raise PlatformError(
            f"no compiler {command[0]!r}: install gcc and g++ (Debian, Ubuntu: apt install g++)"
            " or set CC and CXX"
        )
    return command


def _run_all(
    pool: ThreadPoolExecutor, function: Callable[[_Object], None], items: list[_Object]
) -> None:
    for _ in pool.map(function, items):
        pass


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode:
        raise CompileError(f"{shlex.join(command)}\n{done.stderr}")
