"""Reads a ROS 2 recording that is a folder: metadata.yaml and its files."""

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import (
    LogStream,
    RawMessage,
    Topics,
)
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits, megabytes

METADATA = "metadata.yaml"
# That of a thousand files has a quarter of it (in bytes).
_MAX_METADATA = 1_000_000
# The one in C is ten times as fast, where there is one.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# Which files are read where metadata.yaml doesn't name them.
_ENDINGS = ("*.mcap", "*.db3", "*.mcap.zstd", "*.db3.zstd")


class Rosbag2Stream(LogStream):
    """The messages of a folder's files, one after the other; see LogStream."""

    kind = "a ROS 2 recording"

    def __init__(
        self,
        *,
        filename: Path,
        topics: Topics,
        limits: ReadLimits = DEFAULT_LIMITS,
        open_file: Callable[[Path], LogStream],
    ):
        """Prepares to read a folder; see LogStream.

        Args:
            filename: the folder.
            topics: the topics whose messages are wanted; None means all.
            limits: what each file may hold at most.
            open_file: opens one of its files, for these topics.
        """
        super().__init__(filename=filename, topics=topics, limits=limits)
        self._open_file = open_file
        self._promised: dict[str, int] = {}

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: the folder has no recording in it, or none of its files
                can be read.
        """
        files = self._Files()
        errors = []
        found: Counter[str] = Counter()
        for file in files:
            try:
                stream = self._open_file(file)
                for message in stream.Messages():
                    found[message.topic] += 1
                    yield message
            except LogError as error:
                errors.append(f"{file.name}: {error}")
                continue
            self.types.update(stream.types)
            self.checksums &= stream.checksums
            self.damage += [f"{file.name}: {said}" for said in stream.damage]
            self.checksums &= stream.checksums
        if len(errors) == len(files):
            raise LogError("; ".join(errors))
        self.damage += errors
        self._CompareCounts(found)

    def _Files(self) -> list[Path]:
        try:
            names = self._ReadMetadata()
        except Exception as error:  # Damage can show in any way.
            self.damage.append(
                f"{METADATA} can't be used ({_brief(error)}): all files of "
                "the folder are read"
            )
            names = sorted(
                {f.name for end in _ENDINGS for f in self._filename.glob(end)}
            )
        if not names:
            raise LogError(
                f"it is a folder without {METADATA} and without files of the "
                "endings .mcap and .db3"
            )
        return [self._filename / name for name in names]

    def _ReadMetadata(self) -> list[str]:
        path = self._filename / METADATA
        if not path.is_file():
            raise FileNotFoundError("there is none")
        if path.stat().st_size > _MAX_METADATA:
            raise ValueError(f"it is longer than {megabytes(_MAX_METADATA)}")
        data: Any = yaml.load(path.read_bytes(), Loader=_LOADER)
        information = data["rosbag2_bagfile_information"]
        # As in ROS 2, files are in this folder, whatever path is given.
        names = [Path(p).name for p in information["relative_file_paths"]]
        for entry in information["topics_with_message_count"]:
            topic = str(entry["topic_metadata"]["name"])
            if self._IsWanted(topic):
                self._promised[topic] = int(entry["message_count"])
        # A recorder that was broken off may have left names empty.
        return list(dict.fromkeys(name for name in names if name))

    def _CompareCounts(self, found: Counter[str]) -> None:
        for topic, promised in self._promised.items():
            self._CompareCount(METADATA, topic, promised, found[topic])


def _brief(error: Exception) -> str:
    lines = str(error).splitlines()
    return lines[0] if lines else type(error).__name__
