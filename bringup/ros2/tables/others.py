"""`ros2 interface`, `ros2 pkg`, and the commands that forward all their words."""

from __future__ import annotations

from bringup.ros2.grammar import Command, Verb, argument, switch

_KINDS = (
    switch("-m", "--only-msgs", help="only messages"),
    switch("-s", "--only-srvs", help="only services"),
    switch("-a", "--only-actions", help="only actions"),
)
_TYPE = argument("type", complete="interface", help="for example 'std_msgs/msg/String'")
_PACKAGE = argument("package_name", complete="package", help="the package")
INTERFACE = Command(
    *("interface", "Show information about ROS interfaces"),
    (
        Verb("list", "List all interface types available", _KINDS),
        Verb(
            *("package", "Output a list of available interface types within one package"),
            (_PACKAGE, *_KINDS),
        ),
        Verb("packages", "Output a list of packages that provide interfaces", _KINDS),
        Verb(
            *("proto", "Output an interface prototype"),
            (_TYPE, switch("--no-quotes", help="without the quotes around it")),
        ),
        Verb(
            *("show", "Output the interface definition"),
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
PKG = Command(
    *("pkg", "Various package related sub-commands"),
    (
        Verb(
            *("create", "Create a new ROS 2 package"),
            (
                argument("package_name", help="its name"),
                argument(
                    "--build-type",
                    default="ament_python",
                    choices=["ament_python"],
                    help="what builds it",
                ),
                argument("--dependencies", nargs="+", default=[], help="packages that it needs"),
                argument("--node-name", help="a first node to write"),
                argument("--destination-directory", default=".", help="where to put it"),
                argument("--description", default="TODO: Package description", help="a sentence"),
                argument("--license", default="TODO: License declaration", help="its name"),
                argument("--maintainer-email", default="user@todo.todo", help="an address"),
                argument("--maintainer-name", default="user", help="a name"),
                argument("--package-format", default="3", choices=["2", "3"], help="3"),
            ),
        ),
        Verb(
            *("executables", "Output a list of package specific executables"),
            (argument("package_name", nargs="?", complete="package", help="the package"),),
        ),
        Verb("list", "Output a list of available packages"),
        Verb(
            *("prefix", "Output the prefix path of a package"),
            (_PACKAGE, switch("--share", help="the share folder")),
        ),
        Verb(
            *("xml", "Output the XML of the package manifest or a specific tag"),
            (_PACKAGE, argument("-t", "--tag", help="only this tag")),
        ),
    ),
)
DAEMON = Command("daemon", "There is no daemon: none is needed", forward="forward:daemon")
DOCTOR = Command("doctor", "Check the system for what goes wrong", forward="forward:doctor")
WTF = Command("wtf", "The same as 'ros2 doctor'", forward="forward:doctor")
LAUNCH = Command("launch", "Start what a known launch file starts", forward="launch:run")
RUN = Command("run", "Run a package specific executable", forward="forward:run")
