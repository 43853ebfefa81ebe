"""rosbag2_py: what scripts write is read by others' readers, and vice versa."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path

import pytest
import rosbag2_py
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from rosbag2_py import ReadOrder, ReadOrderSortBy, StorageFilter, StorageOptions
from rosbags import rosbag2
from rosbags.interfaces import ConnectionExtRosbag2
from std_msgs.msg import String

KIND = "std_msgs/msg/String"
SECOND = 1_000_000_000
OPTIONS = rosbag2_py.ConverterOptions("cdr", "cdr")


def write(folder: Path, writer: rosbag2_py.SequentialWriter, **options: object) -> Path:
    """Write ten words, a second each, on two topics by turns."""
    storage = StorageOptions(uri=str(folder), **options)  # type: ignore[arg-type]
    writer.open(storage, OPTIONS)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    for number, name in enumerate(("/even", "/odd")):
        topic = rosbag2_py.TopicMetadata(number, name, KIND, "cdr", [latched])
        writer.create_topic(topic)
    for number in range(10):
        name, data = ("/even", "/odd")[number % 2], serialize_message(String(data=str(number)))
        writer.write(name, data, number * SECOND)
    writer.close()
    return folder


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("mode", ["NONE", "FILE", "MESSAGE"])
def test_what_is_written_is_read_by_both(tmp_path: Path, storage: str, mode: str) -> None:
    compression = rosbag2_py.CompressionOptions(
        "zstd", rosbag2_py.compression_mode_from_string(mode)
    )
    writer = rosbag2_py.SequentialCompressionWriter(compression)
    folder = write(tmp_path / "bag", writer, storage_id=storage)
    with rosbag2.Reader(folder) as theirs:
        expected = [(each.topic, bytes(data), time) for each, time, data in theirs.messages()]
    reader = rosbag2_py.SequentialReader()
    reader.open_uri(str(folder))
    found = []
    while reader.has_next():
        found.append(reader.read_next())
    assert found == expected
    assert [deserialize_message(data, String).data for _, data, _ in found] == list("0123456789")
    with pytest.raises(RuntimeError, match="No next message"):
        reader.read_next()


def test_a_recording_is_described(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", rosbag2_py.SequentialWriter(), custom_data={"site": "lab"})
    (folder / "metadata.yaml").unlink()
    rosbag2_py.Reindexer().reindex(StorageOptions(str(folder)))
    metadata = rosbag2_py.Info().read_metadata(str(folder), "mcap")
    assert (metadata.message_count, metadata.duration.nanoseconds) == (10, 9 * SECOND)
    assert metadata.storage_identifier == "mcap"
    assert [each.message_count for each in metadata.topics_with_message_count] == [5, 5]
    assert "Messages:          10" in str(metadata)
    reader = rosbag2_py.SequentialReader()
    reader.open(StorageOptions(str(folder)), OPTIONS)
    (topic, _) = reader.get_all_topics_and_types()
    assert (topic.name, topic.type, topic.serialization_format) == ("/even", KIND, "cdr")
    profile = rosbag2_py.convert_rclcpp_qos_to_rclpy_qos(topic.offered_qos_profiles[0])
    assert profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    (definition,) = reader.get_all_message_definitions()
    assert definition.encoded_message_definition.rstrip().endswith("string data")


def test_topics_times_and_order_are_chosen(tmp_path: Path) -> None:
    reader = rosbag2_py.SequentialReader()
    reader.open(
        StorageOptions(str(write(tmp_path / "bag", rosbag2_py.SequentialWriter()))), OPTIONS
    )

    def times() -> list[int]:
        found = []
        while reader.has_next():
            found.append(reader.read_next()[2] // SECOND)
        return found

    reader.set_filter(StorageFilter(topics=["/odd"]))
    reader.seek(4 * SECOND)
    assert times() == [5, 7, 9]
    assert reader.set_read_order(ReadOrder(reverse=True))
    assert times() == [9, 7, 5, 3, 1]
    reader.seek(4 * SECOND)
    assert times() == [3, 1]
    assert not reader.set_read_order(ReadOrder(ReadOrderSortBy.File))
    reader.reset_filter()
    reader.seek(2 * SECOND)
    assert times() == [2, 1, 0]


def test_mistakes_are_runtime_errors(tmp_path: Path) -> None:
    writer = rosbag2_py.SequentialWriter()
    with pytest.raises(RuntimeError, match="Call open"):
        writer.write("/even", b"", 0)
    write(tmp_path / "bag", writer)
    with pytest.raises(RuntimeError, match="exists already"):
        writer.open(StorageOptions(str(tmp_path / "bag")), OPTIONS)
    writer.open(StorageOptions(str(tmp_path / "other")), OPTIONS)
    with pytest.raises(RuntimeError, match="has not been created yet"):
        writer.write("/even", b"", 0)
    with pytest.raises(RuntimeError, match="does not exist"):
        rosbag2_py.SequentialReader().open_uri(str(tmp_path / "none"))


def test_a_script_that_closes_nothing_leaves_a_whole_recording(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import rosbag2_py\n"
        "writer = rosbag2_py.SequentialWriter()\n"
        "writer.open(rosbag2_py.StorageOptions('bag', 'sqlite3'),"
        " rosbag2_py.ConverterOptions('', ''))\n"
        f"writer.create_topic(rosbag2_py.TopicMetadata(name='/a', type='{KIND}',"
        " serialization_format='cdr'))\n"
        "writer.write('/a', b'\\0\\1\\0\\0\\1\\0\\0\\0\\0', 5)\n"
    )
    subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True)
    with rosbag2.Reader(tmp_path / "bag") as reader:
        assert [(each.topic, time) for each, time, _ in reader.messages()] == [("/a", 5)]


def test_recorder_records_what_the_player_plays(tmp_path: Path) -> None:
    """Both in threads, as scripts have them; `cancel` ends them."""
    words = write(tmp_path / "words", rosbag2_py.SequentialWriter())
    chosen = rosbag2_py.RecordOptions(
        topics=["heard/even", "/odd"],
        topic_polling_interval=timedelta(milliseconds=10),
        disable_keyboard_controls=True,
    )
    storage = StorageOptions(str(tmp_path / "heard"), "mcap")
    recorder = rosbag2_py.Recorder("error")
    recording = threading.Thread(target=recorder.record, args=(storage, chosen, "ears"))
    recording.start()
    played = rosbag2_py.PlayOptions(
        rate=5.0,
        delay=2.0,
        topic_remapping_options=["even:=heard/even"],
        exclude_topics_to_filter=["odd"],
        playback_duration=7.0,
        wait_acked_timeout=1000,
        disable_keyboard_controls=True,
    )
    rosbag2_py.Player("error").play(StorageOptions(str(words)), played)
    threading.Event().wait(0.5)  # until the last message is through
    rosbag2_py.Recorder.cancel()
    recording.join(20.0)
    assert not recording.is_alive()
    reader = rosbag2_py.SequentialReader()
    reader.open_uri(storage.uri)
    found = []
    while reader.has_next():
        found.append(reader.read_next()[:2])
    texts = [(topic, deserialize_message(data, String).data) for topic, data in found]
    assert texts == [("/heard/even", word) for word in "0246"]


INTERRUPTED = """
import os, signal, sys, threading
import rclpy, rosbag2_py
from rclpy.executors import ExternalShutdownException
from rosbag2_py import PlayOptions, StorageOptions

rclpy.init()
node = rclpy.create_node("plays")
interrupt = threading.Timer(2.0, os.kill, (os.getpid(), signal.SIGINT))
try:
    if sys.argv[3] == "during":
        fast = PlayOptions(rate=1000.0, disable_keyboard_controls=True)
        rosbag2_py.Player().play(StorageOptions(uri=sys.argv[1]), fast)  # all is imported then
        interrupt.start()
    options = PlayOptions(rate=float(sys.argv[2]), disable_keyboard_controls=True)
    rosbag2_py.Player().play(StorageOptions(uri=sys.argv[1]), options)
    print("played")
    interrupt.start()
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    print("ended")
"""


@pytest.mark.parametrize(
    ("rate", "when", "said"),
    [("1000.0", "after", ["played", "ended"]), ("0.1", "during", ["ended"])],
)
def test_ctrl_c_ends_a_program_that_plays_or_has_played(
    tmp_path: Path, rate: str, when: str, said: list[str]
) -> None:
    folder = write(tmp_path / "bag", rosbag2_py.SequentialWriter())
    command = [sys.executable, "-c", INTERRUPTED, str(folder), rate, when]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert [line for line in done.stdout.splitlines() if line in ("played", "ended")] == said


def test_player_bursts_and_recordings_that_are_none_are_refused(tmp_path: Path) -> None:
    words = write(tmp_path / "words", rosbag2_py.SequentialWriter())
    options = rosbag2_py.PlayOptions(disable_keyboard_controls=True, topics_to_filter=["no"])
    player = rosbag2_py.Player("error")
    with pytest.raises(RuntimeError, match="nothing is left to play"):
        player.burst([StorageOptions(str(words))], options, 3)
    with pytest.raises(RuntimeError, match="does not exist"):
        player.play(StorageOptions(str(tmp_path / "none")), options)
    chosen = rosbag2_py.RecordOptions(all_topics=True)
    with pytest.raises(RuntimeError, match="exists"):
        rosbag2_py.Recorder("error").record(StorageOptions(str(words)), chosen)


def _described(folder: Path) -> list[tuple[str, int, str, str, int]]:
    """Return what others read of a recording: its topics, and the first offer of each."""
    with rosbag2.Reader(folder) as theirs:
        found = [(each, each.ext) for each in theirs.connections]
    offers = [
        (each, ext.offered_qos_profiles[0])
        for each, ext in found
        if isinstance(ext, ConnectionExtRosbag2)
    ]
    return [
        (each.topic, each.msgcount, offer.reliability.name, offer.durability.name, offer.depth)
        for each, offer in offers
    ]


def test_offers_are_given_as_rclcpp_s_and_read_as_such(tmp_path: Path) -> None:
    """As programs write latched topics, and as those that copy topics take them over."""
    storage = rosbag2_py._storage
    volatile = storage.rmw_qos_durability_policy_t.RMW_QOS_POLICY_DURABILITY_VOLATILE
    text = "- {history: 1, depth: 7, reliability: 1, durability: 1}"
    scans = storage.QoS(history_depth=5).best_effort().durability(volatile)
    scans.deadline(storage.Duration(seconds=1, nanoseconds=0))
    offers: dict[str, Sequence[storage.QoS] | str] = {
        "/tf_static": [storage.QoS(1).keep_last(3).reliable().transient_local()],
        "/scan": [scans],
        "/old": text,
    }
    writer = rosbag2_py.SequentialWriter()
    writer.open(StorageOptions(str(tmp_path / "first")), OPTIONS)
    for name, given in offers.items():
        writer.create_topic(rosbag2_py.TopicMetadata(0, name, KIND, "cdr", given))
        writer.write(name, serialize_message(String(data=name)), SECOND)
    writer.remove_topic(rosbag2_py.TopicMetadata(name="/old", type=KIND))
    with pytest.raises(RuntimeError, match="'/old' has not been created yet"):
        writer.write("/old", b"", SECOND)
    writer.close()
    reader = rosbag2_py.SequentialReader()
    reader.open_uri(str(tmp_path / "first"))
    copy = rosbag2_py.SequentialWriter()
    copy.open(StorageOptions(str(tmp_path / "second"), "sqlite3"), OPTIONS)
    for topic in reader.get_all_topics_and_types():
        copy.create_topic(topic)
    while reader.has_next():
        copy.write(*reader.read_next())
    copy.close()
    expected = [
        ("/old", 1, "RELIABLE", "TRANSIENT_LOCAL", 7),
        ("/scan", 1, "BEST_EFFORT", "VOLATILE", 5),
        ("/tf_static", 1, "RELIABLE", "TRANSIENT_LOCAL", 3),
    ]
    assert sorted(_described(tmp_path / "first")) == expected
    assert sorted(_described(tmp_path / "second")) == expected
    (read,) = storage.to_rclcpp_qos_vector(text, 8)
    assert read == storage.QoS(7).reliable().transient_local()


def test_metadata_is_read_changed_and_written(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", rosbag2_py.SequentialWriter())
    files = rosbag2_py.MetadataIo()
    assert files.metadata_file_exists(str(folder))
    metadata = files.read_metadata(str(folder))
    before = (folder / "metadata.yaml").read_text()
    assert files.serialize_metadata(metadata) == before
    (folder / "bag_0.mcap").rename(folder / "drive.mcap")
    metadata.files[0].path, metadata.custom_data = "drive.mcap", {"site": "lab"}
    files.write_metadata(str(folder), metadata)
    again = files.read_metadata(str(folder))
    assert (again.relative_file_paths, again.custom_data) == (["drive.mcap"], {"site": "lab"})
    assert again.message_count == 10
    with pytest.raises(RuntimeError, match=r"metadata\.yaml does not exist"):
        files.read_metadata(str(tmp_path))
    with pytest.raises(RuntimeError, match="cannot be written"):
        files.write_metadata("/proc/none", metadata)


def test_recordings_are_rewritten_by_a_file_of_outputs(tmp_path: Path) -> None:
    write(tmp_path / "bag", rosbag2_py.SequentialWriter())
    outputs = tmp_path / "outputs.yaml"
    outputs.write_text(f"output_bags: [{{uri: {tmp_path}/odd, topics: [/odd]}}]")
    rosbag2_py.bag_rewrite([StorageOptions(str(tmp_path / "bag"), "mcap")], str(outputs))
    assert [each[:2] for each in _described(tmp_path / "odd")] == [("/odd", 5)]
    with pytest.raises(RuntimeError, match="exists already"):
        rosbag2_py.bag_rewrite([StorageOptions(str(tmp_path / "bag"))], str(outputs))


def test_options_have_no_other_names_than_theirs() -> None:
    """Those of before Jazzy count; one that would have no effect is an error."""
    options = rosbag2_py.RecordOptions()
    options.all, options.exclude = True, "raw"
    assert (options.all_topics, options.exclude_regex) == (True, "raw")
    assert (options.all, options.exclude) == (True, "raw")
    for made in (options, rosbag2_py.PlayOptions(), StorageOptions("bag")):
        with pytest.raises(AttributeError, match="no attribute 'all_topic'"):
            setattr(made, "all_topic", True)  # noqa: B010 - a name that types forbid


def test_definitions_of_installed_types_are_found() -> None:
    found = rosbag2_py.LocalMessageDefinitionSource()
    definition = found.get_full_text(KIND)
    assert (definition.topic_type, definition.encoding) == (KIND, "ros2msg")
    assert definition.encoded_message_definition.rstrip().endswith("string data")
    unknown = found.get_full_text("some_pkg")
    assert (unknown.encoding, unknown.encoded_message_definition) == ("unknown", "")
