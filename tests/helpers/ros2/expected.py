"""What ros2cli prints on the stand-in's graph, numbers masked: name, words, output."""

from __future__ import annotations

TWIST = (
    "geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=#, y=#, z=#),"
    " angular=geometry_msgs.msg.Vector3(x=#, y=#, z=#))"
)
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
    "topic echo flow": ("topic echo --once /chatter --flow-style", "data: hello #\n---\n"),
    "topic echo csv with times": ("topic echo --once -i /chatter --csv", "#,#,#,None,hello #\n"),
    "topic echo times": (
        "topic echo --once -i /chatter",
        """\
        publication_sequence_number: #
        received_timestamp: #
        reception_sequence_number: null
        source_timestamp: #
        ---
        data: hello #
        ---
        """,
    ),
    "topic echo times of a field": (
        "topic echo --once -i /chatter --field data",
        """\
        ---Got new message, message info:---
        {'source_timestamp': #, 'received_timestamp': #, 'publication_sequence_number': #, 'reception_sequence_number': None}
        ---Message data:---
        hello #
        ---
        """,  # noqa: E501 - as it is printed
    ),
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
        "param list --param-type --filter g",
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
        "run tf2_ros tf2_echo map base --once --ros-args -p use_sim_time:=true",
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
