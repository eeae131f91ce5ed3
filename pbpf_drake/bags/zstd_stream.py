"""Reads a log whose whole file is compressed, as rosbag2 can do."""

from collections.abc import Callable, Iterator
from pathlib import Path
import shutil
import tempfile

import zstandard

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import LogStream, RawMessage

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


class ZstdStream(LogStream):
    """The messages of a file that is compressed; see LogStream."""

    kind = "a zstd file"

    def __init__(
        self, *, filename: Path, open_file: Callable[[Path], LogStream]
    ):
        """Prepares to read a file; see LogStream.

        Args:
            filename: the file.
            open_file: opens what is in it, for the topics that are wanted.
        """
        super().__init__(filename=filename)
        self._open_file = open_file

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: nothing of it can be used.
        """
        with tempfile.TemporaryDirectory() as folder:
            unpacked = Path(folder) / "log"
            self._Unpack(unpacked)
            stream = self._open_file(unpacked)
            self.kind = f"{stream.kind}, compressed"
            yield from stream.Messages()
            self.types = stream.types
            self.damage += stream.damage
            self.checksums = stream.checksums

    def _Unpack(self, target: Path) -> None:
        """Unpacks as much as can be; ``damage`` says if that is not all."""
        with self._filename.open("rb") as packed, target.open("wb") as file:
            try:
                reader = zstandard.ZstdDecompressor().stream_reader(packed)
                shutil.copyfileobj(reader, file)
            except zstandard.ZstdError as error:
                self.damage.append(f"it can't be unpacked to its end: {error}")
            except OSError as error:
                raise LogError(f"it can't be unpacked: {error}") from error
