"""`ros2 param`, `ros2 interface`, `ros2 pkg`, and the commands that forward all their words."""

from __future__ import annotations

from bringup.ros2.grammar import GRAPH, Command, Verb, argument, switch

_NODE = argument("node_name", complete="node", help="full name of the node")
_PARAMETER = argument("parameter_name", help="name of the parameter")
_NODES = (
    switch("--include-hidden-nodes", help="consider hidden nodes too"),
    argument("--timeout", metavar="N", type=float, default=10.0, help="wait N seconds (10)"),
    *GRAPH,
)
PARAM = Command(
    "param",
    "Various param related sub-commands",
    (
        Verb("delete", "Delete parameter", "param:delete", (_NODE, _PARAMETER, *_NODES)),
        Verb(
            "describe",
            "Show descriptive information about declared parameters",
            "param:describe",
            (_NODE, argument("parameter_names", nargs="+", help="their names"), *_NODES),
        ),
        Verb(
            "dump",
            "Show all of the parameters of a node in a YAML file format",
            "param_files:dump",
            (_NODE, *_NODES),
        ),
        Verb(
            "get",
            "Get parameter",
            "param:get",
            (_NODE, _PARAMETER, switch("--hide-type", help="only the value"), *_NODES),
        ),
        Verb(
            "list",
            "Output a list of available parameters",
            "param:list_parameters",
            (
                argument("node_name", nargs="?", complete="node", help="all nodes if left out"),
                argument("--param-prefixes", nargs="+", default=[], help="only these prefixes"),
                switch("--param-type", help="show the types too"),
                argument("--filter", metavar="REGEX", help="only names that begin so"),
                *_NODES,
            ),
        ),
        Verb(
            "load",
            "Load parameter file for a node",
            "param_files:load",
            (
                _NODE,
                argument("parameter_file", help="as 'ros2 param dump' writes it"),
                switch("--no-use-wildcard", help="leave out what stands under '/**'"),
                *_NODES,
            ),
        ),
        Verb(
            "set",
            "Set parameter",
            "param:set_parameter",
            (_NODE, _PARAMETER, argument("value", help="the value as YAML"), *_NODES),
        ),
    ),
)

_KINDS = (
    switch("-m", "--only-msgs", help="only messages"),
    switch("-s", "--only-srvs", help="only services"),
    switch("-a", "--only-actions", help="only actions"),
)
_TYPE = argument("type", complete="interface", help="for example 'std_msgs/msg/String'")
INTERFACE = Command(
    "interface",
    "Show information about ROS interfaces",
    (
        Verb("list", "List all interface types available", "interface:list_types", _KINDS),
        Verb(
            "package",
            "Output a list of available interface types within one package",
            "interface:package",
            (argument("package_name", complete="package", help="the package"), *_KINDS),
        ),
        Verb(
            "packages",
            "Output a list of packages that provide interfaces",
            "interface:packages",
            _KINDS,
        ),
        Verb(
            "proto",
            "Output an interface prototype",
            "interface:proto",
            (_TYPE, switch("--no-quotes", help="without the quotes around it")),
        ),
        Verb(
            "show",
            "Output the interface definition",
            "interface:show",
            (
                _TYPE,
                (
                    switch("--all-comments", help="those of nested types too"),
                    switch("--no-comments", help="neither comments nor empty lines"),
                ),
            ),
        ),
    ),
)

_PACKAGE = argument("package_name", complete="package", help="the package")
PKG = Command(
    "pkg",
    "Various package related sub-commands",
    (
        Verb(
            "executables",
            "Output a list of package specific executables",
            "pkg:executables",
            (argument("package_name", nargs="?", complete="package", help="the package"),),
        ),
        Verb("list", "Output a list of available packages", "pkg:list_packages"),
        Verb(
            "prefix",
            "Output the prefix path of a package",
            "pkg:prefix",
            (_PACKAGE, switch("--share", help="the share folder")),
        ),
        Verb(
            "xml",
            "Output the XML of the package manifest or a specific tag",
            "pkg:xml",
            (_PACKAGE, argument("-t", "--tag", help="only this tag")),
        ),
    ),
)
BAG = Command("bag", "Record, play and describe recordings", forward="forward:bag")
DAEMON = Command("daemon", "There is no daemon: none is needed", forward="forward:daemon")
DOCTOR = Command("doctor", "Check the system for what goes wrong", forward="forward:doctor")
WTF = Command("wtf", "The same as 'ros2 doctor'", forward="forward:doctor")
LAUNCH = Command("launch", "Start what a known launch file starts", forward="launch:run")
RUN = Command("run", "Run a package specific executable", forward="forward:run")
