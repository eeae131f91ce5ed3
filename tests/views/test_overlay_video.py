import cv2
import numpy as np
import pytest

from pbpf_drake.views.overlay_video import OverlayVideo


def _write(path, images, period=0.16):
    height, width = images[0].shape[:2]
    with OverlayVideo(path, width=width, height=height, period=period) as dut:
        for image in images:
            dut.Write(image)


def _image(i):
    """A picture with a green square that moves to the right."""
    image = np.full((48, 64, 3), 40, np.uint8)
    image[16:32, 8 * i : 8 * i + 16] = 0, 255, 0
    return image


def test_images_can_be_decoded_again(tmp_path):
    path = tmp_path / "video.mp4"
    images = [_image(i) for i in range(6)]
    _write(path, images)
    video = cv2.VideoCapture(str(path))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(6.25)
    for image in images:
        found, frame = video.read()
        assert found and frame.shape == image.shape
        # The encoder blurs edges.
        assert np.abs(frame.astype(int) - image).mean() < 8
    assert not video.read()[0]


def test_the_same_images_give_the_same_file(tmp_path):
    paths = [tmp_path / name for name in ("a.mp4", "b.mp4")]
    for path in paths:
        _write(path, [_image(i) for i in range(4)])
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize(
    ("period", "rate"),
    [(0.0081, 123.46), (1 / 3, 3.0), (1e-4, 500.0), (1e3, 0.01)],
)
def test_any_period_can_be_written(tmp_path, period, rate):
    path = tmp_path / "video.mp4"
    _write(path, [_image(0), _image(1)], period=period)
    video = cv2.VideoCapture(str(path))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(rate, rel=1e-3)


def test_a_file_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(ValueError, match="can't be written as MP4"):
        _write(tmp_path / "missing" / "video.mp4", [_image(0)])


@pytest.mark.parametrize("size", [(10_000, 10), (10, 10_000), (1, 1)])
def test_a_size_that_mp4_does_not_have_is_refused_with_those_it_has(
    tmp_path, size, capfd
):
    width, height = size
    expected = f"{width} x {height} pixels; expected .* 2 to 8,191 pixels"
    with pytest.raises(ValueError, match=expected):
        OverlayVideo(
            tmp_path / "video.mp4", width=width, height=height, period=0.1
        )
    assert capfd.readouterr() == ("", "")
