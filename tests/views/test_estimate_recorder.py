from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from pbpf_drake.views.estimate_recorder import (
    AddEstimateRecorder,
    EstimateRecorder,
)

M, NAMES, PERIOD = 3, ("box", "can"), 0.25
START_TIME = 1_700_000_000_000_000_000
POSES = [
    RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0]),
    RigidTransform(RollPitchYaw(-0.4, 0.5, 2.0), [4.0, 5.0, 6.0]),
]
COVARIANCES = np.arange(72.0).reshape(2, 6, 6)
PARTICLES = np.arange(42.0).reshape(M, 2, 7)


class _Estimator(LeafSystem):
    """Gives constant estimates, a new one every PERIOD."""

    def __init__(self, *, particles=True, poses=POSES):
        super().__init__()
        self.DeclareAbstractOutputPort(
            name="estimated_poses",
            alloc=lambda: Value([RigidTransform()]),
            calc=lambda context, output: output.set_value(poses),
        )
        index = self.DeclareDiscreteState([-1.0])
        self.DeclareStateOutputPort("update_time", index)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=PERIOD, offset_sec=PERIOD, update=self._Update
        )
        if particles:
            for name, value in (
                ("covariances", COVARIANCES),
                ("particles", PARTICLES),
            ):
                self.DeclareVectorOutputPort(
                    name=name,
                    size=value.size,
                    calc=lambda context, output, value=value: (
                        output.SetFromVector(value.ravel())
                    ),
                )

    def _Update(self, context, discrete_state):
        discrete_state.set_value(0, [context.get_time()])


def _run(path, *, duration=1.1, period=0.1, **kwargs):
    builder = DiagramBuilder()
    estimator = builder.AddSystem(_Estimator(**kwargs))
    recorder = AddEstimateRecorder(
        builder=builder,
        filter=estimator,
        filename=path,
        object_names=NAMES,
        num_particles=M if kwargs.get("particles", True) else 0,
        period=period,
        start_time=START_TIME,
    )
    with recorder:
        Simulator(builder.Build()).AdvanceTo(duration)
    return recorder


def _messages(path, topic):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        return list(reader.iter_decoded_messages(topics=[topic]))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorder") / "estimates.mcap"
    _run(path)
    return path


@pytest.mark.parametrize("kind", ["estimate", "particles"])
@pytest.mark.parametrize("name", NAMES)
def test_every_update_is_written_once(path, kind, name):
    found = _messages(path, f"/pbpf/{kind}/{name}")
    expected = [START_TIME + i * 250_000_000 for i in (1, 2, 3, 4)]
    assert [m.message.log_time for m in found] == expected
    for m, time in zip(found, expected, strict=True):
        header = m.decoded_message.header
        assert header.stamp.sec * 10**9 + header.stamp.nanosec == time
        assert header.frame_id == "world"


@pytest.mark.parametrize("k", [0, 1])
def test_estimates_field_by_field(path, k):
    found = _messages(path, f"/pbpf/estimate/{NAMES[k]}")[0]
    assert found.schema.name == "geometry_msgs/msg/PoseWithCovarianceStamped"
    pose = found.decoded_message.pose.pose
    q, p = pose.orientation, pose.position
    assert [p.x, p.y, p.z] == POSES[k].translation().tolist()
    expected = POSES[k].rotation().ToQuaternion().wxyz()
    assert [q.w, q.x, q.y, q.z] == expected.tolist()
    covariance = np.reshape(found.decoded_message.pose.covariance, (6, 6))
    # ROS: x, y, z, then the rotation; here the rotation is first.
    c = COVARIANCES[k]
    expected = np.block([[c[3:, 3:], c[3:, :3]], [c[:3, 3:], c[:3, :3]]])
    np.testing.assert_array_equal(covariance, expected)


@pytest.mark.parametrize("k", [0, 1])
def test_particles_field_by_field(path, k):
    found = _messages(path, f"/pbpf/particles/{NAMES[k]}")[0]
    assert found.schema.name == "geometry_msgs/msg/PoseArray"
    poses = [
        [o.w, o.x, o.y, o.z, p.x, p.y, p.z]
        for o, p in (
            (pose.orientation, pose.position)
            for pose in found.decoded_message.poses
        )
    ]
    np.testing.assert_array_equal(poses, PARTICLES[:, k])


def test_an_estimator_without_particles_is_recorded(tmp_path):
    path = tmp_path / "estimates.mcap"
    _run(path, particles=False)
    found = _messages(path, "/pbpf/estimate/box")
    assert len(found) == 4
    assert not np.any(found[0].decoded_message.pose.covariance)
    assert _messages(path, "/pbpf/particles/box") == []


def test_before_the_first_update_nothing_is_written_and_the_file_is_whole(
    tmp_path,
):
    path = tmp_path / "estimates.mcap"
    _run(path, duration=0.2)
    assert _messages(path, "/pbpf/estimate/box") == []


def test_a_publish_by_force_writes_the_last_update(tmp_path):
    path = tmp_path / "estimates.mcap"
    builder = DiagramBuilder()
    estimator = builder.AddSystem(_Estimator())
    with AddEstimateRecorder(
        builder=builder,
        filter=estimator,
        filename=path,
        object_names=NAMES,
        num_particles=M,
        period=100.0,
    ):
        diagram = builder.Build()
        simulator = Simulator(diagram)
        simulator.AdvanceTo(0.3)
        diagram.ForcedPublish(simulator.get_context())
        diagram.ForcedPublish(simulator.get_context())
    (found,) = _messages(path, "/pbpf/estimate/box")
    assert found.message.log_time == 250_000_000


def test_a_wrong_number_of_poses_is_refused(tmp_path):
    with pytest.raises(ValueError, match="1 poses; expected one for each of"):
        _run(tmp_path / "estimates.mcap", poses=POSES[:1])


def test_nothing_can_be_published_after_it_was_closed(tmp_path):
    recorder = _run(tmp_path / "estimates.mcap")
    recorder.Close()
    context = recorder.CreateDefaultContext()
    recorder.GetInputPort("estimated_poses").FixValue(context, Value(POSES))
    recorder.GetInputPort("update_time").FixValue(context, [9.0])
    with pytest.raises(RuntimeError, match="closed"):
        recorder.ForcedPublish(context)


def test_time_may_be_given_by_any_source(tmp_path):
    """The ports are plain vectors: any system can feed them."""
    path = tmp_path / "estimates.mcap"
    builder = DiagramBuilder()
    recorder = builder.AddSystem(
        EstimateRecorder(
            filename=path, object_names=["box"], num_particles=0, period=0.1
        )
    )
    source = builder.AddSystem(ConstantVectorSource([0.0]))
    builder.Connect(
        source.get_output_port(), recorder.GetInputPort("update_time")
    )
    poses = builder.AddSystem(_Estimator(particles=False, poses=POSES[:1]))
    builder.Connect(
        poses.GetOutputPort("estimated_poses"),
        recorder.GetInputPort("estimated_poses"),
    )
    with recorder:
        Simulator(builder.Build()).AdvanceTo(1.0)
    (found,) = _messages(path, "/pbpf/estimate/box")
    assert found.message.log_time == 0
