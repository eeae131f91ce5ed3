"""Says what is in a log, what of it is used, and what is missing."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.ros2_messages import COMPRESSED_IMAGE, IMAGE, is_one_of
from pbpf_drake.config.log_topics import frame_name, is_frame
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.camera_images import image_topics
from pbpf_drake.log.detection_ages import age_summary
from pbpf_drake.log.input_usage import usage_lines
from pbpf_drake.log.joint_plan import (
    make_joint_plan,
    missing_joints,
    unlogged_joints,
)
from pbpf_drake.log.joint_topics import joint_topics
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.log_sources import LogSources
from pbpf_drake.log.log_survey import LogSurvey, SurveyLog
from pbpf_drake.log.sample_extraction import (
    DETECTION_TYPES,
    JOINT_TYPES,
    TRUTH_TYPES,
)
from pbpf_drake.model_facts import ModelFacts


def InspectLog(
    *,
    filename: str | Path,
    scene: Scene,
    joint_names: Sequence[str],
    facts: ModelFacts | None = None,
) -> str:
    """Returns a text on what is in a log, and how a scene can track it.

    Args:
        filename: see ReadLog.
        scene: see ReadLog.
        joint_names: see ReadLog.
        facts: see ReadLog.

    Raises:
        LogError: the file is no log.
    """
    path = Path(filename).expanduser()
    try:
        survey = SurveyLog(path)
    except LogError as error:
        raise LogError(f"Log {path}: {error}") from error
    log: Log | LogError
    try:
        log = ReadLog(
            filename=path, scene=scene, joint_names=joint_names, facts=facts
        )
    except LogError as error:
        log = error
    lines = [
        *_contents(path, survey),
        *_frames(survey),
        "",
        f"Of this the scene {scene.path} uses:",
        *_joints(survey, scene, joint_names, facts or ModelFacts()),
        *_poses(survey, scene, "detections", DETECTION_TYPES),
        *_detection_frames(survey, scene),
        *_poses(survey, scene, "ground_truth", TRUTH_TYPES),
        *_camera(log),
        *_images(survey, scene.topics.images),
        "",
        *_usage(log),
        *_checksums(survey),
        *_verdict(survey, log),
    ]
    return "\n".join(lines)


def _contents(path: Path, survey: LogSurvey) -> list[str]:
    topics = survey.topics.values()
    count = sum(topic.count for topic in topics)
    starts = [topic.first for topic in topics if topic.count]
    start = min(starts, default=0)
    end = max((topic.last for topic in topics if topic.count), default=0)
    rows = [("topic", "type", "messages", "first [s]", "last [s]", "per s")]
    for name, topic in sorted(survey.topics.items()):
        length = (topic.last - topic.first) / 1e9
        times = [f"{(t - start) / 1e9:.2f}" for t in (topic.first, topic.last)]
        rate = f"{(topic.count - 1) / length:.1f}" if length else "-"
        rows.append(
            (
                name,
                topic.type,
                str(topic.count),
                *(times if topic.count else ("-", "-")),
                rate,
            )
        )
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    table = [
        "  ".join(
            cell.ljust(width) if i < 2 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
    head = (
        f"{path} is {survey.kind} of {plural(count, 'message')} in "
        f"{(end - start) / 1e9:.2f} s"
    )
    return [head, "", *table] if survey.topics else [head]


def _frames(survey: LogSurvey) -> list[str]:
    if not survey.frames:
        return []
    return ["", "Frames of tf:"] + [
        f"  {parent} -> {child}: {plural(count, 'time')}"
        for (child, parent), count in sorted(
            survey.frames.items(), key=lambda item: item[0][::-1]
        )
    ]


def _joints(
    survey: LogSurvey,
    scene: Scene,
    joint_names: Sequence[str],
    facts: ModelFacts,
) -> list[str]:
    topics = scene.topics
    if topics.tf_joints:
        frames = {child for child, _ in survey.frames}
        return [
            _line(
                f"joint {joint}",
                coordinate,
                frame_name(coordinate.rpartition(".")[0]) in frames,
                sorted(frames),
            )
            for joint, coordinate in topics.tf_joints.items()
        ]
    lines = []
    found: set[str] = set()
    for source in topics.joint_topics():
        there = source in survey.joints
        found |= survey.joints.get(source, set())
        others = [t for t in _named(survey, JOINT_TYPES) if t != source]
        lines.append(_line("joint states", source, there, others))
    try:
        plan = make_joint_plan(topics, joint_names, facts.mimics)
        elsewhere = joint_topics(
            unlogged_joints(plan, found),
            {
                topic: names
                for topic, names in survey.joints.items()
                if found and topic not in topics.joint_topics()
            },
        )
    except LogError:  # The verdict says it.
        return lines
    for topic, names in elsewhere.items():
        lines.append(f"  joints {names}: {topic}")
        found |= set(names)
    missing = unlogged_joints(plan, found)
    if found and missing:
        lines[-1] += f"; {missing_joints(missing, sorted(found))}"
    return lines


def _poses(
    survey: LogSurvey, scene: Scene, role: str, types: Sequence[str]
) -> list[str]:
    sources = LogSources(scene)
    used = (
        list(sources.detections)
        if role == "detections"
        else list(sources.ground_truth.values())
    )
    frames = {child for child, _ in survey.frames}
    lines = []
    for source in dict.fromkeys(used):
        if is_frame(source):
            there, others = frame_name(source) in frames, sorted(frames)
        else:
            topic = survey.topics.get(source)
            there = topic is not None and topic.count > 0
            others = _named(survey, types)
        lines.append(_line(role.replace("_", " "), source, there, others))
    return lines


def _detection_frames(survey: LogSurvey, scene: Scene) -> list[str]:
    """Returns a line for each source on the frames of its detections."""
    return [
        f"  frames of {source}: "
        + ", ".join(repr(frame) for frame in sorted(frames))
        for source in LogSources(scene).detections
        if (frames := survey.detection_frames.get(source))
    ]


def _line(role: str, source: str, there: bool, others: Sequence[str]) -> str:
    if there:
        return f"  {role}: {source}"
    said = f"  {role}: {source} is MISSING"
    return said + (f"; there is {', '.join(others)}" if others else "")


def _named(survey: LogSurvey, types: Sequence[str]) -> list[str]:
    """Returns the topics of some types."""
    return [
        name
        for name, topic in sorted(survey.topics.items())
        if topic.count and is_one_of(topic.type, types)
    ]


def _camera(log: Log | LogError) -> list[str]:
    if isinstance(log, LogError):
        return []
    where = "the scene" if log.X_WC is None else "tf"
    return [f"  camera: where {where} says"]


def _images(survey: LogSurvey, topic: str) -> list[str]:
    """Returns a line if there are images, on whatever topic."""
    there = _named(survey, (IMAGE, COMPRESSED_IMAGE))
    used = [t for t in image_topics(topic) if t in there]
    if not there:
        return []
    return [_line("images", used[0] if used else topic, bool(used), there)]


def _usage(log: Log | LogError) -> list[str]:
    """Returns what of the input was used, and how old detections are."""
    if isinstance(log, LogError):
        return []
    lines = [f"  {line}" for line in usage_lines(log.usage)]
    for name in sorted({d.name for d in log.detections}):
        ages = [d.received - d.time for d in log.detections if d.name == name]
        lines.append(
            f"  detections of {name!r} are {age_summary(np.array(ages))}"
        )
    return ["What of it can be used:", *lines, ""]


def _checksums(survey: LogSurvey) -> list[str]:
    if survey.checksums:
        return []
    return [
        f"{survey.kind[0].upper()}{survey.kind[1:]} of this form has no "
        "checksums, or not for everything: a number that is damaged can't be "
        "told from a good one.",
        "",
    ]


def _verdict(survey: LogSurvey, log: Log | LogError) -> list[str]:
    if isinstance(log, LogError):
        return [*_list("Damage:", survey.damage), f"It can't be tracked. {log}"]
    counts = {
        name: sum(d.name == name for d in log.detections)
        for name in sorted({d.name for d in log.detections})
    }
    truths = {n: len(r.times) for n, r in log.ground_truth.items()}
    return [
        *_list("Warnings:", log.warnings),
        "It can be tracked: "
        f"{plural(len(log.joints.times), 'joint state')} in "
        f"{log.duration:.2f} s, detections {counts or 'none'}, "
        f"ground truth {truths or 'none: errors will not be known'}",
    ]


def _list(title: str, sentences: Sequence[str]) -> list[str]:
    if not sentences:
        return []
    return [title, *(f"  {sentence}" for sentence in sentences), ""]
