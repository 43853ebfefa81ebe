"""ROS 2's `launch`: descriptions of what to start, and the service that starts it."""

from bringup.ros2.prefix import add_prefix
from launch import (
    action,
    actions,
    conditions,
    descriptions,
    event_handler,
    event_handlers,
    events,
    frontend,
    launch_description_source,
    launch_description_sources,
    logging,
    substitution,
    substitutions,
    tags,
    utilities,
)
from launch.action import (
    Action,
    Condition,
    LaunchDescriptionEntity,
    SomeActionsType,
    SomeActionsType_types_tuple,
    SomeEntitiesType,
    SomeEntitiesType_types_tuple,
)
from launch.by_file import import_as, import_by_file
from launch.event_handler import BaseEventHandler, Event, EventHandler
from launch.launch_context import LaunchContext
from launch.launch_description import LaunchDescription
from launch.launch_description_source import LaunchDescriptionSource
from launch.launch_introspector import LaunchIntrospector
from launch.launch_service import LaunchService
from launch.substitution import (
    SomeSubstitutionsType,
    SomeSubstitutionsType_types_tuple,
    Substitution,
)
from launch.texts import InvalidLaunchFileError

add_prefix()  # the packages that a launch file's own imports look up, whoever runs it
import_by_file(
    {
        actions: ("DeclareLaunchArgument", "ExecuteLocal", "ExecuteProcess"),
        **dict.fromkeys((conditions, descriptions, event_handlers), ()),
        events: ("process",),
        launch_description_sources: ("InvalidLaunchFileError", "InvalidPythonLaunchFileError"),
        substitutions: ("SubstitutionFailure", "TextSubstitution"),
    }
)
import_as(
    "launch",
    {
        "condition": action,
        "event": event_handler,
        "frontend.entity": frontend,
        "frontend.expose": frontend,
        "frontend.parser": frontend,
        "invalid_launch_file_error": launch_description_source,
        "launch_description_entity": action,
        "some_actions_type": action,
        "some_entities_type": action,
        "some_substitutions_type": substitution,
        "utilities.type_utils": utilities,
    },
)
