"""Writes logs as bags of ROS 1 and ROS 2, with the library's own writers."""

from collections.abc import Callable
from pathlib import Path

import lz4.frame
from mcap_ros2.writer import Writer as McapWriter
import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pbpf_drake.log import Log
from pbpf_drake.log_topics import LogTopics
from pbpf_drake.mcap_log_writer import log_entries
from pbpf_drake.ros2_messages import message_definition

# When it was received (in nanoseconds), topic, type, message as a dictionary.
Entry = tuple[int, str, str, dict]

_CHUNK = 4000


def our_entries(log: Log, topics: LogTopics | None = None) -> list[Entry]:
    """Returns a log's messages in our own layout, as they were received."""
    return log_entries(log, topics or LogTopics(), {})


def write_mcap(path: Path, entries: list[Entry]) -> Path:
    """Writes an MCAP file of ROS 2 messages."""
    with McapWriter(str(path), chunk_size=_CHUNK) as writer:
        schemas = {}
        for time, topic, kind, message in entries:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(
                    kind, message_definition(kind)
                )
            writer.write_message(topic, schemas[kind], message, log_time=time)
    return path


def write_ros1(
    path: Path, entries: list[Entry], compression: str = "bz2"
) -> Path:
    """Writes a ROS 1 bag, whose chunks are "bz2", "lz4" or "none"."""
    store, writer = _store(1, entries), Ros1Writer(path)
    if compression != "none":
        writer.set_compression(
            Ros1Writer.CompressionFormat[compression.upper()]
        )
    if compression == "lz4":
        # As ROS does; the library leaves the checksum out.
        writer.compressor = lambda data: lz4.frame.compress(
            data, content_checksum=True
        )
    writer.chunk_threshold = _CHUNK
    with writer:
        _write(writer, store, entries, store.serialize_ros1)
    return path


def write_ros2(
    path: Path,
    entries: list[Entry],
    *,
    storage: str = "sqlite3",
    compression: str = "none",
) -> Path:
    """Writes the folder of a ROS 2 recording.

    Args:
        path: the folder.
        entries: what to write.
        storage: "sqlite3" or "mcap".
        compression: "none", "file", "message" or, for MCAP, "storage".
    """
    store = _store(2, entries)
    plugin = StoragePlugin[storage.upper()]
    writer = Ros2Writer(path, version=9, storage_plugin=plugin)
    mode = CompressionMode[compression.upper()]
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        _write(writer, store, entries, store.serialize_cdr)
    return path


def _write(writer, store, entries: list[Entry], serialize: Callable) -> None:
    connections = {}
    for time, topic, kind, message in entries:
        if topic not in connections:
            connections[topic] = writer.add_connection(
                topic, kind, typestore=store
            )
        made = _make(store, kind, message)
        writer.write(connections[topic], time, serialize(made, kind))


def _store(version: int, entries: list[Entry]):
    """Returns a store of the types of all entries."""
    store = get_typestore(Stores.EMPTY)
    for kind in {kind for _, _, kind, _ in entries}:
        text = message_definition(kind)
        if version == 1:
            # A header has a number, and fields have no defaults.
            text = text.replace(
                "builtin_interfaces/Time stamp", "uint32 seq\ntime stamp"
            ).replace("float64 w 1", "float64 w")
            for axis in "xyz":
                text = text.replace(f"float64 {axis} 0", f"float64 {axis}")
        store.register(get_types_from_msg(text, kind))
    return store


def _make(store, kind: str, message: dict):
    """Returns an object of the library, with zeros for what is left out."""
    values = {}
    for name, (form, what) in store.fielddefs[kind][1]:
        given = message.get(name)
        if form.name == "NAME":
            values[name] = _make(store, what, given or {})
        elif form.name == "BASE":
            default = "" if what[0] == "string" else 0
            values[name] = default if given is None else given
        else:
            (inner, inner_type), length = what
            items = given if given is not None else [0] * length
            if inner.name == "NAME":
                values[name] = [_make(store, inner_type, i) for i in items]
            elif isinstance(items, bytes):
                values[name] = np.frombuffer(items, np.uint8)
            elif inner_type[0] == "string":
                values[name] = list(items)
            else:
                values[name] = np.array(items, dtype=inner_type[0])
    return store.types[kind](**values)
