"""The files for viewers, decoded again."""

from dataclasses import replace

import cv2
from filter_fixtures import PERIOD, make_push_log, planar_scene
from image_fixtures import flat_image
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.bags.image_messages import to_bgr
from pbpf_drake.bags.ros2_messages import COMPRESSED_IMAGE
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.tracking.tracking_diagram import Track
from pbpf_drake.tracking.write_track import WriteTrack, detections_at

SCENE = planar_scene()
# Nothing is detected at steps 7 to 9.
LOG = make_push_log(duration=2.0)
CONFIG = ParticleFilterConfig(num_particles=5, period=PERIOD, seed=1)
STEPS = 12
# The camera has images until here, then none.
WITH_IMAGE = 9
ESTIMATE, PARTICLES = "/pbpf/estimate/block", "/pbpf/particles/block"
OVERLAY = "/pbpf/overlay/compressed"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("track")


@pytest.fixture(scope="module")
def record():
    return Track(scene=SCENE, log=LOG, method="pbpf", config=CONFIG)


@pytest.fixture(scope="module")
def written(folder, record):
    """The decoded messages by topic, and the frames of the video."""
    frames = _write(folder, "track", LOG, record)
    return _messages(folder / "track.mcap"), frames


def _write(folder, name, log, record):
    """Writes both files, and returns the frames of the video."""
    WriteTrack(
        scene=SCENE,
        log=log,
        record=record,
        images=[flat_image(128)] * WITH_IMAGE + [None] * (STEPS - WITH_IMAGE),
        mcap_filename=folder / f"{name}.mcap",
        video_filename=folder / f"{name}.mp4",
    )
    video, frames = cv2.VideoCapture(str(folder / f"{name}.mp4")), []
    while (answer := video.read())[0]:
        frames.append(answer[1])
    return frames


def _messages(path):
    found = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message, decoded))
    return found


def _time(nanoseconds):
    return (nanoseconds - LOG.start_time) / 1e9


def _stamp(header):
    return _time(header.stamp.sec * 10**9 + header.stamp.nanosec)


def test_every_update_has_its_messages_in_order(record, written):
    messages, frames = written
    counts = {topic: len(found) for topic, found in messages.items()}
    assert counts == {
        "/joint_states": STEPS,
        "/pbpf/detection/block": record.detected.sum(),
        ESTIMATE: STEPS,
        PARTICLES: STEPS,
        OVERLAY: WITH_IMAGE,
    }
    assert 0 < record.detected.sum() < STEPS == len(frames)
    for found in messages.values():
        times = [_time(message.log_time) for message, _ in found]
        assert np.all(np.diff(times) > 0)
    times = [_time(message.log_time) for message, _ in messages[ESTIMATE]]
    np.testing.assert_allclose(times, record.times, atol=1e-9)


def _pose(pose) -> list[float]:
    q, p = pose.orientation, pose.position
    return [q.w, q.x, q.y, q.z, p.x, p.y, p.z]


def test_poses_are_those_of_the_filter(record, written):
    for i, (_, message) in enumerate(written[0][ESTIMATE]):
        found = _pose(message.pose.pose)
        np.testing.assert_allclose(found, record.poses[i, 0], atol=1e-12)
    for i, (_, message) in enumerate(written[0][PARTICLES]):
        found = [_pose(pose) for pose in message.poses]
        expected = record.particles[i, :, 0]
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_covariances_are_those_of_the_filter(record, written):
    for i, (_, estimate) in enumerate(written[0][ESTIMATE]):
        covariance = np.reshape(estimate.pose.covariance, (6, 6))
        # Position first, as in ROS.
        np.testing.assert_array_equal(
            covariance[:3, :3], record.covariances[i, 0, 3:, 3:]
        )
        assert np.trace(covariance[:3, :3]) > 0


def test_joints_are_where_the_log_has_them(record, written):
    for i, (_, joints) in enumerate(written[0]["/joint_states"]):
        assert joints.name == ["pusher_x", "pusher_y"]
        # The probe starts at x = 0.15 m and moves by 0.06 m/s.
        expected = [0.15 + 0.06 * record.times[i], 0.0]
        np.testing.assert_allclose(joints.position, expected, atol=1e-9)
        np.testing.assert_allclose(joints.velocity, [0.06, 0.0], atol=1e-9)
        assert _stamp(joints.header) == pytest.approx(record.times[i])


def test_detections_are_the_last_that_were_received_by_the_update(written):
    X_WC = SCENE.camera.pose()
    for message, detection in written[0]["/pbpf/detection/block"]:
        update = _time(message.log_time)
        known = [d for d in LOG.detections if d.received <= update + 1e-9]
        newest = max(known, key=lambda d: d.time)
        assert _stamp(detection.header) == pytest.approx(newest.time)
        assert detection.header.frame_id == "world"
        p = detection.pose.position
        np.testing.assert_allclose(
            [p.x, p.y, p.z], (X_WC @ newest.X_CO).translation(), atol=1e-12
        )


# Where things are drawn.


def _corners(X_WO):
    """The pixels of the corners of the block, by the pinhole's formula."""
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, 8)
    camera = SCENE.camera
    p_CO = (
        camera.pose().inverse()
        @ X_WO
        @ (signs * np.array([[0.045], [0.045], [0.0065]]))
    )
    u = camera.fx * p_CO[0] / p_CO[2] + camera.cx
    v = camera.fy * p_CO[1] / p_CO[2] + camera.cy
    return np.rint(np.stack([u, v], axis=1)).astype(int)


def _green(image):
    blue, green, red = np.moveaxis(image.astype(int), -1, 0)
    return (green > red + 60) & (green > blue + 60)


def _yellow(image):
    blue, green, red = np.moveaxis(image.astype(int), -1, 0)
    return (green > blue + 60) & (red > blue + 60)


def _share_near(mask, pixels):
    """Returns the share of pixels that have the color next to them."""
    near = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3), np.uint8))
    return near[pixels[:, 1], pixels[:, 0]].mean()


def _frames(written, i):
    """What the two files have of an update."""
    messages, frames = written
    found = [frames[i]]
    if i < WITH_IMAGE:
        found.append(to_bgr(COMPRESSED_IMAGE, messages[OVERLAY][i][1]))
    return found


@pytest.mark.parametrize("i", [2, 8, 11])
def test_the_estimate_is_green_where_a_pinhole_puts_it(record, written, i):
    corners = _corners(rigid_transform(record.poses[i, 0]))
    for image in _frames(written, i):
        assert _share_near(_green(image), corners) == 1
        rows, columns = np.nonzero(_green(image))
        low, high = corners.min(axis=0), corners.max(axis=0)
        np.testing.assert_allclose([columns.min(), rows.min()], low, atol=4)
        np.testing.assert_allclose([columns.max(), rows.max()], high, atol=4)


@pytest.mark.parametrize("i", [8, 11])
def test_the_last_detection_is_yellow(record, written, i):
    (_, *_, seen) = detections_at(SCENE, LOG, record.times[: i + 1])
    # The corners on the left are not covered by the estimate.
    corners = _corners(seen["block"].X_WO)
    for image in _frames(written, i):
        assert _share_near(_yellow(image) | _green(image), corners) > 0.9
        assert _yellow(image).sum() > 50


def test_an_old_detection_has_thinner_lines(folder, record, written):
    nothing_new = replace(record, detected=np.zeros_like(record.detected))
    frames = _write(folder, "old", LOG, nothing_new)
    for i in range(STEPS):
        old, new = _yellow(frames[i]).sum(), _yellow(written[1][i]).sum()
        if record.detected[i, 0]:
            assert 0 < old < 0.8 * new
        else:
            assert 0 < old == pytest.approx(new, rel=0.1)


def test_camera_images_are_behind_the_wireframes(written):
    for image in _frames(written, 4):
        np.testing.assert_allclose(image[5, 5], 128, atol=8)


def test_without_an_image_the_robot_is_drawn(record, written):
    """Grey lines on dark, around where the probe is."""
    frame = written[1][WITH_IMAGE]
    np.testing.assert_allclose(frame[5, 5], 40, atol=8)
    x = 0.15 + 0.06 * record.times[WITH_IMAGE]
    camera = SCENE.camera
    p_C = camera.pose().inverse() @ np.array([x, 0.0, 0.05])
    u = round(camera.fx * p_C[0] / p_C[2] + camera.cx)
    v = round(camera.fy * p_C[1] / p_C[2] + camera.cy)
    around = frame[v - 8 : v + 9, u - 8 : u + 9].astype(int)
    assert (around.min(axis=-1) > 75).sum() > 10


def test_a_camera_that_the_log_places_is_the_one_that_draws(
    folder, record, written
):
    # Nearer by 0.4 m of the 1 m between the block and the camera.
    X_WC = SCENE.camera.pose() @ RigidTransform([0.0, 0.0, 0.4])
    frames = _write(folder, "nearer", replace(LOG, X_WC=X_WC), record)
    near, far = (np.nonzero(_green(f[0])) for f in (frames, written[1]))
    ratio = np.ptp(near[0]) / np.ptp(far[0])
    assert ratio == pytest.approx(1 / (1 - 0.4), rel=0.05)


# What can't be made.


def _write_some(folder, record, images, video="track.mp4"):
    failures = WriteTrack(
        scene=SCENE,
        log=LOG,
        record=record,
        images=images,
        mcap_filename=folder / "track.mcap",
        video_filename=folder / video,
    )
    return failures, _messages(folder / "track.mcap")


def test_a_video_that_can_not_be_written_costs_only_itself(tmp_path, record):
    images = [flat_image(128)] * STEPS
    failures, found = _write_some(tmp_path, record, images, "none/track.mp4")
    (failure,) = failures
    assert "none/track.mp4 can't be written as MP4" in failure
    assert len(found[ESTIMATE]) == len(found[OVERLAY]) == STEPS


def test_a_picture_that_can_not_be_made_costs_only_pictures(tmp_path, record):
    def images():
        yield from [flat_image(128)] * 3
        raise MemoryError("too many pixels")

    failures, found = _write_some(tmp_path, record, images())
    (failure,) = failures
    assert failure == (
        "pictures can't be made from update 4 on: MemoryError: too many pixels"
    )
    assert len(found[ESTIMATE]) == STEPS
    assert len(found[OVERLAY]) == 3
    # A video that isn't whole is deleted.
    assert [p.name for p in tmp_path.iterdir()] == ["track.mcap"]


def test_without_images_there_are_no_pictures(tmp_path, record):
    failures, found = _write_some(tmp_path, record, None)
    assert failures == ()
    assert len(found[ESTIMATE]) == STEPS and OVERLAY not in found
    assert [p.name for p in tmp_path.iterdir()] == ["track.mcap"]
