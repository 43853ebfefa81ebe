"""`ros2 node`, `ros2 service`, `ros2 action` and `ros2 lifecycle`."""

from __future__ import annotations

import argparse

from bringup.ros2.grammar import GRAPH, Command, Verb, argument, switch

_NODE = argument("node_name", complete="node", help="full name of the node")
_HIDDEN_NODES = switch("--include-hidden-nodes", help="consider hidden nodes too")
_COUNT_NODES = switch("-c", "--count-nodes", help="only display the number of nodes")
_ALL_NODES = switch("-a", "--all", help="hidden nodes too")
NODE = Command(
    "node",
    "Various node related sub-commands",
    (
        Verb(
            "info",
            "Output information about a node",
            "node:info",
            (_NODE, switch("--include-hidden", help="hidden topics and services too"), *GRAPH),
        ),
        Verb(
            "list",
            "Output a list of available nodes",
            "node:list_nodes",
            (_ALL_NODES, _COUNT_NODES, *GRAPH),
        ),
    ),
)

_SERVICE = argument("service_name", complete="service", help="for example '/add_two_ints'")
_HIDDEN_SERVICES = switch(
    "--include-hidden-services", default=argparse.SUPPRESS, help="consider hidden services too"
)
_COUNT_SERVICES = switch("-c", "--count-services", help="only display the number of services")
SERVICE = Command(
    "service",
    "Various service related sub-commands",
    (
        Verb(
            "call",
            "Call a service",
            "service:call",
            (
                _SERVICE,
                argument("service_type", help="for example 'std_srvs/srv/Empty'"),
                (
                    argument("values", nargs="?", default="{}", help="the request as YAML"),
                    switch("--stdin", help="read the values from standard input"),
                ),
                argument("-r", "--rate", metavar="N", type=float, help="repeat at this rate in Hz"),
                *GRAPH,
            ),
        ),
        Verb(
            "find",
            "Output a list of services of a given type",
            "service:find",
            (
                argument("service_type", help="for example 'std_srvs/srv/Empty'"),
                _COUNT_SERVICES,
                _HIDDEN_SERVICES,
                *GRAPH,
            ),
        ),
        Verb("info", "Print information about a service", "service:info", (_SERVICE, *GRAPH)),
        Verb(
            "list",
            "Output a list of available services",
            "service:list_services",
            (
                switch("-t", "--show-types", help="show the types too"),
                _COUNT_SERVICES,
                _HIDDEN_SERVICES,
                *GRAPH,
            ),
        ),
        Verb("type", "Output a service's type", "service:type_of", (_SERVICE, *GRAPH)),
    ),
    (switch("--include-hidden-services", help="consider hidden services too"),),
)

_ACTION = argument("action_name", complete="action", help="for example '/navigate_to_pose'")
_TYPES = switch("-t", "--show-types", help="show the types too")
ACTION = Command(
    "action",
    "Various action related sub-commands",
    (
        Verb(
            "find",
            "Find actions from type",
            "action:find",
            (
                argument("action_type", help="for example 'nav2_msgs/action/Wait'"),
                switch("-c", "--count-actions", help="only display the number of actions"),
                *GRAPH,
            ),
        ),
        Verb(
            "info",
            "Print information about an action",
            "action:info",
            (_ACTION, _TYPES, switch("-c", "--count", help="only the numbers"), *GRAPH),
        ),
        Verb(
            "list",
            "Output a list of action names",
            "action:list_actions",
            (_TYPES, switch("-c", "--count-actions", help="only the number"), *GRAPH),
        ),
        Verb(
            "send_goal",
            "Send an action goal",
            "action:send_goal",
            (
                _ACTION,
                argument("action_type", help="for example 'nav2_msgs/action/NavigateToPose'"),
                (
                    argument("goal", nargs="?", default="{}", help="the goal as YAML"),
                    switch("--stdin", help="read the goal from standard input"),
                ),
                switch("-f", "--feedback", help="print feedback"),
                *GRAPH,
            ),
        ),
        Verb("type", "Print an action's type", "action:type_of", (_ACTION, *GRAPH)),
    ),
)

LIFECYCLE = Command(
    "lifecycle",
    "Various lifecycle related sub-commands",
    (
        Verb(
            "get",
            "Get lifecycle state for one or more nodes",
            "lifecycle:get",
            (
                argument("node_name", nargs="?", complete="node", help="all nodes if left out"),
                _HIDDEN_NODES,
                *GRAPH,
            ),
        ),
        Verb(
            "list",
            "Output a list of available transitions",
            "lifecycle:list_transitions",
            (_NODE, _HIDDEN_NODES, switch("-a", "--all", help="all transitions"), *GRAPH),
        ),
        Verb(
            "nodes",
            "Output a list of nodes with lifecycle",
            "lifecycle:nodes",
            (_ALL_NODES, _COUNT_NODES, *GRAPH),
        ),
        Verb(
            "set",
            "Trigger lifecycle state transition",
            "lifecycle:set_state",
            (
                _NODE,
                _HIDDEN_NODES,
                argument("transition", help="configure, activate, deactivate, cleanup, shutdown"),
                *GRAPH,
            ),
        ),
    ),
)
