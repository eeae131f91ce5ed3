"""How much a file may hold, so that no file can fill the memory or the disk.

A small file can unpack to terabytes, and what it says of its own size need not
be true. So these limits are enforced on what comes out while it is unpacked.
They are far above what cameras and robots record.
"""

from dataclasses import dataclass, replace

_MIB = 2**20


class LimitError(ValueError):
    """More than a limit allows; the message names the limit."""


@dataclass(frozen=True)
class ReadLimits:
    """What one file may hold at most (in bytes, where no unit is given).

    A raw image of 8K has 100 MB, recorders write chunks of 1 to 64 MB, and
    messages compress to about a third. What is beyond a limit is left out, and
    the log's warnings say so.

    Attributes:
        message: of one message.
        chunk: of one chunk, unpacked.
        unpacked, growth: a file unpacks to at most ``unpacked``, or to
            ``growth`` times its size if that is more.
        decoded, decoded_growth: the same for messages of numbers that are
            decoded, which is all but images: they take more memory than time.
        records, bytes_per_record: a file has at most ``records`` messages and
            other records, or one for each ``bytes_per_record`` of its size if
            that is more.
        definition, definitions: of the text that defines a type, and of those
            of all types that are decoded.
    """

    message: int = 128 * _MIB
    chunk: int = 256 * _MIB
    unpacked: int = 512 * _MIB
    growth: int = 20
    decoded: int = 64 * _MIB
    decoded_growth: int = 4
    records: int = 1_000_000
    bytes_per_record: int = 8
    definition: int = 2**16
    definitions: int = 2**18

    def of_file(self, size: int) -> "ReadLimits":
        """Returns the limits for what a file of ``size`` bytes unpacks to."""
        return replace(
            self,
            unpacked=self.max_unpacked(size),
            decoded=self.max_decoded(size),
            records=self.max_records(size),
            growth=0,
            decoded_growth=0,
            bytes_per_record=2**63,
        )

    def max_unpacked(self, size: int) -> int:
        """Returns what a file of ``size`` bytes may unpack to (in bytes)."""
        return max(self.unpacked, self.growth * size)

    def max_decoded(self, size: int) -> int:
        """Returns how much of a file's messages is decoded (in bytes)."""
        return max(self.decoded, self.decoded_growth * size)

    def max_records(self, size: int) -> int:
        """Returns how many records a file of ``size`` bytes may have."""
        return max(self.records, size // self.bytes_per_record)


DEFAULT_LIMITS = ReadLimits()


def megabytes(count: int) -> str:
    """Returns a number of bytes for a sentence, such as "12.5 MB"."""
    return f"{count / 1e6:.4g} MB"
