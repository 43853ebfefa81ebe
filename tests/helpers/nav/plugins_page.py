"""The files of docs/plugins.md: modules with plug-ins, and the parameters that name them."""

from __future__ import annotations

import re
from pathlib import Path

from bringup.parameters.files import Parameters, load_parameters

PAGE = (Path(__file__).parents[3] / "docs" / "plugins.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Return the page's blocks below its heading of a user's own plug-ins."""
    own = PAGE.partition("## One of your own")[2]
    return re.findall(rf"```{language}\n(.*?)```", own, re.DOTALL)


def write_modules(folder: Path) -> list[str]:
    """Write the modules into a folder; return their names."""
    names = []
    for text in blocks("python"):
        name = text.splitlines()[0].removeprefix("# ").removesuffix(".py")
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
        names.append(name)
    return names


def write_parameters(folder: Path) -> list[Path]:
    """Write the parameter files into a folder; return their paths."""
    paths = []
    for k, text in enumerate(blocks("yaml")):
        paths.append(folder / f"{k}.yaml")
        paths[-1].write_text(text, encoding="utf-8")
    return paths


def parameters(folder: Path) -> Parameters:
    """Return the values of all parameter files of the page, written into a folder."""
    return load_parameters(write_parameters(folder))
