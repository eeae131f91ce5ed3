"""Opens a log; what a file starts with tells what kind of file it is."""

from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import LogStream, Topics
from pbpf_drake.bags.mcap_records import MCAP_MAGIC
from pbpf_drake.bags.mcap_stream import McapStream
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.ros1_bag_stream import Ros1BagStream
from pbpf_drake.bags.ros1_records import BAG_MAGIC
from pbpf_drake.bags.rosbag2_stream import Rosbag2Stream
from pbpf_drake.bags.sqlite_bag_stream import SQLITE_MAGIC, SqliteBagStream
from pbpf_drake.bags.zstd_stream import ZSTD_MAGIC, ZstdStream

_EXPECTED = "expected an MCAP file, a ROS 1 bag or a ROS 2 bag"
_STREAMS: dict[bytes, type[LogStream]] = {
    MCAP_MAGIC: McapStream,
    BAG_MAGIC: Ros1BagStream,
    SQLITE_MAGIC: SqliteBagStream,
}


def OpenLogStream(
    filename: Path,
    topics: Topics = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> LogStream:
    """Returns the stream of a log's messages.

    Args:
        filename: a file, or the folder of a ROS 2 recording.
        topics: the topics whose messages are wanted; None means all.
        limits: what a file may hold at most.

    Raises:
        LogError: there is no such file, it is no regular file (a pipe, say), or
            it is no log; the message says what it is.
    """

    def open_file(file: Path) -> LogStream:
        return OpenLogStream(file, topics, limits)

    if filename.is_dir():
        return Rosbag2Stream(
            filename=filename,
            topics=topics,
            limits=limits,
            open_file=open_file,
        )
    if filename.exists() and not filename.is_file():
        # To read from a pipe may take for ever.
        raise LogError(f"{_EXPECTED}, but it is no regular file")
    try:
        with filename.open("rb") as file:
            start = file.read(16)
    except OSError as error:
        raise LogError(f"it can't be opened: {error.strerror}") from error
    for magic, stream in _STREAMS.items():
        if start.startswith(magic):
            return stream(filename=filename, topics=topics, limits=limits)
    if start.startswith(ZSTD_MAGIC):
        # What comes out is no reason for it to hold more.
        limits = limits.of_file(filename.stat().st_size)
        return ZstdStream(filename=filename, limits=limits, open_file=open_file)
    raise LogError(f"{_EXPECTED}, but {_describe(start)}")


def _describe(start: bytes) -> str:
    if not start:
        return "it is empty"
    if start.startswith(b"#ROSBAG V1"):
        return "it is a bag of a version before 2.0; convert it with rosbag fix"
    return f"it starts with {start!r}"
