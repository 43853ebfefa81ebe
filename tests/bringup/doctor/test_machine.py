"""The processes of ours, from a /proc of the test's own."""

from __future__ import annotations

from pathlib import Path

from bringup.doctor.machine import host_processes


def _process(proc: Path, pid: int, command: str, environment: str = "") -> None:
    folder = proc / str(pid)
    folder.mkdir()
    (folder / "cmdline").write_bytes(command.replace(" ", "\0").encode())
    (folder / "environ").write_bytes(environment.encode())
    times = "S 1 1 1 0 -1 0 0 0 0 0 250 50 0 0"
    (folder / "stat").write_text(f"{pid} (python (odd)) {times}")


def test_hosts_are_found_with_group_and_domain(tmp_path: Path) -> None:
    host = "python -m bringup.host"
    _process(tmp_path, 12, f"{host} slam --parameters {{}}", "HOME=/\0ROS_DOMAIN_ID=7\0")
    _process(tmp_path, 3, f"{host} sim", "HOME=/\0")
    _process(tmp_path, 4, "python -m bringup sim")
    (tmp_path / "5").mkdir()
    found = host_processes(tmp_path)
    assert [(each.pid, each.group, each.domain) for each in found] == [
        (3, "sim", 0),
        (12, "slam", 7),
    ]
    assert found[0].cpu_time > 0.0
