"""Build script: one wheel with all packages of definitions in this folder."""

from __future__ import annotations

import sys
from pathlib import Path

from setuptools import Extension, setup

sys.path.insert(0, str(Path(__file__).parent))  # PEP 517 builds do not add the source folder

from rosidl_build.package import BuildInterfaces

setup(
    packages=[],
    py_modules=[],
    # An extension without sources: it gives the wheel its platform tag and makes build_ext run.
    ext_modules=[Extension("_arjuna_interfaces", sources=[])],
    cmdclass={"build_ext": BuildInterfaces},
)
