"""Finds the camera's images in a log."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pbpf_drake.bags.image_messages import to_bgr
from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_decoder import MessageDecoder
from pbpf_drake.bags.ros2_messages import (
    COMPRESSED_IMAGE,
    IMAGE,
    is_one_of,
    short_type_name,
    stamp_of,
)
from pbpf_drake.config.camera_config import CameraConfig

# An image that is older isn't what the camera sees now (in seconds).
_MAX_AGE = 1.0


@dataclass(frozen=True)
class _Taken:
    """A decoded image message, and when it was taken (in seconds)."""

    time: float
    topic: str
    type: str
    message: Any


def image_topics(topic: str) -> tuple[str, str]:
    """Returns the two topics that images are looked for on.

    Args:
        topic: the one that the scene names.
    """
    return topic, f"{topic}/compressed"


class CameraImages:
    """The images of a log's camera at given times."""

    def __init__(
        self,
        *,
        filename: str | Path,
        camera: CameraConfig,
        start_time: int,
        topic: str,
    ):
        """Makes the reader; nothing is read yet.

        Args:
            filename: of the log.
            camera: that has taken the images.
            start_time: of the log (in nanoseconds).
            topic: of sensor_msgs/Image or sensor_msgs/CompressedImage; see
                image_topics.
        """
        self._path = Path(filename).expanduser()
        self._camera = camera
        self._start_time = start_time
        self._topics = image_topics(topic)
        self._decoder = MessageDecoder()
        self._notes = LogNotes()

    def At(self, times: Iterable[float]) -> Iterator[np.ndarray | None]:
        """Yields, for each time, the last image that was taken by then.

        Args:
            times: ascending (in seconds since the log's start).

        Returns:
            Images (height, width, 3): blue, green, red; None where there is
            none that can be used, or it is more than a second old.
        """
        stream = OpenLogStream(self._path, self._topics)
        self._decoder = MessageDecoder(size=stream.size)
        taken = self._Decode(stream.Messages())
        waiting, last = next(taken, None), None
        image = None
        for time in times:
            newest = last
            while waiting is not None and waiting.time <= time:
                newest, waiting = waiting, next(taken, None)
            if newest is not None and newest is not last:
                last, image = newest, self._Image(newest)
            fresh = last is not None and time - last.time <= _MAX_AGE
            yield image if fresh else None

    def Warnings(self) -> tuple[str, ...]:
        """Returns a sentence for everything that was left out so far."""
        return self._notes.Sentences()

    def _Decode(self, messages: Iterable[RawMessage]) -> Iterator[_Taken]:
        """Yields what can be decoded, in the order of its stamps."""
        latest = -np.inf
        topic = None
        for message in messages:
            # Of the two topics, the one that has the first message is used.
            topic = topic or message.topic
            if message.topic != topic:
                continue
            taken = self._DecodeOne(message)
            if taken is not None and taken.time > latest:
                latest = taken.time
                yield taken

    def _DecodeOne(self, message: RawMessage) -> _Taken | None:
        if not is_one_of(message.type, (IMAGE, COMPRESSED_IMAGE)):
            self._LeaveOut(message.topic, f"of type {message.type!r}")
            return None
        try:
            decoded = self._decoder.Decode(message)
            stamp = stamp_of(decoded.header) or message.log_time
        except Exception:  # Damage can show in any way.
            self._LeaveOut(message.topic, "that can't be decoded")
            return None
        time = (stamp - self._start_time) / 1e9
        kind = short_type_name(message.type)
        return _Taken(time, message.topic, kind, decoded)

    def _Image(self, taken: _Taken) -> np.ndarray | None:
        try:
            image = to_bgr(taken.type, taken.message)
        except ValueError as error:
            self._LeaveOut(taken.topic, str(error))
            return None
        size = (self._camera.width, self._camera.height)
        if image.shape[1::-1] != size:
            self._LeaveOut(
                taken.topic,
                f"of {image.shape[1]} x {image.shape[0]} pixels; expected "
                f"{size[0]} x {size[1]}, as the scene's camera has",
            )
            return None
        return image

    def _LeaveOut(self, topic: str, reason: str) -> None:
        self._notes.On(topic, "image").CountLeftOut(reason)
