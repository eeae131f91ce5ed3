"""Writes logs with faults in them, for tests of reading."""

from mcap_ros2.writer import Writer

from pbpf_drake.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    header_message,
    message_definition,
)

JOINT_STATES = "/joint_states"
DETECTIONS = "/dope/detected_objects"
TRUTH = "/ground_truth/box"
SECOND = 10**9
# When the logs of these tests start (in nanoseconds).
T0 = 1000 * SECOND


class FaultyLog:
    """Writes one message after the other; times are seconds after T0."""

    def __init__(self, path):
        self._writer = Writer(str(path), chunk_size=2000)
        self._schemas = {}

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._writer.finish()

    def define(self, name, text):
        """Gives a type a definition other than this project's."""
        self._schemas[name] = self._writer.register_msgdef(name, text)

    def write(self, topic, name, message, time, *, delay=0.0, stamp=None):
        if name not in self._schemas:
            self.define(name, message_definition(name))
        log_time = T0 + round((time + delay) * SECOND)
        if stamp is None:
            stamp = T0 + round(time * SECOND)
        header = header_message(stamp=stamp, frame_id="frame")
        self._writer.write_message(
            topic,
            self._schemas[name],
            {"header": header, **message},
            log_time=log_time,
        )

    def joints(self, time, positions=(0.1, 0.2), names=("a", "b"), **kwargs):
        message = {"name": list(names), "position": list(positions)}
        if "velocity" in kwargs:
            message["velocity"] = kwargs.pop("velocity")
        self.write(JOINT_STATES, JOINT_STATE, message, time, **kwargs)

    def detection(self, time, *, name="box", q=(1, 0, 0, 0), p=(1, 2, 3), **kw):
        result = {
            "hypothesis": {"class_id": name},
            "pose": {"pose": pose(q, p)},
        }
        message = {"detections": [{"results": [result]}]}
        self.write(DETECTIONS, DETECTION_ARRAY, message, time, **kw)

    def truth(self, time, *, q=(1, 0, 0, 0), p=(1, 2, 3), **kwargs):
        self.write(TRUTH, POSE_STAMPED, {"pose": pose(q, p)}, time, **kwargs)

    def raw(self, topic, data, time):
        """Writes bytes on a topic that has a message already."""
        self._writer._writer.add_message(
            channel_id=self._writer._channel_ids[topic],
            log_time=T0 + round(time * SECOND),
            publish_time=0,
            data=data,
        )


def pose(q, p):
    """Returns a geometry_msgs/Pose; q is w, x, y, z."""
    return {
        "position": dict(zip("xyz", p, strict=True)),
        "orientation": dict(zip("wxyz", q, strict=True)),
    }
