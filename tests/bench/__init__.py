"""Benchmarks: each has its options, and a run that returns what it measured."""

from __future__ import annotations

import argparse
from types import ModuleType
from typing import Any


def run(module: ModuleType, *argv: str) -> dict[str, Any]:
    """Return what a benchmark measures with some options."""
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)
    result: dict[str, Any] = module.run(parser.parse_args(argv))
    return result
