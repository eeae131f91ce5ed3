import numpy as np
import pytest

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.views.overlay import draw_edges, plain_image

CAMERA = CameraConfig(width=64, height=48, fx=100, fy=100, cx=32, cy=24)
COLOR = (10, 200, 30)


def _drawn(edges, width=1):
    """Where something was drawn: rows and columns of pixels."""
    image = plain_image(CAMERA)
    assert image.shape == (48, 64, 3)
    plain = image[0, 0].copy()
    draw_edges(image, np.array(edges), CAMERA, color=COLOR, width=width)
    return image, np.any(image != plain, axis=2)


def test_a_line_has_its_color_and_is_where_a_pinhole_puts_it():
    # From pixel (12, 34) to (52, 34).
    image, drawn = _drawn([[[-0.2, 0.1, 1.0], [0.4, 0.2, 2.0]]])
    np.testing.assert_allclose(image[34, 13:52], [COLOR] * 39, atol=20)
    rows, columns = np.nonzero(drawn)
    # Smooth lines reach one pixel further.
    assert set(rows) <= {33, 34, 35}
    assert columns.min() in (11, 12) and columns.max() in (52, 53)


def test_a_wider_line_covers_more():
    line = [[[-0.2, 0.1, 1.0], [0.2, 0.1, 1.0]]]
    assert _drawn(line, width=3)[1].sum() > 1.5 * _drawn(line)[1].sum()


@pytest.mark.parametrize(
    "edge", [[[0, 0, -1], [0.1, 0, -2]], [[5, 0, 1], [6, 0, 1]]]
)
def test_what_the_camera_does_not_see_is_not_drawn(edge):
    assert not np.any(_drawn([edge])[1])


def test_a_line_from_behind_the_camera_ends_at_the_images_border():
    # To the point (32, 24) of the image, from below it.
    image, _ = _drawn([[[0.0, 0.3, -1.0], [0.0, 0.0, 1.0]]])
    np.testing.assert_allclose(image[25:47, 32], [COLOR] * 22, atol=20)
    assert np.all(image[:22, 32] == image[0, 0])


def test_nothing_is_drawn_of_no_edges():
    assert not np.any(_drawn(np.empty((0, 2, 3)))[1])
