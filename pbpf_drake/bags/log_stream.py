"""What all readers of a file's messages have in common."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
import mmap
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural

# The topics whose messages are wanted; None means all.
Topics = Collection[str] | None


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
    """

    kind: str

    def __init__(self, *, filename: Path, topics: Topics = None):
        """Prepares to read; nothing is read yet.

        Args:
            filename: the file, or the folder where the log is one.
            topics: the topics whose messages are wanted; None means all.
        """
        self.types: dict[str, str] = {}
        self.damage: list[str] = []
        self.checksums = True
        self._filename = filename
        self._topics = topics
        # How many things of each kind are damaged, by the noun for them.
        self._damaged: Counter[str] = Counter()

    @abstractmethod
    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: nothing in the file can be read.
        """

    def _IsWanted(self, topic: str) -> bool:
        return self._topics is None or topic in self._topics

    def _SayWhatWasDamaged(self) -> None:
        for noun, count in self._damaged.items():
            self.damage.append(f"left out {plural(count, noun)}: damaged")

    def _SayThatItIsCutOff(self, end: int, length: int) -> None:
        """Says that the last whole record ends before the file does."""
        self.damage.append(
            f"the file is cut off: what is whole ends at byte {end} of "
            f"{length}, and was used"
        )

    def _SayThatNumbersMayBeWrong(self) -> None:
        """Says what follows from damage in a file without checksums."""
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
