"""The installed types are, hash for hash, those that real ROS 2 Jazzy clients use."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.ros

EXPECTED: dict[str, str] = json.loads(Path(__file__).with_name("type_hashes.json").read_text())
OURS = [*EXPECTED, "arjuna_interfaces/msg/LocalizationQuality"]
PACKAGES = sorted({name.split("/")[0] for name in OURS})


def load(name: str) -> Any:
    """Return the class of a type such as `bond/msg/Status`."""
    package, kind, stem = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), stem)


def share(package: str) -> Path:
    """Return the installed definitions of a package, found as ROS tools find them."""
    from ament_index_python.packages import get_package_share_directory

    from arjuna_core.ros.context import add_environment_to_ament_index

    add_environment_to_ament_index()
    return Path(get_package_share_directory(package))


@pytest.fixture(scope="module")
def node() -> Iterator[Any]:
    from rclpy.context import Context
    from rclpy.node import Node

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        context = Context()
        context.init(domain_id=int(os.environ.get("ROS_DOMAIN_ID", "77")))
        node = Node("type_hashes", context=context, start_parameter_services=False)
        yield node
        node.destroy_node()
        context.shutdown()


def test_installed_type_descriptions_have_the_expected_hashes() -> None:
    for name, expected in EXPECTED.items():
        package, kind, stem = name.split("/")
        description = json.loads((share(package) / kind / f"{stem}.json").read_text())
        hashes = {entry["type_name"]: entry["hash_string"] for entry in description["type_hashes"]}
        assert hashes[name] == expected, name


def test_types_load_their_compiled_type_support() -> None:
    from rclpy.type_support import check_for_type_support

    for name in OURS:
        cls = load(name)
        if "/action/" in name:
            cls.__class__.__import_type_support__()
            assert cls.__class__._TYPE_SUPPORT is not None, name
        else:
            check_for_type_support(cls)


def test_publishers_announce_the_expected_hashes(node: Any) -> None:
    for name in (name for name in EXPECTED if "/msg/" in name):
        topic = name.lower()
        publisher = node.create_publisher(load(name), topic, 1)
        (info,) = node.get_publishers_info_by_topic(topic)
        assert (info.topic_type, str(info.topic_type_hash)) == (name, EXPECTED[name])
        node.destroy_publisher(publisher)


def test_services_and_actions_register_with_the_middleware(node: Any) -> None:
    # A package without its introspection type support imports, and fails only here.
    from rclpy.action import ActionClient

    for name in (name for name in OURS if "/msg/" not in name):
        if "/srv/" in name:
            node.destroy_client(node.create_client(load(name), name.lower()))
        else:
            ActionClient(node, load(name), name.lower()).destroy()


def test_the_ament_index_lists_the_interfaces_of_each_package() -> None:
    from ament_index_python import get_resource

    for package in PACKAGES:
        folder = share(package)
        content, _ = get_resource("rosidl_interfaces", package)
        listed = set(content.splitlines())
        defined = {f"{name.partition('/')[2]}.{name.split('/')[1]}" for name in OURS
                   if name.startswith(f"{package}/")}  # fmt: skip
        assert {entry for entry in listed if not entry.endswith(".idl")} == defined
        assert all((folder / entry).is_file() for entry in listed)
