"""Message definitions and type hashes of installed packages, as recordings carry them."""

from __future__ import annotations

import json
import re
from pathlib import Path

from ament_index_python.packages import get_package_share_directory

from arjuna_core.ros.context import add_environment_to_ament_index

_TYPE = re.compile(r"\s*(?P<name>[A-Z]\w*|\w+/(?:msg/)?\w+)(?:<=\d+)?(?:\[[^]]*\])?\s+[A-Za-z]")
_PARTS = re.compile(r"^---[ \t]*\n", re.MULTILINE)
_RULE = "=" * 80


def _share(type_name: str, suffix: str) -> Path:
    add_environment_to_ament_index()
    package, kind, name = type_name.split("/")
    return Path(get_package_share_directory(package)) / kind / f"{name}{suffix}"


def type_hash(type_name: str) -> str:
    """Return the RIHS01 hash of a type such as `nav_msgs/msg/Path` (REP 2016)."""
    file = type_name.removesuffix("_FeedbackMessage")
    described = json.loads(_share(file, ".json").read_text(encoding="utf-8"))
    return next(
        str(entry["hash_string"])
        for entry in described["type_hashes"]
        if entry["type_name"] == type_name
    )


def installed_type(type_name: str) -> tuple[str, str]:
    """Return a type's definition and hash; both are empty where it is not installed."""
    try:
        return message_definition(type_name), type_hash(type_name)
    except (LookupError, OSError, ValueError):
        return "", ""


def nested_type(code: str, package: str) -> str | None:
    """Return a field's type in a package as `package/msg/Name`, None where it is no message."""
    match = _TYPE.match(code)
    if match is None:
        return None
    parts = match["name"].split("/")
    return f"{parts[0] if len(parts) > 1 else package}/msg/{parts[-1]}"


def _dependencies(type_name: str, text: str) -> list[str]:
    package = type_name.split("/")[0]
    found = (nested_type(line.partition("#")[0], package) for line in text.splitlines())
    return [name for name in found if name is not None]


def _feedback(type_name: str) -> tuple[str, dict[str, str]]:
    name = type_name.removesuffix("_FeedbackMessage")
    parts = _PARTS.split(_share(name, ".action").read_text(encoding="utf-8"))
    package, _, action = name.split("/")
    feedback = f"{package}/{action}_Feedback"
    return f"unique_identifier_msgs/UUID goal_id\n{feedback} feedback\n", {feedback: parts[-1]}


def _event(type_name: str) -> tuple[str, dict[str, str]]:
    name = type_name.removesuffix("_Event")
    parts = _PARTS.split(_share(name, ".srv").read_text(encoding="utf-8"))
    package, _, service = name.split("/")
    request, response = f"{package}/{service}_Request", f"{package}/{service}_Response"
    text = "service_msgs/ServiceEventInfo info\n"
    text += f"{request}[<=1] request\n{response}[<=1] response\n"
    return text, {request: parts[0], response: parts[-1]}


def message_definition(type_name: str) -> str:
    """Return a type's definition followed by those of all types it needs, `ros2msg` encoding.

    Args:
        type_name: A type such as `nav_msgs/msg/Path`, or that of an action's feedback messages or
            of a service's requests, responses or events: `std_srvs/srv/Trigger_Response`,
            `std_srvs/srv/Trigger_Event`, `nav2_msgs/action/NavigateToPose_FeedbackMessage`.

    Source: the mcap format's registry of schema encodings, `ros2msg`.
    """
    inner: dict[str, str] = {}
    if type_name.endswith("_FeedbackMessage"):
        text, inner = _feedback(type_name)
    elif type_name.endswith("_Event"):
        text, inner = _event(type_name)
    elif "/srv/" in type_name:
        name, _, part = type_name.rpartition("_")
        parts = _PARTS.split(_share(name, ".srv").read_text(encoding="utf-8"))
        text = parts[-1 if part == "Response" else 0]
    else:
        text = _share(type_name, ".msg").read_text(encoding="utf-8")
    sections, seen = [text], {type_name, *(name.replace("/", "/msg/") for name in inner)}
    queue = _dependencies(type_name, text)
    for name, part in inner.items():
        sections.append(f"{_RULE}\nMSG: {name}\n{part}")
        queue += _dependencies(type_name, part)
    while queue:
        needed = queue.pop(0)
        if needed in seen:
            continue
        seen.add(needed)
        text = _share(needed, ".msg").read_text(encoding="utf-8")
        package, _, name = needed.split("/")
        sections.append(f"{_RULE}\nMSG: {package}/{name}\n{text}")
        queue.extend(_dependencies(needed, text))
    return "\n".join(sections)
