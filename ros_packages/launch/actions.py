"""Actions: arguments, configurations, groups, files included, timers, and handlers of events."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from arjuna_core.files.yaml_file import plain
from launch.action import Action, Entities, LaunchDescriptionEntity, entities
from launch.declare_launch_argument import DeclareLaunchArgument as DeclareLaunchArgument
from launch.event_handler import BaseEventHandler, Event
from launch.events import Shutdown as ShutdownEvent
from launch.execute_process import ExecuteLocal as ExecuteLocal
from launch.execute_process import ExecuteProcess as ExecuteProcess
from launch.launch_context import LaunchContext
from launch.launch_description_source import LaunchDescriptionSource
from launch.logging import get_logger
from launch.missing import PackageMissing, left_out, report, without_missing
from launch.substitution import (
    SomeSubstitutionsType,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    performed,
)
from launch.texts import InvalidLaunchFileError

_DEEPEST = 30  # files, each included by the one before


class _Doing(Action):
    """An action that is one function of the context."""

    def __init__(self, do: Callable[[LaunchContext], Any], **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._do = do

    def execute(self, context: LaunchContext) -> None:
        self._do(context)


class SetLaunchConfiguration(Action):
    """Sets a configuration."""

    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self.name = self.__name = normalize_to_list_of_substitutions(name)
        self.value = self.__value = normalize_to_list_of_substitutions(value)

    def _pair(self, context: LaunchContext) -> tuple[str, str]:
        return perform_substitutions(context, self.name), perform_substitutions(context, self.value)

    def execute(self, context: LaunchContext) -> None:
        name, value = self._pair(context)
        context.launch_configurations[name] = value


class SetEnvironmentVariable(SetLaunchConfiguration):
    """Sets a variable of the environment."""

    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(name, value, **kwargs)
        self.__name, self.__value = self.name, self.value

    def execute(self, context: LaunchContext) -> None:
        name, value = self._pair(context)
        context.environment[name] = value


class AppendEnvironmentVariable(SetLaunchConfiguration):
    """Appends to a variable of the environment, or prepends."""

    def __init__(
        self,
        name: SomeSubstitutionsType,
        value: SomeSubstitutionsType,
        prepend: bool = False,
        separator: SomeSubstitutionsType = ":",
        **kwargs: Any,
    ) -> None:
        super().__init__(name, value, **kwargs)
        self.prepend, self.separator = prepend, separator

    def execute(self, context: LaunchContext) -> None:
        name, value = self._pair(context)
        parts = [context.environment.get(name, ""), value]
        if self.prepend:
            parts.reverse()
        joined = perform_substitutions(context, self.separator).join(filter(None, parts))
        context.environment[name] = joined


class UnsetLaunchConfiguration(_Doing):
    """Drops a configuration."""

    known = staticmethod(lambda context: context.launch_configurations)

    def __init__(self, name: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(
            lambda c: self.known(c).pop(perform_substitutions(c, name), None), **kwargs
        )


class UnsetEnvironmentVariable(UnsetLaunchConfiguration):
    """Drops a variable of the environment."""

    known = staticmethod(lambda context: context.environment)


class PushLaunchConfigurations(Action):
    """Saves the configurations."""

    def execute(self, context: LaunchContext) -> None:
        context.push_launch_configurations()


class PopLaunchConfigurations(Action):
    """Takes the saved configurations back."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_launch_configurations()


class PushEnvironment(Action):
    """Saves the environment."""

    def execute(self, context: LaunchContext) -> None:
        context.push_environment()


class PopEnvironment(Action):
    """Takes the saved environment back."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_environment()


class ResetEnvironment(Action):
    """Takes the environment back that launching began with."""

    def execute(self, context: LaunchContext) -> None:
        context.replace_environment(context.first)


class ResetLaunchConfigurations(Action):
    """Drops all configurations but those given, whose values are taken before."""

    def __init__(
        self,
        launch_configurations: Mapping[Any, SomeSubstitutionsType] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._kept = dict(launch_configurations or {})

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations = performed(context, self._kept)


class GroupAction(Action):
    """Actions together, whose configurations and environment may stay among them."""

    def __init__(
        self,
        actions: Iterable[Action],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: Mapping[Any, SomeSubstitutionsType] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.__actions, self.__scoped, self._forwarding = list(actions), scoped, forwarding
        self._given = dict(launch_configurations or {})

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        return self.__actions

    def get_sub_entities(self) -> Entities:
        """Return the actions, and what keeps their configurations among them."""
        given: list[Action] = (
            [SetLaunchConfiguration(name, value) for name, value in self._given.items()]
            if self._forwarding
            else [ResetLaunchConfigurations(self._given)]
        )
        if not self.__scoped:
            return [*given, *self.__actions]
        before = [PushLaunchConfigurations(), PushEnvironment()]
        return [*before, *given, *self.__actions, PopEnvironment(), PopLaunchConfigurations()]

    def execute(self, context: LaunchContext) -> Entities:
        return self.get_sub_entities()


class IncludeLaunchDescription(Action):
    """Another launch file, with arguments."""

    def __init__(
        self,
        launch_description_source: LaunchDescriptionSource | SomeSubstitutionsType,
        *,
        launch_arguments: Iterable[tuple[SomeSubstitutionsType, SomeSubstitutionsType]] = (),
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if not isinstance(launch_description_source, LaunchDescriptionSource):
            launch_description_source = LaunchDescriptionSource(location=launch_description_source)
        self.launch_description_source = launch_description_source
        self.__launch_description_source = launch_description_source
        given: Any = launch_arguments or ()
        pairs = given.items() if isinstance(given, Mapping) else given
        self.launch_arguments = self.__launch_arguments = list(pairs)

    def execute(self, context: LaunchContext) -> Entities:
        source = self.launch_description_source
        try:
            description = source.get_launch_description(context)
        except PackageMissing as error:
            report(context, f"a launch file is not included: {error}", error)
            return []
        except InvalidLaunchFileError:
            path = Path(source.location)
            if path.exists() or not (package := left_out(path)):
                raise
            problem = f"{package} {path.name} is not included"
            report(context, problem, PackageMissing(package))
            return []
        given = [SetLaunchConfiguration(*pair) for pair in self.launch_arguments]
        names = {perform_substitutions(context, name) for name, _ in self.launch_arguments}
        for argument in description.get_launch_arguments():
            is_known = argument.name in names or argument.name in context.launch_configurations
            if argument.default_value is None and argument.condition is None and not is_known:
                where = self.launch_description_source.location
                raise RuntimeError(
                    f"Included launch description '{where}' is missing required argument"
                    f" '{argument.name}' ({argument.description}), given: "
                    f"[{', '.join(sorted(names))}]"
                )
        locals_ = context.get_locals_as_dict()
        path = Path(self.launch_description_source.location).absolute()
        depth = locals_.get("depth_of_includes") or 0
        if depth >= _DEEPEST:
            raise RuntimeError(f"launch file {path} is included {depth} deep; does it hold itself?")
        here: dict[str, Any] = {"current_launch_file_path": path, "depth_of_includes": depth + 1}
        here["current_launch_file_directory"] = path.parent
        back = {name: locals_.get(name) for name in here}
        return [
            *given,
            _Doing(lambda c: c.extend_locals(here)),
            description,
            _Doing(lambda c: c.extend_locals(back)),
        ]


class OpaqueFunction(Action):
    """A function of the context, which returns what is visited next."""

    def __init__(
        self,
        *,
        function: Callable[..., Any],
        args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None,
        **rest: Any,
    ) -> None:
        super().__init__(**rest)
        self.__function, self._args, self._kwargs = function, tuple(args or ()), dict(kwargs or {})

    def execute(self, context: LaunchContext) -> Entities:
        return without_missing(
            context, lambda: entities(self.__function(context, *self._args, **self._kwargs))
        )


class ForEach(OpaqueFunction):
    """The entities of a function, called with each of some mappings: YAML with `;` between."""

    def __init__(
        self, input_values: SomeSubstitutionsType, *, function: Callable[..., Any], **rest: Any
    ) -> None:
        def each(context: LaunchContext) -> list[LaunchDescriptionEntity]:
            texts = perform_substitutions(context, input_values).split(";")
            given = (plain(text) for text in texts if text.strip())
            return [one for values in given for one in entities(function(**values))]

        super().__init__(function=each, **rest)


class ForLoop(OpaqueFunction):
    """The entities of a function, called with each `i` below a length."""

    def __init__(
        self, length: SomeSubstitutionsType, *, function: Callable[..., Any], **rest: Any
    ) -> None:
        def each(context: LaunchContext) -> list[LaunchDescriptionEntity]:
            numbers = range(int(perform_substitutions(context, length)))
            return [one for i in numbers for one in entities(function(i=i))]

        rest.pop("name", None)  # of XML's index
        super().__init__(function=each, **rest)


class OpaqueCoroutine(OpaqueFunction):
    """A coroutine that runs beside."""

    def __init__(self, *, coroutine: Callable[..., Any], **kwargs: Any) -> None:
        self._ignored, self._coroutine = kwargs.pop("ignore_context", False), coroutine
        super().__init__(function=coroutine, **kwargs)

    def execute(self, context: LaunchContext) -> Entities:
        first = () if self._ignored else (context,)
        context.start(self._coroutine(*first, *self._args, **self._kwargs))
        return []


class LogInfo(Action):
    """Prints a message."""

    level = "info"

    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.msg = self.__msg = normalize_to_list_of_substitutions(msg)

    def execute(self, context: LaunchContext) -> None:
        getattr(get_logger("user"), self.level)(perform_substitutions(context, self.msg))


class RegisterEventHandler(Action):
    """Has events handled from now on."""

    def __init__(self, event_handler: BaseEventHandler, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.event_handler = self.__event_handler = event_handler

    def execute(self, context: LaunchContext) -> None:
        self.event_handler.configurations = dict(context.launch_configurations)
        context.register_event_handler(self.event_handler)

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        given = getattr(self.event_handler, "entities", None)
        return () if callable(given) else entities(given)


class UnregisterEventHandler(RegisterEventHandler):
    """Has events no longer handled."""

    def execute(self, context: LaunchContext) -> None:
        context.unregister_event_handler(self.event_handler)


class EmitEvent(Action):
    """Lets an event happen."""

    def __init__(self, *, event: Event, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.event = self.__event = event

    def execute(self, context: LaunchContext) -> None:
        context.emit_event_sync(self.event)


class Shutdown(EmitEvent):
    """Ends all."""

    def __init__(
        self, *, reason: SomeSubstitutionsType = "reason not given", **kwargs: Any
    ) -> None:
        super().__init__(event=ShutdownEvent(reason=str(reason)), **kwargs)

    def execute(self, context: LaunchContext) -> None:
        ended: Any = getattr(context.locals, "event", None)
        if getattr(ended, "returncode", None) is not None:
            get_logger("launch").info(f"process[{ended.process_name}] was required: shutting down")
        super().execute(context)


class TimerAction(Action):
    """Actions after a time [s]."""

    says_when_done = True

    def __init__(
        self,
        *,
        period: float | SomeSubstitutionsType,
        actions: Iterable[LaunchDescriptionEntity],
        cancel_on_shutdown: bool | SomeSubstitutionsType = True,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.period = self.__period = period
        self.actions = self.__actions = list(actions)
        self._canceled = False

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        return self.actions

    def cancel(self) -> None:
        self._canceled = True

    def execute(self, context: LaunchContext) -> None:
        given = self.period if not isinstance(self.period, int | float) else str(self.period)
        seconds = float(perform_substitutions(context, given))
        now = dict(context.launch_configurations)

        async def wait() -> None:
            await asyncio.sleep(seconds)
            if not self._canceled and not context.is_shutdown:
                context.within(now, lambda: context.visit_all(self.actions))
                self.say_done(context)

        task = context.start(wait())
        context.on_end.append(task.cancel)
