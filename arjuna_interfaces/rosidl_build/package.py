"""The setuptools command that fills the wheel."""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools.command.build_ext import build_ext

from rosidl_build.definitions import InterfacePackage, find_packages

_ROOT = Path(__file__).resolve().parents[1]


class BuildInterfaces(build_ext):
    """Generates, compiles and stages every package of definitions in the source folder."""

    def run(self) -> None:
        """Fill `build_lib` (Python files, libraries) and the wheel's data files (share/)."""
        # Imported here: metadata can then be read without the generators.
        from rosidl_build.compile_ import Toolchain, compile_packages
        from rosidl_build.generate import find_prefix, generate

        out = Path(self.build_temp).resolve() / "rosidl"
        target = Path(self.build_lib).resolve()
        shutil.rmtree(out, ignore_errors=True)  # what was removed must not stay in the wheel
        shutil.rmtree(target, ignore_errors=True)
        packages = find_packages(_ROOT)
        prefix = find_prefix()
        out.mkdir(parents=True)
        toolchain = Toolchain(prefix, out)
        generate(packages, prefix, out)
        for package in packages:
            copy_python(package, out, target)
        compile_packages(packages, toolchain, out, target)
        # with it `arjuna messages` builds a user's own
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(_ROOT / "rosidl_build", target / "rosidl_build", ignore=ignored)
        self.distribution.data_files = data_files(packages, out, self.distribution.get_version())


def copy_python(package: InterfacePackage, out: Path, target: Path) -> None:
    """Copy a package's generated Python files below a folder."""
    source = out / "rosidl_generator_py" / package.name
    shutil.copytree(source, target / package.name, ignore=shutil.ignore_patterns("*.c"))
    (target / package.name / "__init__.py").touch()


def data_files(
    packages: list[InterfacePackage], out: Path, version: str
) -> list[tuple[str, list[str]]]:
    """List definitions, type descriptions and ament index entries for `share/`."""
    share = out / "share"
    for package in packages:
        (share / package.name / "package.xml").write_text(
            _manifest(package, version), encoding="utf-8"
        )
        names = sorted(
            p.relative_to(share / package.name) for p in _interface_files(package, share)
        )
        index = share / "ament_index" / "resource_index"
        for kind, text in (("packages", ""), ("rosidl_interfaces", "\n".join(map(str, names)))):
            (index / kind).mkdir(parents=True, exist_ok=True)
            (index / kind / package.name).write_text(text, encoding="utf-8")
    folders = sorted({path.parent for path in share.rglob("*") if path.is_file()})
    return [
        (str(folder.relative_to(out)), sorted(str(p) for p in folder.iterdir() if p.is_file()))
        for folder in folders
    ]


def _manifest(package: InterfacePackage, version: str) -> str:
    """Return the package.xml that `ros2 pkg xml` shows."""
    needs = "".join(f"  <depend>{name}</depend>\n" for name in package.dependencies)
    return (
        '<?xml version="1.0"?>\n<package format="3">\n'
        f"  <name>{package.name}</name>\n  <version>{version}</version>\n"
        f"  <description>The messages of {package.name}, built for Arjuna.</description>\n"
        '  <maintainer email="arjuna@localhost">The Arjuna developers</maintainer>\n'
        f"  <license>that of Arjuna</license>\n{needs}"
        "  <member_of_group>rosidl_interface_packages</member_of_group>\n</package>\n"
    )


def _interface_files(package: InterfacePackage, share: Path) -> list[Path]:
    """List what the ament index names: definitions and .idl, without the .json hashes."""
    return [
        path
        for path in (share / package.name).rglob("*")
        if path.is_file() and path.suffix not in (".json", ".xml")
    ]
