from dataclasses import replace
import sqlite3

from bag_fixtures import write_mcap, write_ros1, write_ros2
from filter_fixtures import make_push_log, planar_scene
from image_fixtures import TOPIC, flat_image, png_image, raw_image, write_log
import numpy as np
import pytest

from pbpf_drake.bags.ros2_messages import COMPRESSED_IMAGE, IMAGE
from pbpf_drake.log.camera_images import CameraImages

LOG = make_push_log(duration=2.0)


def _flat(time, shade, topic=TOPIC):
    return time, topic, IMAGE, raw_image(flat_image(shade))


def _read(path, times):
    dut = CameraImages(
        filename=path,
        topic=TOPIC,
        camera=planar_scene().camera,
        start_time=LOG.start_time,
    )
    return list(dut.At(times)), dut.Warnings()


def _shades(images):
    return [None if image is None else int(image[0, 0, 0]) for image in images]


@pytest.mark.parametrize("write", [write_mcap, write_ros1, write_ros2])
def test_the_last_image_until_a_time_is_found(tmp_path, write):
    images = [_flat(0.1 * i, 10 * i) for i in range(1, 6)]
    path = write_log(tmp_path / "log", LOG, images, write)
    times = [0.05, 0.1, 0.25, 0.29, 0.45, 1.4, 1.6]
    found, warnings = _read(path, times)
    # What is more than a second old isn't shown.
    assert _shades(found) == [None, 10, 20, 20, 40, 50, None]
    assert found[1].shape == (480, 640, 3)
    assert warnings == ()


def test_a_log_without_images_has_none(tmp_path):
    path = write_log(tmp_path / "log.mcap", LOG, [])
    assert _read(path, [0.1, 0.2]) == ([None, None], ())


def test_a_bag_without_definitions_can_be_read(tmp_path):
    images = [_flat(0.1, 10)]
    folder = write_log(tmp_path / "log", LOG, images, write_ros2)
    (bag,) = folder.glob("*.db3")
    with sqlite3.connect(bag) as database:
        database.execute("DROP TABLE message_definitions")
    database.close()
    assert _shades(_read(folder, [0.2])[0]) == [10]


def test_compressed_images_are_found_beside_the_topic(tmp_path):
    topic = f"{TOPIC}/compressed"
    message = png_image(flat_image(77))
    path = write_log(
        tmp_path / "log.mcap", LOG, [(0.1, topic, COMPRESSED_IMAGE, message)]
    )
    found, _ = _read(path, [0.2])
    assert _shades(found) == [77]


def test_of_two_topics_one_is_used(tmp_path):
    images = [_flat(0.1, 10), _flat(0.2, 20, f"{TOPIC}/compressed")]
    path = write_log(tmp_path / "log.mcap", LOG, images)
    assert _shades(_read(path, [0.3])[0]) == [10]


def test_images_of_another_size_are_left_out_and_counted(tmp_path):
    small = raw_image(flat_image(9, size=(320, 240)))
    images = [(0.1, TOPIC, IMAGE, small), _flat(0.3, 30)]
    path = write_log(tmp_path / "log.mcap", LOG, images)
    found, warnings = _read(path, [0.2, 0.4])
    assert _shades(found) == [None, 30]
    assert warnings == (
        f"{TOPIC}: left out 1 image of 320 x 240 pixels; expected 640 x 480, "
        "as the scene's camera has",
    )


def test_an_image_that_is_damaged_costs_no_more_than_itself(tmp_path):
    whole = raw_image(flat_image(5))
    images = [
        (0.1, TOPIC, IMAGE, {**whole, "data": whole["data"][:100]}),
        _flat(0.3, 30),
    ]
    path = write_log(tmp_path / "log.mcap", LOG, images)
    found, warnings = _read(path, [0.2, 0.4])
    assert _shades(found) == [None, 30]
    (warning,) = warnings
    assert "left out 1 image with 100 bytes for 640 x 480 pixels" in warning


def test_messages_of_another_type_are_left_out(tmp_path):
    entry = (0.1, TOPIC, "sensor_msgs/msg/JointState", {"name": ["a"]})
    path = write_log(tmp_path / "log.mcap", LOG, [entry])
    found, warnings = _read(path, [0.2])
    assert found == [None]
    assert (
        "left out 1 image of type 'sensor_msgs/msg/JointState'" in warnings[0]
    )


def test_an_image_without_a_stamp_was_taken_when_it_was_received(tmp_path):
    # Its stamp is zero in a log that starts at the epoch.
    log = replace(LOG, start_time=1_000_000)
    images = [(-0.001, TOPIC, IMAGE, raw_image(flat_image(50)))]
    path = write_log(tmp_path / "log.mcap", log, images)
    dut = CameraImages(
        filename=path,
        topic=TOPIC,
        camera=planar_scene().camera,
        start_time=1_000_000,
    )
    assert _shades(dut.At([0.018, 0.02])) == [None, 50]


@pytest.mark.parametrize("count", [0, 3])
def test_there_is_one_answer_per_time(tmp_path, count):
    path = write_log(tmp_path / "log.mcap", LOG, [_flat(0.1, 10)])
    found, _ = _read(path, np.linspace(0.2, 0.5, count))
    assert _shades(found) == [10] * count
