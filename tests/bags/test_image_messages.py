from types import SimpleNamespace

from image_fixtures import png_image, raw_image
import numpy as np
import pytest

from pbpf_drake.bags.image_messages import jpeg_fields, to_bgr
from pbpf_drake.bags.ros2_messages import COMPRESSED_IMAGE, IMAGE

RNG = np.random.default_rng(0)
BGR = RNG.integers(0, 256, (4, 6, 3), dtype=np.uint8)
ALPHA = np.full((4, 6, 1), 7, np.uint8)
GREY = BGR[..., :1]


@pytest.mark.parametrize(
    ("encoding", "pixels", "expected"),
    [
        ("bgr8", BGR, BGR),
        ("rgb8", BGR[..., ::-1], BGR),
        ("bgra8", np.concatenate([BGR, ALPHA], axis=2), BGR),
        ("rgba8", np.concatenate([BGR[..., ::-1], ALPHA], axis=2), BGR),
        ("mono8", GREY, np.repeat(GREY, 3, axis=2)),
    ],
)
@pytest.mark.parametrize("pad", [0, 5])
def test_pixels_of_every_encoding_are_blue_green_red(
    encoding, pixels, expected, pad
):
    fields = raw_image(pixels, encoding, pad)
    image = to_bgr(IMAGE, SimpleNamespace(**fields))
    np.testing.assert_array_equal(image, expected)


def test_png_is_decoded_without_loss():
    message = SimpleNamespace(**png_image(BGR))
    np.testing.assert_array_equal(to_bgr(COMPRESSED_IMAGE, message), BGR)


def test_jpeg_keeps_colors():
    image = np.zeros((16, 16, 3), np.uint8)
    image[:] = 200, 100, 50
    message = SimpleNamespace(**jpeg_fields(image))
    found = to_bgr(COMPRESSED_IMAGE, message)
    np.testing.assert_allclose(found, image, atol=4)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"encoding": "16UC1"}, "of encoding '16UC1'; expected one of"),
        ({"data": b"12"}, "with 2 bytes for 6 x 4 pixels of 3 in rows of 18"),
        ({"step": 2, "data": b"12345678"}, "in rows of 2"),
        ({"height": 0, "data": b""}, "with 0 bytes"),
    ],
)
def test_an_image_that_does_not_fit_is_refused(change, reason):
    message = SimpleNamespace(**{**raw_image(BGR), **change})
    with pytest.raises(ValueError, match=reason):
        to_bgr(IMAGE, message)


@pytest.mark.parametrize("data", [b"", b"no image", b"\x89PNG\r\n\x1a\n"])
def test_data_that_is_no_image_is_refused(data):
    message = SimpleNamespace(format="png", data=data)
    with pytest.raises(ValueError, match="of format 'png' that can't be"):
        to_bgr(COMPRESSED_IMAGE, message)
