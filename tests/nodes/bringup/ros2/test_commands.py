"""What the commands print and how they end, on the stand-in's graph; numbers are masked."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from tests.helpers.ros2.commands import Outcome

pytestmark = pytest.mark.ros
Run = Callable[..., Outcome]

TWIST = (
    "geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=#, y=#, z=#),"
    " angular=geometry_msgs.msg.Vector3(x=#, y=#, z=#))"
)
GOAL = ("action", "send_goal", "/wait", "nav2_msgs/action/Wait")
WAITING = ("waiting for at least", "waiting for service", "a message was lost", "\ttotal count")
INDENT = re.compile(r"^ {8}", re.MULTILINE)  # of the texts below
CASES: dict[str, tuple[str, str]] = {
    "topic list": (
        "topic list",
        """\
        /chatter
        /cmd_vel
        /latched
        /parameter_events
        /point
        /rosout
        /stand_in/transition_event
        /tf_static
        """,
    ),
    "topic list with types": (
        "topic list -t -a",
        """\
        /_hidden [std_msgs/msg/String]
        /chatter [std_msgs/msg/String]
        /cmd_vel [geometry_msgs/msg/Twist]
        /latched [std_msgs/msg/String]
        /parameter_events [rcl_interfaces/msg/ParameterEvent]
        /point [geometry_msgs/msg/PointStamped]
        /rosout [rcl_interfaces/msg/Log]
        /stand_in/transition_event [lifecycle_msgs/msg/TransitionEvent]
        /tf_static [tf2_msgs/msg/TFMessage]
        /wait/_action/feedback [nav2_msgs/action/Wait_FeedbackMessage]
        /wait/_action/status [action_msgs/msg/GoalStatusArray]
        """,
    ),
    "topic count": ("topic list -c", "#\n"),
    "topic list verbose": (
        "topic list -v",
        """\
        Published topics:
         * /chatter [std_msgs/msg/String] # publisher
         * /latched [std_msgs/msg/String] # publisher
         * /parameter_events [rcl_interfaces/msg/ParameterEvent] # publishers
         * /point [geometry_msgs/msg/PointStamped] # publisher
         * /rosout [rcl_interfaces/msg/Log] # publishers
         * /stand_in/transition_event [lifecycle_msgs/msg/TransitionEvent] # publisher
         * /tf_static [tf2_msgs/msg/TFMessage] # publisher

        Subscribed topics:
         * /cmd_vel [geometry_msgs/msg/Twist] # subscriber

        """,
    ),
    "topic type": ("topic type /chatter", "std_msgs/msg/String\n"),
    "topic find": ("topic find std_msgs/msg/String", "/chatter\n/latched\n"),
    "topic find count": ("topic find -c std_msgs/msg/String", "#\n"),
    "topic info": (
        "topic info /chatter",
        "Type: std_msgs/msg/String\nPublisher count: #\nSubscription count: #\n",
    ),
    "topic info verbose": (
        "topic info -v /cmd_vel",
        """\
        Type: geometry_msgs/msg/Twist

        Publisher count: #

        Subscription count: #

        Node name: stand_in
        Node namespace: /
        Topic type: geometry_msgs/msg/Twist
        Topic type hash: HASH
        Endpoint type: SUBSCRIPTION
        GID: GID
        QoS profile:
          Reliability: RELIABLE
          History (Depth): UNKNOWN
          Durability: VOLATILE
          Lifespan: Infinite
          Deadline: Infinite
          Liveliness: AUTOMATIC
          Liveliness lease duration: Infinite

        """,
    ),
    "topic echo": ("topic echo --once /chatter", "data: hello #\n---\n"),
    "topic echo of a latched topic": ("topic echo --once latched", "data: kept\n---\n"),
    "topic echo field": ("topic echo --once /point --field header.frame_id", "map\n---\n"),
    "topic echo csv": ("topic echo --once /point --csv", "#,#,map,#,#,#\n"),
    "topic echo flow": ("topic echo --once /chatter --flow-style", "{data: hello #}\n---\n"),
    "topic echo filter": (
        "topic echo --once /chatter --filter m.data[0]=='h'",
        "data: hello #\n---\n",
    ),
    "topic echo no strings": (
        "topic echo --once /chatter --no-str",
        "data: '<string length: <#>>'\n---\n",
    ),
    "topic echo no arrays": (
        "topic echo --once /tf_static --no-arr",
        "transforms: '<sequence type: geometry_msgs/msg/TransformStamped, length: #>'\n---\n",
    ),
    "topic echo that hears nothing": ("topic echo /cmd_vel --timeout 0.2", ""),
    "topic pub": (
        "topic pub -t 2 -r 50 /cmd_vel geometry_msgs/msg/Twist {linear:{x:0.5}}",
        f"publisher: beginning loop\npublishing ##: {TWIST}\n\npublishing ##: {TWIST}\n\n",
    ),
    "node list": ("node list", "/stand_in\n"),
    "node count": ("node list -c", "#\n"),
    "service find": ("service find std_srvs/srv/SetBool", "/toggle\n"),
    "service type": ("service type /toggle", "std_srvs/srv/SetBool\n"),
    "service info": (
        "service info /toggle",
        "Type: std_srvs/srv/SetBool\nClients count: #\nServices count: #\n",
    ),
    "service call": (
        "service call /toggle std_srvs/srv/SetBool {data:true}",
        """\
        requester: making request: std_srvs.srv.SetBool_Request(data=True)

        response:
        std_srvs.srv.SetBool_Response(success=True, message='done')

        """,
    ),
    "action list": ("action list", "/wait\n"),
    "action list with types": ("action list -t", "/wait [nav2_msgs/action/Wait]\n"),
    "action type": ("action type /wait", "nav2_msgs/action/Wait\n"),
    "action find": ("action find nav2_msgs/action/Wait", "/wait\n"),
    "action info": (
        "action info -t /wait",
        """\
        Action: /wait
        Action clients: #
        Action servers: #
            /stand_in [nav2_msgs/action/Wait]
        """,
    ),
    "action send_goal": (
        "action send_goal /wait nav2_msgs/action/Wait {time:{sec:3}} --feedback",
        """\
        Waiting for an action server to become available...
        Sending goal:
             time:
          sec: #
          nanosec: #

        Goal accepted with ID: ID

        Feedback:
            time_left:
          sec: #
          nanosec: #

        Result:
            total_elapsed_time:
          sec: #
          nanosec: #
        error_code: #
        error_msg: ''

        Goal finished with status: SUCCEEDED
        """,
    ),
    "action send_goal rejected": (
        "action send_goal /wait nav2_msgs/action/Wait {time:{sec:7}}",
        """\
        Waiting for an action server to become available...
        Sending goal:
             time:
          sec: #
          nanosec: #

        Goal was rejected.
        """,
    ),
    "param list": (
        "param list /stand_in",
        """\
          gain
          group.names
          size
          start_type_description_service
          use_sim_time
        """,
    ),
    "param list of all with types": (
        "param list --param-type --filter ^g",
        """\
        /stand_in:
          gain (type: double)
          group.names (type: string array)
        """,
    ),
    "param get": ("param get /stand_in size", "Integer value is: #\n"),
    "param get of several": (
        "param get stand_in group.names",
        "String values are: ['a', 'b']\n",
    ),
    "param get hidden type": ("param get --hide-type /stand_in size", "#\n"),
    "param set": ("param set /stand_in gain 2.5", "Set parameter successful\n"),
    "param describe": (
        "param describe /stand_in gain size",
        """\
        Parameter name: gain
          Type: double
          Description: Factor.
          Constraints:
            Min value: #
            Max value: #
        Parameter name: size
          Type: integer
          Constraints:
            Read only: true
        """,
    ),
    "param dump": (
        "param dump /stand_in",
        """\
        /stand_in:
          ros__parameters:
            gain: #
            group:
              names:
              - a
              - b
            size: #
            start_type_description_service: true
            use_sim_time: false

        """,
    ),
    "lifecycle nodes": ("lifecycle nodes", "/stand_in\n"),
    "lifecycle get": ("lifecycle get /stand_in", "unconfigured [#]\n"),
    "lifecycle get of all": ("lifecycle get", "/stand_in: unconfigured [#]\n"),
    "lifecycle list": (
        "lifecycle list /stand_in",
        """\
        - configure [#]
        \tStart: unconfigured
        \tGoal: configuring
        - shutdown [#]
        \tStart: unconfigured
        \tGoal: shuttingdown
        """,
    ),
    "tf2_echo": (
        "run tf2_ros tf2_echo map base --once",
        """\
        At time #
        - Translation: [#, #, #]
        - Rotation: in Quaternion (xyzw) [#, #, #, #]
        - Rotation: in RPY (radian) [#, #, #]
        - Rotation: in RPY (degree) [#, #, #]
        - Matrix:
          #  #  #  #
          #  #  #  #
          #  #  #  #
          #  #  #  #
        """,
    ),
}


def words_of(line: str) -> list[str]:
    """Split a line; colons in braces get the space that YAML wants."""
    return [re.sub(r":(?=\S)", ": ", word) if word[0] == "{" else word for word in line.split()]


def masked(text: str) -> str:
    """Replace what differs from run to run."""
    text = re.sub(r"(?<=with ID: )[0-9a-f]{32}", "ID", text)
    text = re.sub(r"RIHS01_[0-9a-f]{64}", "HASH", text)
    text = re.sub(r"(?<=GID: )[0-9a-f.]+", "GID", text)
    text = re.sub(r"(?<= ) *-?\d+\.\d{3}(?=[ \n])", lambda m: m[0].replace("-", " "), text)
    return re.sub(r"(?<![\w/])-?\d+(\.\d+)?", "#", text)


@pytest.mark.parametrize("case", CASES)
def test_prints_what_ros2cli_prints(case: str, ros2: Run) -> None:
    line, expected = CASES[case]
    code, out, err = ros2(*words_of(line))
    assert code == 0
    assert [text for text in err.splitlines() if not text.startswith("[INFO]")] == []
    lines = masked(out).splitlines(keepends=True)
    printed = "".join(line for line in lines if not line.lower().startswith(WAITING))
    assert printed == masked(INDENT.sub("", expected))


FAILURES: dict[str, tuple[str, str]] = {
    "topic type /nope": ("", ""),
    "service type /nope": ("", ""),
    "action type /nope": ("", ""),
    "topic info /nope": ("", "Unknown topic '/nope'\n"),
    "service info /nope": ("", "Unknown service '/nope'\n"),
    "node info /nope": ("", "Unable to find node '/nope'\n"),
    "param get /nope gain": ("", "Node not found\n"),
    "param get /stand_in nope": ("", "Parameter not set\n"),
    "lifecycle get /nope": ("", "Node not found\n"),
    "lifecycle set /stand_in fly": (
        "",
        "Unknown transition requested, available ones are:\n- configure [1]\n- shutdown [5]\n",
    ),
    "topic echo /nope": (
        "WARNING: topic [/nope] does not appear to be published yet\n",
        "Could not determine the type for the passed topic\n",
    ),
    "topic echo /chatter --once --field data.nope": (
        "",
        "Invalid field 'data.nope': no 'nope'\n",
    ),
    "topic pub -1 /x std_msgs/msg/Nope": ("", "The passed message type is invalid\n"),
    "topic pub -1 /x std_msgs/msg/String {nope:1}": (
        "",
        "Failed to populate field: 'String' object has no attribute 'nope'\n",
    ),
    "topic pub -1 /x std_msgs/msg/String text": (
        "",
        "The passed value needs to be a dictionary in YAML format\n",
    ),
    "service call /x std_srvs/srv/Nope": ("", "The passed service type is invalid\n"),
    "action send_goal /x nav2_msgs/action/Nope {}": ("", "The passed action type is invalid\n"),
}


@pytest.mark.parametrize("line", FAILURES)
def test_fails_as_ros2cli_fails(line: str, ros2: Run) -> None:
    assert ros2(*words_of(line)) == (1, *FAILURES[line])


def test_a_refused_parameter_is_said_on_the_error_stream(ros2: Run) -> None:
    code, out, err = ros2("param", "set", "/stand_in", "gain", "99.0")
    assert (code, out) == (0, "")
    assert err.startswith("Setting parameter failed: Parameter gain out of range")


def test_a_node_s_interfaces_are_under_their_titles(ros2: Run) -> None:
    lines = ros2("node", "info", "/stand_in").out.splitlines()
    titles = ("Subscribers", "Publishers", "Service Servers", "Service Clients")
    expected = ["/stand_in", *(f"  {title}:" for title in titles)]
    expected += ["  Action Servers:", "  Action Clients:"]
    assert [line for line in lines if not line.startswith("    ") and line] == expected
    assert lines[lines.index("  Action Servers:") + 1] == "    /wait: nav2_msgs/action/Wait"
    assert "    /toggle: std_srvs/srv/SetBool" in lines
    assert lines[lines.index("  Service Clients:") + 1] == ""


def test_a_dump_loads_again(ros2: Run, tmp_path: Path) -> None:
    file = tmp_path / "dump.yaml"
    file.write_text(ros2("param", "dump", "/stand_in").out.replace("gain: 2.5", "gain: 1.25"))
    code, out, err = ros2("param", "load", "/stand_in", str(file))
    assert code == 0
    assert "Set parameter gain successful\n" in out
    assert "Set parameter size failed" in err
    assert ros2("param", "get", "/stand_in", "gain").out == "Double value is: 1.25\n"
    ros2("param", "set", "/stand_in", "gain", "2.5")


def test_service_list_has_what_the_node_serves(ros2: Run) -> None:
    assert "/toggle [std_srvs/srv/SetBool]" in ros2("service", "list", "-t").out.splitlines()
