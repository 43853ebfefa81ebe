"""Actions: nodes, what all nodes of a scope get, and containers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from launch.action import Action, Entities
from launch.actions import GroupAction, IncludeLaunchDescription, TimerAction
from launch.events.process import ProcessStarted
from launch.execute_process import ExecuteProcess
from launch.launch_context import LaunchContext
from launch.launch_description_source import LaunchDescriptionSource
from launch.logging import get_logger
from launch.substitution import (
    SomeSubstitutionsType,
    SubstitutionFailure,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch.substitutions import PathJoinSubstitution

from launch_ros.descriptions import ComposableNode
from launch_ros.lifecycle import LifecycleTransitions
from launch_ros.parameter_descriptions import (
    ParameterFile,
    files_of,
    normalize_parameters,
    value_of,
)
from launch_ros.substitutions import ExecutableInPackage, FindPackageShare

_NAMESPACE, _PARAMETERS, _REMAPS = "ros_namespace", "global_params", "ros_remaps"
_LAUNCHED = "ARJUNA_LAUNCHED"
"""The variable, where it is set, that tells later programs of the nodes that were started."""


class Node(ExecuteProcess):
    """Runs a node of a package."""

    def __init__(
        self,
        *,
        executable: SomeSubstitutionsType,
        package: SomeSubstitutionsType | None = None,
        name: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        exec_name: SomeSubstitutionsType | None = None,
        parameters: Iterable[Any] | None = None,
        remappings: Iterable[tuple[Any, Any]] | None = None,
        ros_arguments: Iterable[SomeSubstitutionsType] | None = None,
        arguments: Iterable[SomeSubstitutionsType] | None = None,
        **kwargs: Any,
    ) -> None:
        if isinstance(parameters, str | bytes | Mapping):
            raise TypeError(f"parameters of '{executable}': valid: a list of files and mappings")
        path = executable if package is None else ExecutableInPackage(executable, package)
        super().__init__(cmd=[path], name=exec_name or executable, **kwargs)
        self.node_package = self.__package = package
        self.node_executable = self.__node_executable = executable
        self.__node_name, self.__node_namespace = name, namespace
        self.__parameters = normalize_parameters(parameters or ())
        self.__remappings = [
            (normalize_to_list_of_substitutions(a), normalize_to_list_of_substitutions(b))
            for a, b in remappings or ()
        ]
        self.__arguments, self.__ros_arguments = list(arguments or ()), list(ros_arguments or ())
        self.expanded_node_name = ""

    @property
    def node_name(self) -> str:
        """Its full name, once it was started."""
        return self.expanded_node_name

    def words(self, context: LaunchContext) -> list[str]:
        """Return the program, its arguments, and ROS's between `--ros-args` and the end."""
        program = super().words(context)
        outer = context.launch_configurations.get(_NAMESPACE, "")
        own = _performed(context, self.__node_namespace)
        space = own if own.startswith("/") else f"{outer}/{own}".strip("/")
        space = f"/{space.strip('/')}" if space.strip("/") else ""
        name = _performed(context, self.__node_name)
        self.expanded_node_name = f"{space}/{name or '<node_name_unspecified>'}"
        if _LAUNCHED in context.environment:
            program_name = _performed(context, self.node_executable)
            context.environment[_LAUNCHED] += f" {space}/{program_name}"
        given = [*context.launch_configurations.get(_PARAMETERS, ()), *self.__parameters]
        node = self.expanded_node_name if name else "/**"
        remaps: list[Any] = [
            *([("__node", name)] if name else []),
            *([("__ns", space)] if space else []),
        ]
        remaps += [*context.launch_configurations.get(_REMAPS, ()), *self.__remappings]
        ros = [perform_substitutions(context, one) for one in self.__ros_arguments]
        for old, new in remaps:
            pair = (perform_substitutions(context, old), perform_substitutions(context, new))
            ros += ["-r", ":=".join(pair)]
        for file in files_of(context, given, node):
            ros += ["--params-file", file]
        own_words = [perform_substitutions(context, one) for one in self.__arguments]
        return [*program, *own_words, *(["--ros-args", *ros] if ros else [])]

    def execute(self, context: LaunchContext) -> Entities | None:
        try:
            return super().execute(context)
        except SubstitutionFailure as error:
            package = _performed(context, self.node_package)
            missing = Missing(package, _performed(context, self.node_executable), str(error))
            context.problems.append(str(missing))
            get_logger("launch").error(str(missing))
            return None


class Missing(RuntimeError):
    """A node's package or executable is not there."""

    remedy: Callable[[str], str] = staticmethod(lambda package: "")
    """Returns what to do instead, by package."""

    def __init__(self, package: str, executable: str, why: str) -> None:
        problem = f"{package} {executable} is not started: {why}; {self.remedy(package)}"
        super().__init__(problem.rstrip("; "))


def _performed(context: LaunchContext, given: SomeSubstitutionsType | None) -> str:
    return "" if given is None else perform_substitutions(context, given)


class LifecycleNode(Node):
    """Runs a node with a lifecycle; events change its state and report it."""

    def __init__(
        self,
        *,
        name: SomeSubstitutionsType,
        namespace: SomeSubstitutionsType = "",
        autostart: bool | SomeSubstitutionsType = False,
        **kwargs: Any,
    ) -> None:
        super().__init__(name=name, namespace=namespace, **kwargs)
        self._autostart = autostart

    @property
    def is_lifecycle_node(self) -> bool:
        return True

    def execute(self, context: LaunchContext) -> Entities | None:
        found = super().execute(context)
        if self.expanded_node_name:
            given = self._autostart
            if not isinstance(given, bool):
                given = perform_substitutions(context, given).lower() in ("true", "1")
            LifecycleTransitions.of(context).follow(self, given)
        return found


class LifecycleTransition(Action):
    """Takes nodes, by their names, through transitions, one after the other."""

    def __init__(
        self,
        *,
        lifecycle_node_names: Iterable[SomeSubstitutionsType],
        transition_ids: Iterable[int | SomeSubstitutionsType],
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._names, self._ids = list(lifecycle_node_names), list(transition_ids)

    def execute(self, context: LaunchContext) -> None:
        ids = [
            i if isinstance(i, int) else int(perform_substitutions(context, i)) for i in self._ids
        ]
        for one in self._names:
            name = f"/{perform_substitutions(context, one).lstrip('/')}"
            context.start(LifecycleTransitions.of(context).change(name, *ids))


class _Pushing(Action):
    """Puts something into the configurations that nodes of the scope take."""

    def __init__(self, key: str, value: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._key, self._value = key, value

    def execute(self, context: LaunchContext) -> None:
        known = context.launch_configurations
        known[self._key] = [*known.get(self._key, ()), self.value(context)]

    def value(self, context: LaunchContext) -> Any:
        return self._value


class SetParameter(_Pushing):
    """Sets a parameter of all nodes that follow in the scope."""

    def __init__(self, name: SomeSubstitutionsType, value: Any, **kwargs: Any) -> None:
        super().__init__(_PARAMETERS, (name, value), **kwargs)

    def value(self, context: LaunchContext) -> Any:
        name, value = self._value
        return {perform_substitutions(context, name): value_of(context, value)}


class SetUseSimTime(SetParameter):
    """Sets `use_sim_time` of all nodes that follow in the scope."""

    def __init__(self, value: Any, **kwargs: Any) -> None:
        super().__init__("use_sim_time", value, **kwargs)


class SetParametersFromFile(_Pushing):
    """Gives a file of parameters to all nodes that follow in the scope."""

    def __init__(self, filename: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(_PARAMETERS, filename, **kwargs)

    def value(self, context: LaunchContext) -> Any:
        return ParameterFile(perform_substitutions(context, self._value))


class SetRemap(_Pushing):
    """Gives a name another name in all nodes that follow in the scope."""

    def __init__(
        self, src: SomeSubstitutionsType, dst: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(_REMAPS, (src, dst), **kwargs)

    def value(self, context: LaunchContext) -> Any:
        return tuple(perform_substitutions(context, one) for one in self._value)


class PushROSNamespace(Action):
    """Puts all nodes that follow in the scope below a namespace."""

    def __init__(self, namespace: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.namespace = self.__namespace = normalize_to_list_of_substitutions(namespace)

    def execute(self, context: LaunchContext) -> None:
        own = perform_substitutions(context, self.namespace)
        outer = "" if own.startswith("/") else context.launch_configurations.get(_NAMESPACE, "")
        context.launch_configurations[_NAMESPACE] = f"{outer}/{own}".replace("//", "/").rstrip("/")


PushRosNamespace = PushROSNamespace


class SetROSLogDir(Action):
    """Sets the folder of log files."""

    def __init__(self, new_log_dir: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.log_dir = new_log_dir

    def execute(self, context: LaunchContext) -> None:
        context.environment["ROS_LOG_DIR"] = perform_substitutions(context, self.log_dir)


class LoadComposableNodes(Action):
    """Starts nodes of a container, each in a process of its own."""

    plugins: Mapping[str, tuple[str, str]] = {}
    """Package and executable of a plug-in that has another's name."""

    def __init__(
        self,
        *,
        composable_node_descriptions: Iterable[ComposableNode],
        target_container: Any = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.__composable_node_descriptions = list(composable_node_descriptions)
        self.__target_container = target_container

    def execute(self, context: LaunchContext) -> Entities:
        chosen = (
            one
            for one in self.__composable_node_descriptions
            if one.condition is None or one.condition.evaluate(context)
        )
        return [self._node(context, one) for one in chosen]

    def _node(self, context: LaunchContext, given: ComposableNode) -> Node:
        plugin = perform_substitutions(context, given.plugin)
        package = perform_substitutions(context, given.package)
        package, executable = self.plugins.get(plugin, (package, plugin))
        return Node(
            package=package,
            executable=executable,
            name=given.name,
            namespace=given.namespace,
            parameters=given.parameters,
            remappings=given.remappings,
            output="screen",
        )


class IncludeOfPackage(Action):
    """A known launch file of a package, whose arguments it takes by their names."""

    file: tuple[str, str]

    def __init__(self, *, condition: Any = None, **given: Any) -> None:
        super().__init__(condition=condition)
        self._given = {name: value for name, value in given.items() if value is not None}

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type[Any], dict[str, Any]]:
        texts = entity.texts.items()
        own = {name: text for name, text in texts if name not in ("if", "unless")}
        return cls, {name: parser.parse_substitution(text) for name, text in own.items()}

    def execute(self, context: LaunchContext) -> Entities:
        package, file = self.file
        path = PathJoinSubstitution([FindPackageShare(package), "launch", file])
        source = LaunchDescriptionSource(location=path)
        included = IncludeLaunchDescription(source, launch_arguments=self._given.items())
        return [GroupAction([included])]


class ComposableNodeContainer(LoadComposableNodes):
    """A container: its nodes, for there is no process of it; it has started as soon as they do."""

    def __init__(
        self,
        *,
        name: SomeSubstitutionsType = "",
        namespace: SomeSubstitutionsType = "",
        package: Any = None,
        executable: Any = None,
        composable_node_descriptions: Iterable[ComposableNode] | None = None,
        condition: Any = None,
        **unused: Any,
    ) -> None:
        super().__init__(
            composable_node_descriptions=composable_node_descriptions or (), condition=condition
        )
        self._name = name
        self.__composable_node_descriptions = list(composable_node_descriptions or ())

    def execute(self, context: LaunchContext) -> Entities:
        name = perform_substitutions(context, self._name)
        context.emit_event_sync(ProcessStarted(action=self, name=name))
        return super().execute(context)


ROSTimer = RosTimer = TimerAction
"""Timers by the launching machine's clock."""
