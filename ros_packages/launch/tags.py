"""The actions of `launch` by their tags in XML and YAML."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from launch import actions
from launch.action import Action
from launch.frontend import TAGS, Entity, action_of
from launch.launch_description_sources import AnyLaunchDescriptionSource


def _inside(entity: Entity, *without: str) -> list[Action]:
    return [action_of(child) for child in entity.children if child.tag not in without]


def _argument(entity: Entity) -> Action:
    if "value" in entity.texts:  # as ROS 1 has it
        return _let(entity)
    choices = [child.plain("value") for child in entity.all("choice")]
    return actions.DeclareLaunchArgument(
        entity.plain("name"),
        default_value=entity.text("default"),
        description=entity.texts.get("description", ""),
        choices=choices or None,
    )


def _let(entity: Entity) -> Action:
    return actions.SetLaunchConfiguration(entity.needed("name"), entity.needed("value"))


def _include(entity: Entity) -> Action:
    pairs = [
        (one.needed("name"), one.needed("value", "default"))
        for one in (*entity.all("arg"), *entity.all("let"))
    ]
    source = AnyLaunchDescriptionSource(entity.needed("file"))
    return actions.IncludeLaunchDescription(source, launch_arguments=pairs)


def _group(entity: Entity) -> Action:
    return actions.GroupAction(
        _inside(entity, "keep"),
        scoped=entity.flag("scoped", True),
        forwarding=entity.flag("forwarding", True),
        launch_configurations=_pairs(entity, "keep"),
    )


def _pairs(entity: Entity, tag: str) -> dict[str, Any]:
    return {one.plain("name"): one.needed("value") for one in entity.all(tag)}


def of_process(entity: Entity) -> dict[str, Any]:
    """Return what a process and a node have in common."""
    usual = {
        name: entity.text(given)
        for name, given in (
            *(("output", "output"), ("cwd", "cwd"), ("respawn", "respawn")),
            *(("sigterm_timeout", "sigterm_timeout"), ("sigkill_timeout", "sigkill_timeout")),
            ("prefix", "launch-prefix" if "launch-prefix" in entity.texts else "launch_prefix"),
        )
    }
    found: dict[str, Any] = {name: text for name, text in usual.items() if text is not None}
    if "respawn_delay" in entity.texts:
        found["respawn_delay"] = float(entity.texts["respawn_delay"])
    if entity.texts.get("on_exit") == "shutdown":
        found["on_exit"] = actions.Shutdown()
    variables = _pairs(entity, "env")
    return {**found, **({"additional_env": variables} if variables else {})}


def _executable(entity: Entity) -> Action:
    given = of_process(entity)
    if (name := entity.text("name")) is not None:
        given["name"] = name
    words = [entity.needed("cmd"), *([entity.needed("args")] if "args" in entity.texts else [])]
    command: Any = [words[0]] if len(words) == 1 else [[*words[0], " ", *words[1]]]
    return actions.ExecuteProcess(cmd=command, shell=True, **given)  # noqa: S604 - its own words


def _environment(kind: type[Any]) -> Callable[[Entity], Action]:
    def of(entity: Entity) -> Action:
        rest = {"prepend": True} if entity.texts.get("prepend") == "true" else {}
        return kind(entity.needed("name"), entity.needed("value"), **rest)  # type: ignore[no-any-return]

    return of


TAGS |= {
    "append_env": _environment(actions.AppendEnvironmentVariable),
    "arg": _argument,
    "executable": _executable,
    "group": _group,
    "include": _include,
    "let": _let,
    "log": lambda e: actions.LogInfo(msg=e.needed("message")),
    "pop_env": lambda e: actions.PopEnvironment(),
    "push_env": lambda e: actions.PushEnvironment(),
    "reset": lambda e: actions.ResetLaunchConfigurations(_pairs(e, "keep")),
    "reset_env": lambda e: actions.ResetEnvironment(),
    "set_env": _environment(actions.SetEnvironmentVariable),
    "shutdown": lambda e: actions.Shutdown(reason=e.texts.get("reason", "reason not given")),
    "timer": lambda e: actions.TimerAction(period=e.needed("period"), actions=_inside(e)),
    "unlet": lambda e: actions.UnsetLaunchConfiguration(e.needed("name")),
    "unset_env": lambda e: actions.UnsetEnvironmentVariable(e.needed("name")),
}
