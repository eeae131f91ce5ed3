"""The detections of a scene's objects in a log."""

from collections.abc import Sequence

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, is_one_of
from pbpf_drake.config.log_topics import is_frame
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.detection_checks import detection_warnings
from pbpf_drake.log.detection_cleaning import (
    detections_by_object,
    make_detection_records,
)
from pbpf_drake.log.input_usage import DETECTION, InputUsage, count_usage
from pbpf_drake.log.log_frames import LogFrames
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.log.log_samples import PoseSample, RawStamped
from pbpf_drake.log.log_timeline import LogTimeline
from pbpf_drake.log.scene_samples import SceneSamples
from pbpf_drake.model_facts import ModelFacts


def detections_of_scene(
    said: SceneSamples,
    *,
    scene: Scene,
    timeline: LogTimeline,
    frames: LogFrames,
    facts: ModelFacts,
    start: int,
    usage: list[InputUsage],
) -> tuple[DetectionRecord, ...]:
    """Returns the detections that can be used, sorted by when they arrived.

    Args:
        said: what the log says; its notes count what is left out.
        scene: names the objects, and has camera and filter.
        timeline: when messages are.
        frames: where the log's frames are.
        facts: where objects are expected.
        start: what the records' times are relative to (in nanoseconds).
        usage: what was used of each source and object is added to it.
    """
    reader = _DetectionReader(scene, timeline, frames, facts, start, usage)
    found: list[DetectionRecord] = []
    for source, name in said.sources.detections.items():
        # An array names its objects, also on a topic for one of them.
        kind = said.samples.types.get(source, "")
        names_them = is_one_of(kind, (DETECTION_ARRAY,))
        found += reader.Read(
            said.sources.Poses(said.samples.poses, source),
            None if names_them else name,
            said.notes.On(source, DETECTION),
        )
    if not found:
        source = scene.topics.detections
        kind = "in" if is_frame(source) else "on the topic"
        said.notes.Add(
            f"there are no detections of {scene.object_names()} {kind} "
            f"{source}: estimates stay at the scene's nominal poses"
        )
    return tuple(sorted(found, key=lambda d: (d.received, d.time, d.name)))


class _DetectionReader:
    """What is known while the detections of one log are read."""

    def __init__(
        self,
        scene: Scene,
        timeline: LogTimeline,
        frames: LogFrames,
        facts: ModelFacts,
        start: int,
        usage: list[InputUsage],
    ):
        self._scene = scene
        self._timeline = timeline
        self._frames = frames
        self._facts = facts
        self._start = start
        self._usage = usage

    def Read(
        self,
        messages: Sequence[RawStamped[PoseSample]],
        name: str | None,
        notes: TopicNotes,
    ) -> list[DetectionRecord]:
        """Returns the detections of one source; see detections_by_object."""
        by_object = detections_by_object(
            messages,
            name=name,
            names_by_class=self._scene.object_by_class(),
            notes=notes,
        )
        found = []
        for owner, seen in by_object.items():
            found += self._DetectionsOf(seen, notes.Of(owner))
        strangers = len(messages) - sum(len(s) for s in by_object.values())
        if strangers:
            count_usage(self._usage, notes, read=strangers)
        return found

    def _DetectionsOf(
        self, seen: Sequence[RawStamped[PoseSample]], notes: TopicNotes
    ) -> list[DetectionRecord]:
        """Returns the detections of one object."""
        X_WC = self._frames.X_WC or self._scene.camera.pose()
        p_WO = self._facts.nominal.get(notes.owner)
        placed = self._timeline.Place(seen, notes)
        records = make_detection_records(
            self._frames.InCamera(placed, notes),
            name=notes.owner,
            start=self._start,
            expected=None if p_WO is None else X_WC.inverse() @ p_WO,
            notes=notes,
        )
        count_usage(self._usage, notes, read=len(seen))
        if ahead := self._timeline.AheadWarning(seen):
            notes.Add(f"detections of {notes.owner!r}: {ahead}")
        for sentence in detection_warnings(
            records, scene=self._scene, X_WC=X_WC, boxes=self._facts.boxes
        ):
            notes.Add(sentence)
        return records
