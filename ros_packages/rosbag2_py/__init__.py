"""rosbag2 in Python, on the recordings of `arjuna_core.bags`."""

import sys

from rosbag2_py import described as _described
from rosbag2_py import options as _storage
from rosbag2_py import reader as _reader
from rosbag2_py import transport as _transport
from rosbag2_py import writer as _writer
from rosbag2_py.described import LocalMessageDefinitionSource, MetadataIo
from rosbag2_py.options import (
    BagMetadata,
    CompressionMode,
    CompressionOptions,
    ConverterOptions,
    FileInformation,
    MessageDefinition,
    ReadOrder,
    ReadOrderSortBy,
    StorageFilter,
    StorageOptions,
    TopicInformation,
    TopicMetadata,
    compression_mode_from_string,
    compression_mode_to_string,
    get_default_storage_id,
    get_registered_compressors,
    get_registered_readers,
    get_registered_serializers,
    get_registered_writers,
)
from rosbag2_py.qos import convert_rclcpp_qos_to_rclpy_qos, to_rclcpp_qos_vector
from rosbag2_py.reader import Info, Reindexer, SequentialCompressionReader, SequentialReader
from rosbag2_py.transport import (
    Player,
    PlayOptions,
    Recorder,
    RecordOptions,
    ServiceRequestsSource,
    bag_rewrite,
)
from rosbag2_py.writer import SequentialCompressionWriter, SequentialWriter

_info = _reindexer = _reader
_compression_options, _message_definitions = _storage, _described
for _module, _names in (
    (_storage, ("_storage", "_compression_options")),
    (_described, ("_message_definitions",)),
    (_reader, ("_reader", "_info", "_reindexer")),
    (_transport, ("_transport",)),
    (_writer, ("_writer",)),
):
    for _name in _names:  # the original's compiled modules, which its own tutorials name
        sys.modules[f"{__name__}.{_name}"] = _module
