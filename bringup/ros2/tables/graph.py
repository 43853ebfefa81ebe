"""`ros2 node`, `ros2 service`, `ros2 action` and `ros2 lifecycle`."""

from __future__ import annotations

import argparse

from bringup.ros2.grammar import Command, Verb, argument, switch

_NODE = argument("node_name", complete="node", help="full name of the node")
_ANY_NODE = argument("node_name", nargs="?", complete="node", help="all nodes if left out")
_HIDDEN_NODES = switch("--include-hidden-nodes", help="consider hidden nodes too")
_LISTED_NODES = (
    switch("-a", "--all", help="hidden nodes too"),
    switch("-c", "--count-nodes", help="only display the number of nodes"),
)
NODE = Command(
    *("node", "Various node related sub-commands"),
    (
        Verb(
            *("info", "Output information about a node"),
            (_NODE, switch("--include-hidden", help="hidden topics and services too")),
        ),
        Verb("list", "Output a list of available nodes", _LISTED_NODES),
    ),
    graph=True,
)

_TYPES = switch("-t", "--show-types", help="show the types too")
_SERVICE = argument("service_name", complete="service", help="for example '/add_two_ints'")
_SERVICE_TYPE = argument("service_type", help="for example 'std_srvs/srv/Empty'")
_SERVICES = (
    switch("-c", "--count-services", help="only display the number of services"),
    switch(
        *("--include-hidden-services",),
        default=argparse.SUPPRESS,
        help="consider hidden services too",
    ),
)
SERVICE = Command(
    *("service", "Various service related sub-commands"),
    (
        Verb(
            *("call", "Call a service"),
            (
                _SERVICE,
                _SERVICE_TYPE,
                (
                    argument("values", nargs="?", default="{}", help="the request as YAML"),
                    switch("--stdin", help="read the values from standard input"),
                ),
                argument("-r", "--rate", metavar="N", type=float, help="repeat at this rate in Hz"),
            ),
            "send:call",
        ),
        Verb(
            *("find", "Output a list of services of a given type", (_SERVICE_TYPE, *_SERVICES)),
            "names:find",
        ),
        Verb("info", "Print information about a service", (_SERVICE,), "names:service_info"),
        Verb("list", "Output a list of available services", (_TYPES, *_SERVICES), "names:list_"),
        Verb("type", "Output a service's type", (_SERVICE,), "names:type_"),
    ),
    (switch("--include-hidden-services", help="consider hidden services too"),),
    graph=True,
)

_ACTION = argument("action_name", complete="action", help="for example '/navigate_to_pose'")
ACTION = Command(
    *("action", "Various action related sub-commands"),
    (
        Verb(
            *("find", "Find actions from type"),
            (
                argument("action_type", help="for example 'nav2_msgs/action/Wait'"),
                switch("-c", "--count-actions", help="only display the number of actions"),
            ),
            "names:find",
        ),
        Verb(
            *("info", "Print information about an action"),
            (_ACTION, _TYPES, switch("-c", "--count", help="only the numbers")),
            "names:action_info",
        ),
        Verb(
            *("list", "Output a list of action names"),
            (_TYPES, switch("-c", "--count-actions", help="only the number")),
            "names:list_",
        ),
        Verb(
            *("send_goal", "Send an action goal"),
            (
                _ACTION,
                argument("action_type", help="for example 'nav2_msgs/action/NavigateToPose'"),
                (
                    argument("goal", nargs="?", default="{}", help="the goal as YAML"),
                    switch("--stdin", help="read the goal from standard input"),
                ),
                switch("-f", "--feedback", help="print feedback"),
            ),
            "goal:send_goal",
        ),
        Verb("type", "Print an action's type", (_ACTION,), "names:type_"),
    ),
    graph=True,
)

LIFECYCLE = Command(
    *("lifecycle", "Various lifecycle related sub-commands"),
    (
        Verb(*("get", "Get lifecycle state for one or more nodes"), (_ANY_NODE, _HIDDEN_NODES)),
        Verb(
            *("list", "Output a list of available transitions"),
            (_NODE, _HIDDEN_NODES, switch("-a", "--all", help="all transitions")),
        ),
        Verb("nodes", "Output a list of nodes with lifecycle", _LISTED_NODES),
        Verb(
            *("set", "Trigger lifecycle state transition"),
            (
                _NODE,
                _HIDDEN_NODES,
                argument("transition", help="configure, activate, deactivate, cleanup, shutdown"),
            ),
        ),
    ),
    graph=True,
)

_PARAMETER = argument("parameter_name", help="name of the parameter")
_OF_NODES = (
    _HIDDEN_NODES,
    argument("--timeout", metavar="N", type=float, default=10.0, help="wait N seconds (10)"),
)
PARAM = Command(
    *("param", "Various param related sub-commands"),
    (
        Verb("delete", "Delete parameter", (_NODE, _PARAMETER, *_OF_NODES)),
        Verb(
            *("describe", "Show descriptive information about declared parameters"),
            (_NODE, argument("parameter_names", nargs="+", help="their names"), *_OF_NODES),
        ),
        Verb(
            *("dump", "Show all of the parameters of a node in a YAML file format"),
            (_NODE, *_OF_NODES),
        ),
        Verb(
            *("get", "Get parameter"),
            (_NODE, _PARAMETER, switch("--hide-type", help="only the value"), *_OF_NODES),
        ),
        Verb(
            *("list", "Output a list of available parameters"),
            (
                _ANY_NODE,
                argument("--param-prefixes", nargs="+", default=[], help="only these prefixes"),
                switch("--param-type", help="show the types too"),
                argument("--filter", metavar="REGEX", help="only names that begin so"),
                *_OF_NODES,
            ),
        ),
        Verb(
            *("load", "Load parameter file for a node"),
            (
                _NODE,
                argument("parameter_file", help="as 'ros2 param dump' writes it"),
                switch("--no-use-wildcard", help="leave out what stands under '/**'"),
                *_OF_NODES,
            ),
        ),
        Verb(
            *("set", "Set parameter"),
            (_NODE, _PARAMETER, argument("value", help="the value as YAML"), *_OF_NODES),
        ),
    ),
    graph=True,
)
