import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import LoadComposableNodes, Node, SetParameter
from launch_ros.descriptions import ComposableNode, ParameterFile
from nav2_common.launch import RewrittenYaml


def generate_launch_description():
    bringup_dir = get_package_share_directory('nav2_bringup')
    namespace = LaunchConfiguration('namespace')
    use_sim_time = LaunchConfiguration('use_sim_time')
    autostart = LaunchConfiguration('autostart')
    params_file = LaunchConfiguration('params_file')
    use_composition = LaunchConfiguration('use_composition')
    use_respawn = LaunchConfiguration('use_respawn')
    log_level = LaunchConfiguration('log_level')
    lifecycle_nodes = ['controller_server', 'planner_server', 'behavior_server', 'bt_navigator']
    remappings = [('/tf', 'tf'), ('/tf_static', 'tf_static')]
    configured_params = ParameterFile(
        RewrittenYaml(source_file=params_file, root_key=namespace,
                      param_rewrites={'autostart': autostart}, convert_types=True),
        allow_substs=True)
    common = {'output': 'screen', 'respawn': use_respawn, 'respawn_delay': 2.0,
              'parameters': [configured_params], 'arguments': ['--ros-args', '--log-level',
                                                               log_level]}
    load_nodes = GroupAction(
        condition=IfCondition(PythonExpression(['not ', use_composition])),
        actions=[
            SetParameter('use_sim_time', use_sim_time),
            Node(package='nav2_controller', executable='controller_server',
                 remappings=remappings + [('cmd_vel', 'cmd_vel_nav')], **common),
            Node(package='nav2_planner', executable='planner_server', name='planner_server',
                 remappings=remappings, **common),
            Node(package='nav2_behaviors', executable='behavior_server', name='behavior_server',
                 remappings=remappings, **common),
            Node(package='nav2_bt_navigator', executable='bt_navigator', name='bt_navigator',
                 remappings=remappings, **common),
            Node(package='nav2_lifecycle_manager', executable='lifecycle_manager',
                 name='lifecycle_manager_navigation', output='screen',
                 parameters=[{'autostart': autostart}, {'node_names': lifecycle_nodes}]),
        ])
    load_composable_nodes = GroupAction(
        condition=IfCondition(use_composition),
        actions=[
            SetParameter('use_sim_time', use_sim_time),
            LoadComposableNodes(
                target_container=(namespace, '/', 'nav2_container'),
                composable_node_descriptions=[
                    ComposableNode(package='nav2_controller',
                                   plugin='nav2_controller::ControllerServer',
                                   name='controller_server', parameters=[configured_params],
                                   remappings=remappings),
                    ComposableNode(package='nav2_planner',
                                   plugin='nav2_planner::PlannerServer', name='planner_server',
                                   parameters=[configured_params]),
                ]),
        ])
    return LaunchDescription([
        SetEnvironmentVariable('RCUTILS_LOGGING_BUFFERED_STREAM', '1'),
        DeclareLaunchArgument('namespace', default_value=''),
        DeclareLaunchArgument('use_sim_time', default_value='false'),
        DeclareLaunchArgument('params_file', default_value=os.path.join(
            bringup_dir, 'params', 'nav2_params.yaml')),
        DeclareLaunchArgument('autostart', default_value='true'),
        DeclareLaunchArgument('use_composition', default_value='False'),
        DeclareLaunchArgument('use_respawn', default_value='False'),
        DeclareLaunchArgument('log_level', default_value='info'),
        load_nodes,
        load_composable_nodes,
    ])
