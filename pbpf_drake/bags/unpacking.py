"""Unpacks what is compressed, piece by piece and never more than a limit."""

import bz2
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import lz4.frame
import zstandard

from pbpf_drake.bags.read_limits import LimitError, megabytes

# What is unpacked at a time (in bytes).
_PIECE = 2**20
# What zstd may look back by, which is memory that it takes (in bytes).
_WINDOW = 2**28

# The packed bytes; a view of a file where that saves a copy.
Packed = bytes | memoryview


@dataclass(frozen=True)
class Unpacked:
    """What came out.

    Attributes:
        content: the bytes.
        whole: whether this is all, as far as the compression can tell.
    """

    content: bytes | bytearray | memoryview
    whole: bool


def unpack(compression: str, data: Packed, limit: int) -> Unpacked:
    """Unpacks as much as there is.

    Args:
        compression: "zstd", "lz4", "bz2", or "none" or "" for none.
        data: the packed bytes, whose end may be missing.
        limit: what may come out (in bytes).

    Raises:
        LimitError: more would come out.
        ValueError: it is compressed in another way.
        Exception: of any kind, if it is damaged.
    """
    if compression in ("", "none"):
        if len(data) > limit:
            raise _too_long(limit)
        return Unpacked(data, whole=True)
    if compression not in _PIECES:
        raise ValueError(f"compressed by {compression!r}")
    if compression == "zstd" and zstandard.frame_content_size(data) > limit:
        raise _too_long(limit)
    pieces = _PIECES[compression](data)
    content = bytearray()
    while True:
        try:
            content += next(pieces)
        except StopIteration as end:
            return Unpacked(content, whole=bool(end.value))
        if len(content) > limit:
            raise _too_long(limit)


def zstd_pieces(source: Any) -> Iterator[bytes]:
    """Yields what is in zstd frames, piece by piece.

    Args:
        source: bytes, or an open file.

    Raises:
        zstandard.ZstdError: it is damaged. Where the end is missing, nothing
            is raised.
    """
    decompressor = zstandard.ZstdDecompressor(max_window_size=_WINDOW)
    with decompressor.stream_reader(source, read_across_frames=True) as reader:
        while piece := reader.read(_PIECE):
            yield piece


# Each yields pieces and returns whether the end was reached.
_Pieces = Callable[[Packed], Any]


def _zstd(data: Packed) -> Any:
    # Whether the end is missing shows in the size, which is checked as well.
    yield from zstd_pieces(data)
    return True


def _lz4(data: Packed) -> Any:
    return _decompressed(lz4.frame.LZ4FrameDecompressor(), data)


def _bz2(data: Packed) -> Any:
    return _decompressed(bz2.BZ2Decompressor(), data)


def _decompressed(decompressor: Any, data: Packed) -> Any:
    piece = decompressor.decompress(data, _PIECE)
    while True:
        yield piece
        if decompressor.eof or (not piece and decompressor.needs_input):
            return decompressor.eof
        piece = decompressor.decompress(b"", _PIECE)


_PIECES: dict[str, _Pieces] = {"zstd": _zstd, "lz4": _lz4, "bz2": _bz2}


def _too_long(limit: int) -> LimitError:
    return LimitError(f"too long, more than {megabytes(limit)} unpacked")
