"""Files that a CMakeLists.txt installs, however people write it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.ros2.workspace.cmake import read_cmake

_SITE = "lib/python3/site-packages"
_BOT = "share/bot"


@pytest.mark.parametrize(
    ("text", "targets"),
    [
        ("install(PROGRAMS scripts/a.py DESTINATION lib/bot RENAME a)", ["lib/bot/a"]),
        (
            "set(NODES scripts/a.py scripts/b.py)  # as ever\n"
            'install(PROGRAMS ${NODES} DESTINATION "lib/${PROJECT_NAME}")',
            ["lib/bot/a.py", "lib/bot/b.py"],
        ),
        (
            "set(NODES scripts/a.py)\nlist(APPEND NODES scripts/b.py)\n"
            "install(PROGRAMS ${NODES} DESTINATION lib/${PROJECT_NAME})",
            ["lib/bot/a.py", "lib/bot/b.py"],
        ),
        (
            "file(GLOB NODES CONFIGURE_DEPENDS scripts/*.py)\n"
            "install(PROGRAMS ${NODES} DESTINATION lib/bot)",
            ["lib/bot/a.py", "lib/bot/b.py"],
        ),
        (
            "file(GLOB_RECURSE FILES RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.yaml)\n"
            "install(FILES ${FILES} DESTINATION share/bot)",
            [f"{_BOT}/c.yaml", f"{_BOT}/d.yaml"],
        ),
        (
            "foreach(dir launch config)\n"
            "  install(DIRECTORY ${dir}/ DESTINATION share/${PROJECT_NAME}/${dir})\n"
            "endforeach()",
            [f"{_BOT}/config/c.yaml", f"{_BOT}/config/deep/d.yaml", f"{_BOT}/launch/go.py"],
        ),
        (
            "foreach(to lib share)\nforeach(file a b)\n"
            "install(PROGRAMS scripts/${file}.py DESTINATION ${to})\n"
            "endforeach()\nmessage(STATUS it's in ${to})\nendforeach()",
            ["lib/a.py", "lib/b.py", "share/a.py", "share/b.py"],
        ),
        (
            "install(DIRECTORY config\n  DESTINATION ${CMAKE_INSTALL_PREFIX}/share/bot\n"
            '  PATTERN "deep" EXCLUDE)',
            [f"{_BOT}/config/c.yaml"],
        ),
        (
            "ament_auto_package(INSTALL_TO_SHARE launch config)",
            [f"{_BOT}/config/c.yaml", f"{_BOT}/config/deep/d.yaml", f"{_BOT}/launch/go.py"],
        ),
        (
            "if((A) AND (B))\nadd_executable(drive src/drive.cpp)\nendif()\n"
            "install(TARGETS drive DESTINATION lib/bot)\ninstall(DIRECTORY launch DESTINATION .)",
            ["launch/go.py"],
        ),
        ("install(FILES no.xml OPTIONAL DESTINATION share/bot)", []),
        (
            "if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/include)\n"
            "install(DIRECTORY include/ DESTINATION include)\nendif()\n"
            "install(DIRECTORY launch DESTINATION .)",
            ["launch/go.py"],
        ),
    ],
)
def test_what_a_cmake_file_installs(text: str, targets: list[str], tmp_path: Path) -> None:
    for name in ("launch/go.py", "config/c.yaml", "config/deep/d.yaml", "scripts/a.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "scripts" / "b.py").touch()
    (tmp_path / "CMakeLists.txt").write_text(f"project(bot)\n{text}\nament_package()\n")
    found = read_cmake(tmp_path, "bot", _SITE)
    assert sorted(str(item.target) for item in found.items) == targets
    assert all(item.source.is_file() for item in found.items)
    assert found.compiled == (["drive"] if "drive" in text else [])
    assert not found.missing


def test_what_is_not_there_and_what_is_generated_are_known(tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "install(DIRECTORY maps DESTINATION share/bot)\nadd_library(x INTERFACE)\n"
        'rosidl_generate_interfaces(${PROJECT_NAME} "msg/Num.msg")\n'
        "ament_python_install_package(${PROJECT_NAME} PACKAGE_DIR src/bot)\n"
    )
    found = read_cmake(tmp_path, "bot", _SITE)
    assert found.missing == [tmp_path / "maps"]
    assert found.is_interfaces
    assert found.modules == {"bot": tmp_path / "src" / "bot"}
    assert found.compiled == []
