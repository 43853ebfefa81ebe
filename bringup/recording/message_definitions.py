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


def definition_path(type_name: str, suffix: str) -> Path:
    """Return the file with a suffix that an installed package has of a type."""
    add_environment_to_ament_index()
    package, kind, name = type_name.split("/")
    return Path(get_package_share_directory(package)) / kind / f"{name}{suffix}"


def type_hash(type_name: str) -> str:
    """Return the RIHS01 hash of a type such as `nav_msgs/msg/Path` (REP 2016)."""
    file = type_name.removesuffix("_FeedbackMessage")
    described = json.loads(definition_path(file, ".json").read_text(encoding="utf-8"))
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


def _own_definition(type_name: str) -> tuple[str, dict[str, str]]:
    """Return a type's own definition, and those of its parts that no file has, by name."""
    suffixes = {"_FeedbackMessage": ".action", "_Event": ".srv", "_Request": ".srv"}
    suffixes["_Response"] = ".srv"
    part = next((each for each in suffixes if type_name.endswith(each)), "")
    if not part or "/msg/" in type_name:
        return definition_path(type_name, ".msg").read_text(encoding="utf-8"), {}
    file = type_name.removesuffix(part)
    parts = _PARTS.split(definition_path(file, suffixes[part]).read_text(encoding="utf-8"))
    package, _, name = file.split("/")
    own = f"{package}/{name}"
    if part == "_FeedbackMessage":
        text = f"unique_identifier_msgs/UUID goal_id\n{own}_Feedback feedback\n"
        return text, {f"{package}/msg/{name}_Feedback": parts[-1]}
    if part == "_Event":
        text = "service_msgs/ServiceEventInfo info\n"
        text += f"{own}_Request[<=1] request\n{own}_Response[<=1] response\n"
        ends = {"Request": parts[0], "Response": parts[-1]}
        return text, {f"{package}/msg/{name}_{end}": each for end, each in ends.items()}
    return parts[-1 if part == "_Response" else 0], {}


def message_definition(type_name: str) -> str:
    """Return a type's definition followed by those of all types it needs, `ros2msg` encoding.

    Args:
        type_name: A type such as `nav_msgs/msg/Path`, or that of an action's feedback messages or
            of a service's requests, responses or events: `std_srvs/srv/Trigger_Response`,
            `std_srvs/srv/Trigger_Event`, `nav2_msgs/action/NavigateToPose_FeedbackMessage`.

    Source: the mcap format's registry of schema encodings, `ros2msg`.
    """
    text, inner = _own_definition(type_name)
    sections, seen, queue = [text], {type_name}, _dependencies(type_name, text)
    while queue:
        needed = queue.pop(0)
        if needed in seen:
            continue
        seen.add(needed)
        text = inner[needed] if needed in inner else _own_definition(needed)[0]
        package, _, name = needed.split("/")
        sections.append(f"{_RULE}\nMSG: {package}/{name}\n{text}")
        queue.extend(_dependencies(needed, text))
    return "\n".join(sections)
