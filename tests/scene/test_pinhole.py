import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.scene.pinhole import (
    clip_segments,
    in_camera,
    in_image,
    project_points,
    project_segments,
)


def _camera(X_WC=None):
    X_WC = Transform(X_WC or RigidTransform())
    return CameraConfig(
        X_WC=X_WC, width=640, height=480, fx=600, fy=500, cx=300, cy=220
    )


def test_corners_of_a_square_are_projected_as_by_a_pinhole():
    corners = [[0.1, 0.2, 2.0], [-0.1, 0.2, 2.0], [0.1, -0.2, 4.0]]
    # u = 600 x / z + 300, v = 500 y / z + 220.
    expected = [[330, 270], [270, 270], [315, 195]]
    np.testing.assert_allclose(
        project_points(np.array(corners), _camera()), expected
    )


@pytest.mark.parametrize("shape", [(3,), (4, 3), (5, 2, 3)])
def test_points_that_go_to_the_world_and_back_are_the_same(shape):
    X_WC = RigidTransform(RollPitchYaw(0.3, -0.2, 1.0), [0.5, 0.6, 0.7])
    p_C = np.random.default_rng(0).normal(size=shape)
    p_W = (X_WC @ p_C.reshape(-1, 3).T).T.reshape(shape)
    np.testing.assert_allclose(in_camera(p_W, _camera(X_WC)), p_C, atol=1e-12)


def test_the_cameras_pose_counts():
    X_WC = RigidTransform(RollPitchYaw(0.3, -0.2, 1.0), [0.5, 0.6, 0.7])
    segment_C = np.array([[[0.1, 0.2, 2.0], [-0.1, 0.2, 2.0]]])
    segment_W = (X_WC @ segment_C[0].T).T[None]
    np.testing.assert_allclose(
        project_segments(segment_W, _camera(X_WC)),
        [[[330, 270], [270, 270]]],
    )


def test_half_of_a_segment_that_crosses_a_plane_is_kept():
    segments = np.array(
        [
            [[0.0, 0.0, -1.0], [4.0, 2.0, 3.0]],
            [[4.0, 2.0, 3.0], [0.0, 0.0, -1.0]],
            [[0.0, 0.0, 2.0], [0.0, 0.0, 3.0]],
            [[0.0, 0.0, 0.0], [0.0, 0.0, 0.5]],
        ]
    )
    found = clip_segments(segments, np.array([0.0, 0.0, 1.0]), 1.0)
    middle, end = [2.0, 1.0, 1.0], [4.0, 2.0, 3.0]
    np.testing.assert_allclose(found[:2], [[middle, end], [end, middle]])
    np.testing.assert_array_equal(found[2], segments[2])
    assert len(found) == 3


def test_in_image_ends_half_a_pixel_beyond_the_outer_pixels_centres():
    camera = CameraConfig(width=4, height=2, fx=1, fy=1, cx=0, cy=0)
    inside = [[-0.49, -0.49, 1], [3.49, 1.49, 1], [6.9, 2.9, 2]]
    outside = [[-0.51, 0, 1], [0, -0.51, 1], [3.51, 0, 1], [0, 1.51, 1]]
    assert np.all(in_image(np.array(inside), camera))
    assert not np.any(in_image(np.array(outside), camera))
    assert not np.any(in_image(np.array([[0, 0, -1.0], [0, 0, 0]]), camera))


def test_no_segments_have_no_parts():
    assert project_segments(np.empty((0, 2, 3)), _camera()).shape == (0, 2, 2)


def _see(p_C):
    """Tells of points if a pinhole sees them, near the camera or far."""
    pixels = project_points(np.where(p_C[:, 2:] > 0, p_C, 1.0), _camera())
    inside = np.all((pixels >= -0.5) & (pixels <= [639.5, 479.5]), axis=1)
    return inside & (p_C[:, 2] >= 0.01), pixels


@pytest.mark.parametrize("seed", range(5))
def test_what_is_left_of_a_segment_is_what_the_camera_sees(seed):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        segment = rng.normal(size=(2, 3)) + [0.0, 0.0, 0.5]
        shares = np.linspace(0, 1, 2001)[:, None]
        seen, pixels = _see(segment[0] * (1 - shares) + segment[1] * shares)
        found = project_segments(segment[None], _camera())
        # A part that falls between two samples may be there as well.
        if not seen.any():
            assert len(found) == 0 or np.ptp(found, axis=1).max() < 60
            continue
        assert found.shape == (1, 2, 2)
        assert np.all(found >= -0.5 - 1e-6)
        assert np.all(found <= np.array([639.5, 479.5]) + 1e-6)
        # Each sample that is seen lies on the part that is left.
        a, b = found[0]
        along = (b - a) / max(np.linalg.norm(b - a), 1e-12)
        offset = pixels[seen] - a
        across = offset[:, 0] * along[1] - offset[:, 1] * along[0]
        assert np.abs(across).max() < 1e-6
        places = offset @ along
        assert places.min() > -1e-6
        assert places.max() < np.linalg.norm(b - a) + 1e-6
