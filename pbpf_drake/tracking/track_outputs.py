"""Everything that pbpf-track writes of a run: the report first.

What can't be made after the report costs only itself.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.camera_images import CameraImages
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.diagnostic_plot import PlotDiagnostics
from pbpf_drake.results.error_plot import PlotErrors
from pbpf_drake.results.input_usage import UsageRow
from pbpf_drake.results.report import MakeReport, WriteErrors, WriteReport
from pbpf_drake.results.track_diagnostics import MakeDiagnostics
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.tracking.track_replay import WriteReplay
from pbpf_drake.tracking.write_track import WriteTrack

REPORT = "report.json"
ERRORS = "errors.csv"
ERROR_PLOT = "errors.png"
DIAGNOSTIC_PLOT = "diagnostics.png"
ESTIMATES = "estimates.mcap"
VIDEO = "overlay.mp4"
REPLAY = "replay.html"
# All files, in the order in which they are written.
OUTPUTS = (
    REPORT,
    ERRORS,
    ESTIMATES,
    VIDEO,
    ERROR_PLOT,
    DIAGNOSTIC_PLOT,
    REPLAY,
)


@dataclass(frozen=True)
class TrackedLog:
    """A log, and what was made of it.

    Attributes:
        scene: of the log.
        log: what was tracked.
        filename: the log's file, which has the camera's images.
        config: of the filter.
        records: of one or more methods, the main one first.
        usage: how much of the input was used, see results.input_usage.
        warnings: one sentence for everything that was left out.
        interrupted: whether only a part of the log was tracked.
    """

    scene: Scene
    log: Log
    filename: Path
    config: ParticleFilterConfig
    records: Sequence[TrackRecord]
    usage: Sequence[UsageRow] = ()
    warnings: tuple[str, ...] = ()
    interrupted: bool = False


@dataclass(frozen=True)
class WrittenOutputs:
    """What became of the files.

    Attributes:
        report: what report.json holds.
        failures: a sentence for each of the files that couldn't be made.
    """

    report: dict[str, Any]
    failures: tuple[str, ...]


def WriteOutputs(tracked: TrackedLog, folder: Path) -> WrittenOutputs:
    """Writes all files of a run; of an interrupted one without pictures.

    First, files of the same names that are there already are deleted. The
    report is written at once, and again at the end with what happened since.

    Args:
        tracked: the run.
        folder: where to write; it must exist.

    Raises:
        OSError: the report can't be written.
    """
    for name in OUTPUTS:
        (folder / name).unlink(missing_ok=True)
    _write_report(tracked, folder, tracked.warnings)
    writing = _Writing(folder)
    warnings = tracked.warnings + _write_rest(tracked, writing)
    report = _write_report(tracked, folder, (*warnings, *writing.failures))
    return WrittenOutputs(report, tuple(writing.failures))


def _write_report(
    tracked: TrackedLog, folder: Path, warnings: Sequence[str]
) -> dict[str, Any]:
    report = MakeReport(
        tracked.records,
        tracked.log.ground_truth,
        warnings,
        symmetries=_symmetries(tracked.scene),
        usage=tracked.usage,
        interrupted=tracked.interrupted,
    )
    WriteReport(report, folder / REPORT)
    return report


def _symmetries(scene: Scene) -> dict[str, Any]:
    return {name: o.symmetry for name, o in scene.tracked.items()}


class _Writing:
    """Writes files, each as if it were the only one."""

    def __init__(self, folder: Path):
        self._folder = folder
        self.failures: list[str] = []

    def Try(self, name: str, write: Callable[[Path], object]) -> None:
        """Writes a file, or notes why that wasn't possible.

        Args:
            name: of the file.
            write: writes it; what a failed attempt leaves is deleted.
        """
        path = self._folder / name
        try:
            write(path)
        except BaseException as error:
            path.unlink(missing_ok=True)
            if not isinstance(error, Exception):
                raise
            reason = " ".join(str(error).split()) or type(error).__name__
            self.failures.append(f"{name} couldn't be written: {reason}")


def _write_rest(tracked: TrackedLog, writing: _Writing) -> tuple[str, ...]:
    """Writes all but the report; returns warnings on the camera's images."""
    truth = tracked.log.ground_truth
    symmetries = _symmetries(tracked.scene)
    records = tracked.records
    writing.Try(
        ERRORS, lambda path: WriteErrors(records, truth, path, symmetries)
    )
    image_warnings = _write_track(tracked, writing)
    if tracked.interrupted:
        return image_warnings
    writing.Try(
        ERROR_PLOT, lambda path: PlotErrors(records, truth, path, symmetries)
    )
    writing.Try(DIAGNOSTIC_PLOT, lambda path: _plot_diagnostics(tracked, path))
    writing.Try(
        REPLAY,
        lambda path: WriteReplay(
            scene=tracked.scene,
            log=tracked.log,
            record=records[0],
            filename=path,
        ),
    )
    return image_warnings


def _write_track(tracked: TrackedLog, writing: _Writing) -> tuple[str, ...]:
    images = CameraImages(
        filename=tracked.filename,
        topic=tracked.scene.topics.images,
        camera=tracked.scene.camera,
        start_time=tracked.log.start_time,
    )
    record = tracked.records[0]
    pictures = {}
    if not tracked.interrupted:
        pictures = {"images": images.At(record.times)}

    def write(path: Path) -> None:
        failures = WriteTrack(
            scene=tracked.scene,
            log=tracked.log,
            record=record,
            mcap_filename=path,
            video_filename=path.with_name(VIDEO),
            **pictures,
        )
        writing.failures.extend(failures)

    writing.Try(ESTIMATES, write)
    return images.Warnings()


def _plot_diagnostics(tracked: TrackedLog, path: Path) -> None:
    record = tracked.records[0]
    diagnostics = MakeDiagnostics(
        scene=tracked.scene,
        joints=tracked.log.joints,
        record=record,
        config=tracked.config,
    )
    PlotDiagnostics(record, diagnostics, tracked.log.ground_truth, path)
