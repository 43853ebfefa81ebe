"""The level of CPU that a wheel's kernels are compiled for, and who takes them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from numba.core.caching import _CacheLocator

from arjuna_core import shipped_kernels
from arjuna_core.shipped_kernels import TARGET, use_shipped_kernels

HASWELL = "flags : sse2 abm avx avx2 bmi1 bmi2 f16c fma movbe\n"


@pytest.mark.parametrize(
    ("shipped", "cpu", "own", "taken"),
    [
        (True, HASWELL, {}, True),
        (True, HASWELL.replace(" avx2", ""), {}, False),
        (True, HASWELL, {"NUMBA_CPU_NAME": "generic"}, False),
        (False, HASWELL, {}, False),
    ],
)
def test_taken_from_a_wheel_on_such_a_cpu(
    shipped: bool,
    cpu: str,
    own: dict[str, str],
    taken: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shipped_kernels, "MARK", tmp_path / "mark")
    monkeypatch.setattr(os, "environ", dict(own))
    monkeypatch.setattr(shipped_kernels, "sys", type("sys", (), {"modules": {}}))
    if shipped:
        (tmp_path / "mark").touch()
    (tmp_path / "cpuinfo").write_text(cpu)
    use_shipped_kernels(tmp_path / "cpuinfo")
    assert os.environ == (TARGET if taken else own)


def test_one_who_may_not_write_there_gets_a_copy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = tmp_path / "arjuna_core" / "__pycache__" / "scan._rays-93.py311.nbi"
    compiled.parent.mkdir(parents=True)
    compiled.touch()
    monkeypatch.setattr(os, "environ", {"XDG_CACHE_HOME": str(tmp_path / "cache")})
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    monkeypatch.setattr(shipped_kernels, "MARK", tmp_path / "arjuna_core" / "mark")
    (tmp_path / "arjuna_core" / "mark").touch()
    (tmp_path / "cpuinfo").write_text(HASWELL)
    use_shipped_kernels(tmp_path / "cpuinfo")
    folder = _CacheLocator.get_suitable_cache_subpath(str(tmp_path / "arjuna_core" / "scan.py"))
    assert (tmp_path / "cache" / "numba" / folder / compiled.name).exists()
