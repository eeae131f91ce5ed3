"""Reads a log whose whole file is compressed, as rosbag2 can do."""

from collections.abc import Callable, Iterator
from pathlib import Path
import shutil
import tempfile

import zstandard

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import LogStream, RawMessage
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits, megabytes
from pbpf_drake.bags.unpacking import zstd_pieces

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


class ZstdStream(LogStream):
    """The messages of a file that is compressed; see LogStream."""

    kind = "a zstd file"

    def __init__(
        self,
        *,
        filename: Path,
        limits: ReadLimits = DEFAULT_LIMITS,
        open_file: Callable[[Path], LogStream],
    ):
        """Prepares to read a file; see LogStream.

        Args:
            filename: the file.
            limits: what it may unpack to.
            open_file: opens what is in it, for the topics that are wanted.
        """
        super().__init__(filename=filename, limits=limits)
        self._open_file = open_file

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: nothing of it can be used.
        """
        with tempfile.TemporaryDirectory() as folder:
            unpacked = Path(folder) / "log"
            self._Unpack(unpacked)
            if is_zstd(unpacked):
                raise LogError("it is a zstd file in a zstd file; unpack it")
            stream = self._open_file(unpacked)
            self.kind = f"{stream.kind}, compressed"
            yield from stream.Messages()
            self.types = stream.types
            self.damage += stream.damage
            self.checksums = stream.checksums

    def _Unpack(self, target: Path) -> None:
        """Unpacks as much as can be; ``damage`` says if that is not all."""
        left = self._limits.max_unpacked(self.size)
        left = min(left, shutil.disk_usage(target.parent).free // 2)
        most = left
        with self._filename.open("rb") as packed, target.open("wb") as file:
            try:
                for piece in zstd_pieces(packed):
                    left -= file.write(piece[:left])
                    if not left:
                        self.damage.append(
                            f"of what is in it only {megabytes(most)} were "
                            "unpacked: see ReadLimits.unpacked, and whether "
                            f"there is room in {tempfile.gettempdir()}"
                        )
                        break
            except zstandard.ZstdError as error:
                self.damage.append(f"it can't be unpacked to its end: {error}")
            except OSError as error:
                raise LogError(f"it can't be unpacked: {error}") from error


def is_zstd(path: Path) -> bool:
    """Tells if a file starts as a zstd file does."""
    with path.open("rb") as file:
        return file.read(len(ZSTD_MAGIC)) == ZSTD_MAGIC
