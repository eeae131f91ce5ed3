"""What --inspect says of a log."""

from functools import partial

from authors_fixtures import transform
from bag_fixtures import our_entries, write_mcap, write_ros1, write_ros2
from filter_fixtures import SCENES
from image_fixtures import TOPIC, flat_image, png_image, write_log
from log_fixtures import JOINT_NAMES, make_small_log, make_small_scene
from paths import DATA
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.ros2_messages import COMPRESSED_IMAGE, TF_MESSAGE
from pbpf_drake.diagrams.track_log import main
from pbpf_drake.log.log_inspection import InspectLog
from pbpf_drake.model_facts import MimicJoint, ModelFacts

LOG = make_small_log()


def _inspect(path, scene=None, names=JOINT_NAMES):
    return InspectLog(
        filename=path, scene=scene or make_small_scene(), joint_names=names
    )


def _row(text, topic):
    (row,) = (line for line in text.splitlines() if line.startswith(topic))
    return row.split()


@pytest.mark.parametrize(
    "write, kind",
    [
        (write_mcap, "an MCAP file"),
        (write_ros1, "a ROS 1 bag"),
        (write_ros2, "a ROS 2 recording"),
    ],
)
def test_it_says_what_there_is_and_that_it_can_be_tracked(
    tmp_path, write, kind
):
    path = write(tmp_path / "log", our_entries(LOG))
    text = _inspect(path)
    assert f"{path} is {kind} of 88 messages in 0.49 s" in text
    # Received from 0 s to 0.49 s, at 100 Hz.
    row = _row(text, "/joint_states")
    assert row[1].endswith("JointState")
    assert row[2:] == ["50", "0.00", "0.49", "100.0"]
    for line in (
        "joint states: /joint_states",
        "detections: /dope/detected_objects",
        "ground truth: /ground_truth/box",
        "camera: where the scene says",
        "It can be tracked: 50 joint states in 0.49 s, detections {'box': 5}, "
        "ground truth {'box': 33}",
    ):
        assert line in text
    assert "MISSING" not in text and "Warnings" not in text


def test_it_says_what_is_missing_and_what_there_is_instead(tmp_path):
    path = write_mcap(tmp_path / "log", our_entries(LOG))
    scene = make_small_scene()
    scene.topics.joint_states = "/arm/joints"
    scene.topics.detections = "/seen"
    text = _inspect(path, scene)
    assert (
        "joint states: /arm/joints is MISSING; there is /joint_states" in text
    )
    assert "detections: /seen is MISSING; there is /dope/detected" in text
    assert "It can't be tracked." in text
    assert "there are no joint states; expected" in text


def test_it_says_which_joints_are_missing(tmp_path):
    path = write_mcap(tmp_path / "log", our_entries(LOG))
    text = _inspect(path, names=["slide_x", "elbow"])
    assert "without the joints ['elbow']; it has ['slide_x'" in text
    assert "topics.joint_names" in text
    assert "It can't be tracked." in text


def test_it_says_which_frames_there_are(tmp_path):
    tf = transform(LOG.start_time, "/base", "/box", RigidTransform())
    entry = (LOG.start_time, "/tf", TF_MESSAGE, {"transforms": [tf] * 3})
    path = write_ros1(tmp_path / "log", [entry, *our_entries(LOG)])
    scene = make_small_scene()
    scene.topics.reference_frame = "base"
    scene.topics.detections = "tf:can"
    text = _inspect(path, scene)
    assert "  base -> box: 3 times" in text
    assert "detections: tf:can is MISSING; there is box" in text


def test_it_says_what_is_damaged(tmp_path):
    path = write_mcap(tmp_path / "log", our_entries(LOG))
    path.write_bytes(path.read_bytes()[:-2000])
    assert "the file is cut off" in _inspect(path)
    path.write_bytes(path.read_bytes()[:60])
    text = _inspect(path)
    assert "It can't be tracked." in text and "the file is cut off" in text


@pytest.mark.parametrize(
    ("topic", "line"),
    [
        (f"{TOPIC}/compressed", f"images: {TOPIC}/compressed\n"),
        ("/other/image", f"images: {TOPIC} is MISSING; there is /other/image"),
    ],
)
def test_it_says_which_images_are_drawn_on(tmp_path, topic, line):
    image = png_image(flat_image(0, size=(8, 8)))
    images = [(0.1, topic, COMPRESSED_IMAGE, image)]
    assert line in _inspect(write_log(tmp_path / "log", LOG, images))


def test_the_scene_names_the_topic_of_images(tmp_path):
    image = png_image(flat_image(0, size=(8, 8)))
    images = [(0.1, "/other/image", COMPRESSED_IMAGE, image)]
    scene = make_small_scene()
    scene.topics.images = "/other/image"
    text = _inspect(write_log(tmp_path / "log", LOG, images), scene)
    assert "images: /other/image\n" in text


def test_what_is_no_log_is_refused(tmp_path):
    path = tmp_path / "log"
    path.write_bytes(b"no log")
    with pytest.raises(LogError, match=f"Log {path}: expected an MCAP file"):
        _inspect(path)


def test_the_command_prints_it_and_tracks_nothing(tmp_path, capsys):
    assert main(["--inspect", str(SCENES.parent / "logs/cheezit_1.mcap"),
                 "--out", str(tmp_path / "out")]) == 0  # fmt: skip
    printed = capsys.readouterr()
    assert "It can be tracked: 2501 joint states" in printed.out
    assert printed.err == "" and not (tmp_path / "out").exists()
    assert main(["--inspect", str(tmp_path / "none.bag")]) == 1
    printed = capsys.readouterr()
    assert printed.out == "" and "none.bag: it can't be" in printed.err


@pytest.mark.skipif(not DATA.is_dir(), reason="no recorded logs here")
def test_recorded_logs_are_inspected():
    for folder in ("logs", "push_bags"):
        paths = [
            p
            for p in sorted((DATA / folder).iterdir())
            if p.suffix in (".bag", ".mcap")
        ]
        assert paths
        for path in paths:
            text = _inspect(path)
            assert f"{path} is a" in text and "It can't be tracked." in text


@pytest.mark.parametrize(
    ("write", "expected"),
    [
        (write_ros2, "A ROS 2 recording of this form has no checksums"),
        (
            partial(write_ros1, compression="none"),
            "A ROS 1 bag of this form has no checksums",
        ),
        (write_ros1, ""),
        (write_mcap, ""),
    ],
)
def test_it_says_whether_damage_could_be_noticed(tmp_path, write, expected):
    text = _inspect(write(tmp_path / "log", our_entries(LOG)))
    assert expected in text
    assert bool(expected) == ("checksums" in text)


def test_it_says_in_which_frames_detections_are(faulty, path):
    faulty.joints(0.0)
    faulty.detection(0.1)
    faulty.__exit__()
    text = _inspect(path, names=("a", "b"))
    assert "frames of /dope/detected_objects: 'frame'" in text


def test_it_says_what_is_used_and_how_old_detections_are(faulty, path):
    for i in range(10):
        faulty.joints(0.1 * i)
        faulty.detection(0.1 * i, delay=2.4)
    faulty.detection(0.95, q=(0, 0, 0, 0))
    faulty.__exit__()
    text = _inspect(path, names=("a", "b"))
    for line in (
        "/joint_states: 10 messages read, 10 used",
        "11 detections of 'box' read, 10 used; 1 left out: whose quaternion",
        "detections of 'box' are 2.400 s old when they arrive (median; 95th",
        "is older than filter.max_detection_age, 2 s",
    ):
        assert line in text


def test_it_finds_joints_on_other_topics(faulty, path):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    faulty.joints(0.0, names=("b",), positions=(0.0,), topic="/hand")
    faulty.__exit__()
    text = _inspect(path, names=("a", "b"))
    assert "joints ['b']: /hand" in text and "It can be tracked" in text
    text = _inspect(path, names=("a", "b", "c"))
    assert "without the joints ['c']; it has ['a', 'b']" in text


def test_a_joint_on_two_other_topics_is_said_and_no_error(faulty, path):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    for topic in ("/left", "/right"):
        faulty.joints(0.0, names=("b",), positions=(0.0,), topic=topic)
    faulty.__exit__()
    text = _inspect(path, names=("a", "b"))
    assert "It can't be tracked." in text and "/left and /right" in text


def test_a_mimic_joint_is_not_missing(faulty, path):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    faulty.__exit__()
    text = InspectLog(
        filename=path,
        scene=make_small_scene(),
        joint_names=("a", "b"),
        facts=ModelFacts(mimics={"b": MimicJoint("a")}),
    )
    assert "It can be tracked" in text and "without the joints" not in text
