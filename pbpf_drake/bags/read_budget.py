"""Keeps count of what a file has held so far, within its limits."""

from pbpf_drake.bags.read_limits import LimitError, ReadLimits, megabytes
from pbpf_drake.bags.unpacking import Packed, Unpacked, unpack


class BudgetSpent(LimitError):
    """A file has held as much as it may; what follows is not read."""


class ReadBudget:
    """What one file may still hold."""

    def __init__(self, limits: ReadLimits, size: int):
        """Starts with nothing read.

        Args:
            limits: what it may hold.
            size: of the file (in bytes).
        """
        self._limits = limits
        self._size = size
        self._unpacked = 0
        self._records = 0

    def Unpack(self, compression: str, data: Packed) -> Unpacked:
        """Unpacks a chunk as ``unpack`` does.

        Raises:
            BudgetSpent: with it the file would unpack to too much.
            LimitError: the chunk alone would.
            Exception: of any kind, if it is damaged.
        """
        left = self._limits.max_unpacked(self._size) - self._unpacked
        limit = min(left, self._limits.chunk)
        if compression in ("", "none"):
            # What isn't packed is no more than the file.
            return unpack(compression, data, self._limits.chunk)
        try:
            found = unpack(compression, data, limit)
        except LimitError:
            self._unpacked += limit
            if limit == left:
                raise BudgetSpent(
                    "it unpacks to more than "
                    f"{megabytes(self._limits.max_unpacked(self._size))}"
                    ", see ReadLimits.unpacked and ReadLimits.growth"
                ) from None
            raise
        self._unpacked += len(found.content)
        return found

    def CountRecord(self) -> None:
        """Counts one more message, or whatever else is in the file.

        Raises:
            BudgetSpent: the file has too many.
        """
        self._records += 1
        most = self._limits.max_records(self._size)
        if self._records > most:
            raise BudgetSpent(
                f"it has more than {most} records, see ReadLimits.records and "
                "ReadLimits.bytes_per_record"
            )
