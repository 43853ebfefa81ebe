from typing import List, Optional

import launch
from launch import LaunchDescription, LaunchIntrospector, SomeSubstitutionsType
from launch.action import Action
from launch.actions import ExecuteLocal, ExecuteProcess, LogInfo, RegisterEventHandler
from launch.descriptions import Executable
from launch.event_handlers import OnProcessExit, OnProcessIO
from launch.events.process import ProcessIO
from launch.frontend import Entity, Parser, expose_action
from launch.launch_context import LaunchContext
from launch.launch_description_entity import LaunchDescriptionEntity
from launch.some_entities_type import SomeEntitiesType
from launch.utilities import normalize_to_list_of_substitutions, perform_substitutions


@expose_action('say')
class Say(Action):
    def __init__(self, *, what: SomeSubstitutionsType, **kwargs) -> None:
        super().__init__(**kwargs)
        self.__what = normalize_to_list_of_substitutions(what)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser):
        _, kwargs = super().parse(entity, parser)
        kwargs['what'] = parser.parse_substitution(entity.get_attr('what'))
        return cls, kwargs

    def execute(self, context: LaunchContext) -> Optional[List[LaunchDescriptionEntity]]:
        return [LogInfo(msg='said ' + perform_substitutions(context, self.__what))]


class After(Action):
    def __init__(self, *, target: ExecuteProcess, then: SomeEntitiesType, **kwargs) -> None:
        super().__init__(**kwargs)
        self.__target = target
        self.__then = then

    def get_sub_entities(self) -> List[LaunchDescriptionEntity]:
        return list(self.__then)

    def execute(self, context: LaunchContext) -> None:
        context.register_event_handler(
            OnProcessExit(target_action=self.__target, on_exit=self.__then)
        )


def on_matching_output(matcher: str, result: launch.SomeActionsType):
    def on_output(event: ProcessIO):
        for line in event.text.decode().splitlines():
            if matcher in line:
                return result

    return on_output


def generate_launch_description():
    program = Executable(cmd=['talk'], arguments=['--loud'], name='talker', prefix='nice -n 5')
    talk = ExecuteLocal(process_description=program, output='screen')
    ready = on_matching_output('ready', [LogInfo(msg='ready')])
    ld = LaunchDescription([
        RegisterEventHandler(OnProcessIO(target_action=talk, on_stdout=ready)),
        Say(what=['a', 'b']),
        After(target=talk, then=[LogInfo(msg='after talk')]),
        talk,
    ])
    print(LaunchIntrospector().format_launch_description(ld))
    return ld
