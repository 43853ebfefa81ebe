"""Builds somebody's own packages of definitions into the environment that this runs in."""

from __future__ import annotations

import re
import shutil
import sysconfig
import tempfile
from pathlib import Path

from rosidl_build.definitions import KINDS, InterfacePackage, in_dependency_order, package_of

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_MARK = "built_here"  # in share/PACKAGE: the package is none of the wheels'
_SKIPPED = {"build", "install", "log"}  # colcon's


def packages_below(root: Path) -> list[InterfacePackage]:
    """Return the packages of definitions in a folder, each after those that it depends on.

    Raises:
        ValueError: There is none, a name is not valid, or they depend on each other in a circle.
    """
    files = (path for kind in KINDS for path in root.rglob(f"{kind}/*.{kind}"))
    folders = {
        path.parent.parent.resolve()
        for path in files
        if not _SKIPPED & set(path.relative_to(root).parts)
    }
    found = {}
    for folder in sorted(folders):
        package = package_of(folder, _name_of(folder))
        if not _NAME.fullmatch(package.name):
            raise ValueError(f"{folder}: '{package.name}' is no name; valid: a-z, 0-9, _")
        found[package.name] = package
    if not found:
        raise ValueError(f"{root}: no msg/NAME.msg, srv/NAME.srv or action/NAME.action below")
    return in_dependency_order(found)


def _name_of(folder: Path) -> str:
    """Return the name that a package's manifest gives it, else its folder's."""
    manifest = folder / "package.xml"
    text = manifest.read_text(encoding="utf-8") if manifest.is_file() else ""
    named = re.search(r"<name>\s*(\w+)\s*</name>", text)
    return named[1] if named else folder.name


def build(root: Path, target: Path | None = None) -> list[str]:
    """Build the packages below a folder into the environment; return their names.

    Args:
        target: A prefix instead of the environment's, Python's files in its `site-packages`.

    Raises:
        ValueError: They cannot be built: no packages, or one of the environment's own.
        setuptools.errors.BaseError: There is no compiler, or it failed.
    """
    from rosidl_build.compile_ import Toolchain, compile_packages
    from rosidl_build.generate import find_prefix, generate
    from rosidl_build.package import copy_python, data_files

    packages, prefix = packages_below(root), find_prefix()
    installed = Path(sysconfig.get_paths()["platlib"])
    for package in packages:
        share = prefix / "share" / package.name
        if (installed / package.name).exists() and not (share / _MARK).exists():
            raise ValueError(f"'{package.name}' is a package of the environment; use another name")
    needed = _without_headers(packages, prefix)
    with tempfile.TemporaryDirectory() as folder:
        out, built = Path(folder) / "rosidl", Path(folder) / "site"
        out.mkdir()
        built.mkdir()
        generate([*needed, *packages], prefix, out)
        for package in needed:  # their libraries are linked to
            (built / package.name).symlink_to(installed / package.name)
        for package in packages:
            copy_python(package, out, built)
        beside = [package.name for package in needed]
        compile_packages(packages, Toolchain(prefix, out), out, built, beside)
        site = target / "site-packages" if target else installed
        for package in packages:
            shutil.rmtree(site / package.name, ignore_errors=True)
            shutil.copytree(built / package.name, site / package.name)
            (out / "share" / package.name / _MARK).touch()
        for path, files in data_files(packages, out, "0.0.0"):
            _copy(files, (target or prefix) / path, {package.name for package in packages})
    return [package.name for package in packages]


def _copy(files: list[str], path: Path, packages: set[str]) -> None:
    """Copy the files of some packages, and their entries of the index, to a folder."""
    for file in map(Path, files):
        if packages & {*path.parts, file.name}:
            path.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, path)


def _without_headers(packages: list[InterfacePackage], prefix: Path) -> list[InterfacePackage]:
    """Return the packages that these need and whose C headers no wheel has, in their order.

    Raises:
        ValueError: One is not installed.
    """
    own = {package.name for package in packages}
    found: dict[str, InterfacePackage] = {}
    waiting = sorted({name for package in packages for name in package.dependencies} - own)
    while waiting:
        name = waiting.pop()
        share = prefix / "share" / name
        if not share.is_dir():
            raise ValueError(f"no package '{name}', which the definitions use, is installed")
        if name not in found and not (prefix / "include" / name).is_dir():
            found[name] = package_of(share, name)
            waiting += sorted(set(found[name].dependencies) - own)
    return in_dependency_order(found)
