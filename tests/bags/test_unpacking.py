"""What is packed is unpacked piece by piece, and never beyond a limit."""

import bz2
import random
import tracemalloc

from bomb_fixtures import lz4_frame, zstd_frame
import lz4.frame
import pytest
import zstandard

from pbpf_drake.bags.read_limits import LimitError
from pbpf_drake.bags.unpacking import unpack

PACK = {
    "zstd": zstandard.compress,
    "lz4": lz4.frame.compress,
    "bz2": bz2.compress,
    "none": bytes,
}
CONTENT = random.Random(1).randbytes(2_000_000).hex().encode()


@pytest.mark.parametrize("compression", PACK)
def test_all_that_was_packed_comes_out(compression):
    packed = PACK[compression](CONTENT)
    found = unpack(compression, memoryview(packed), len(CONTENT))
    assert found.content == CONTENT and found.whole
    with pytest.raises(LimitError, match="too long"):
        unpack(compression, packed, len(CONTENT) - 1)


@pytest.mark.parametrize("compression", ["zstd", "lz4", "bz2"])
def test_what_comes_before_a_cut_comes_out(compression):
    packed = PACK[compression](CONTENT)
    found = unpack(compression, packed[: len(packed) // 2], len(CONTENT))
    assert 0.3 * len(CONTENT) < len(found.content) < 0.6 * len(CONTENT)
    assert CONTENT.startswith(found.content)


@pytest.mark.parametrize(
    "compression, packed",
    [("zstd", zstd_frame(10**9)), ("lz4", lz4_frame(10**9))],
)
def test_no_more_than_the_limit_is_held(compression, packed):
    tracemalloc.start()
    try:
        with pytest.raises(LimitError, match="more than 10 MB"):
            unpack(compression, packed, 10**7)
        assert tracemalloc.get_traced_memory()[1] < 3e7
    finally:
        tracemalloc.stop()


def test_another_compression_is_refused():
    with pytest.raises(ValueError, match="compressed by 'zip'"):
        unpack("zip", b"abc", 100)
