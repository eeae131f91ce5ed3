"""What all readers of a file's messages have in common."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
import mmap
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.read_budget import ReadBudget
from pbpf_drake.bags.read_limits import (
    DEFAULT_LIMITS,
    ReadLimits,
    megabytes,
)

# The topics whose messages are wanted; None means all.
Topics = Collection[str] | None
# What is damaged at more places than this is counted, not named.
_MAX_SENTENCES = 30


@dataclass(frozen=True)
class RawMessage:
    """A message as the file holds it.

    Attributes:
        topic: its topic.
        type: the name of its type, "package/msg/Type" or "package/Type".
        encoding: how ``data`` is encoded: "cdr" for ROS 2, "ros1" for ROS 1.
        definition: the text that defines its type; empty where there is none.
        log_time: when it was received (in nanoseconds).
        data: the encoded message.
    """

    topic: str
    type: str
    encoding: str
    definition: str
    log_time: int
    data: bytes


class LogStream(ABC):
    """The messages of one log on given topics, in the file's order.

    Once ``Messages()`` has yielded its last message, ``types``, ``damage`` and
    ``checksums`` are complete.

    Attributes:
        kind: what kind of file it is, as in "an MCAP file".
        types: by topic, the name of the type of its messages. It has all
            topics, also those that aren't wanted.
        damage: one sentence for everything that could not be read.
        checksums: whether all that was read was covered by a checksum, so
            that a number that is damaged shows.
        size: of the file, or of all files (in bytes).
    """

    kind: str

    def __init__(
        self,
        *,
        filename: Path,
        topics: Topics = None,
        limits: ReadLimits = DEFAULT_LIMITS,
    ):
        """Prepares to read; nothing is read yet.

        Args:
            filename: the file, or the folder where the log is one.
            topics: the topics whose messages are wanted; None means all.
            limits: what the file may hold at most.
        """
        self.types: dict[str, str] = {}
        self.damage: list[str] = []
        self.checksums = True
        self.size = _size(filename)
        self._filename = filename
        self._topics = topics
        self._limits = limits
        self._budget = ReadBudget(limits, self.size)
        # How many things of each kind are left out, by the noun for them, and
        # why.
        self._left_out: Counter[tuple[str, str]] = Counter()
        # Whether a chunk that is cut off is all that has no checksum.
        self._is_only_cut = False

    @abstractmethod
    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: nothing in the file can be read.
        """

    def _IsWanted(self, topic: str) -> bool:
        return self._topics is None or topic in self._topics

    def _Say(self, sentence: str) -> None:
        """Says that something is damaged, of which there may be very much."""
        if len(self.damage) < _MAX_SENTENCES:
            self.damage.append(sentence)
        else:
            self._LeaveOut("more place")

    def _LeaveOut(self, noun: str, reason: str = ": damaged") -> None:
        """Counts one more ``noun`` that is not used.

        Args:
            noun: what it is, such as "message".
            reason: what follows the noun in the sentence.
        """
        self._left_out[noun, reason] += 1

    def _IsAdmitted(self, length: int) -> bool:
        """Tells if a message is short enough to be used."""
        admitted = length <= self._limits.message
        if not admitted:
            most = megabytes(self._limits.message)
            self._LeaveOut(
                "message", f" longer than {most}, see ReadLimits.message"
            )
        return admitted

    def _SayWhatWasLeftOut(self) -> None:
        for (noun, reason), count in self._left_out.items():
            self.damage.append(f"left out {plural(count, noun)}{reason}")

    def _SayThatItEndsHere(self, error: ValueError) -> None:
        """Says that the file holds more than its limits allow."""
        self.damage.append(f"what follows is not read: {error}")

    def _SayThatItIsCutOff(self, end: int, length: int) -> None:
        """Says that the last whole record ends before the file does."""
        self.damage.append(
            f"the file is cut off: what is whole ends at byte {end} of "
            f"{length}, and was used"
        )

    def _SayWhatIsLeftOfAChunk(self, count: int) -> None:
        """Says how many messages of a chunk were whole before it ended."""
        if count:
            self._is_only_cut = self.checksums
            self.checksums = False
            self.damage.append(
                f"{plural(count, 'message')} of the chunk that is cut off "
                "came before and could be used, without its checksum"
            )

    def _SayIfNumbersMayBeWrong(self) -> None:
        """Says what follows from damage in a file without checksums."""
        if self.damage and not self.checksums and not self._is_only_cut:
            self.damage.append(
                "the file has no checksums: numbers that are damaged can't be "
                "told from good ones"
            )

    def _CompareCount(
        self, source: str, topic: str, promised: int, found: int
    ) -> None:
        """Says if ``source`` promises another number of messages."""
        if found != promised:
            self.damage.append(
                f"{source} says that {topic} has "
                f"{plural(promised, 'message')}, but {found} could be read"
            )


def OpenBytes(filename: Path) -> mmap.mmap:
    """Returns a file's bytes, without loading them.

    Raises:
        LogError: it can't be opened, or it is empty.
    """
    try:
        with filename.open("rb") as file:
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise LogError(f"it can't be opened: {error.strerror}") from error
    except ValueError as error:
        raise LogError("it is empty") from error


def _size(path: Path) -> int:
    """Returns how long a file is, or all files of a folder (in bytes)."""
    try:
        files = list(path.iterdir()) if path.is_dir() else [path]
        return sum(file.stat().st_size for file in files)
    except OSError:
        return 0  # That it can't be opened is said when it is read.
