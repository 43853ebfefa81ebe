"""rosbag2 in Python, on the recordings of `arjuna_core.bags`."""

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
from rosbag2_py.reader import Info, Reindexer, SequentialCompressionReader, SequentialReader
from rosbag2_py.transport import Player, PlayOptions, Recorder, RecordOptions
from rosbag2_py.writer import SequentialCompressionWriter, SequentialWriter
