"""The errors of estimated poses, as Section 2 of the paper defines them."""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses.quaternions import angle_between, conjugate
from pbpf_drake.results.symmetric_error import symmetric_rotation_error
from pbpf_drake.results.track_record import TrackRecord


def position_error(p: np.ndarray, p_ref: np.ndarray) -> np.ndarray:
    """Returns the Euclidean distance of positions, (...) (in meters).

    Args:
        p: (..., 3) estimated positions (in meters).
        p_ref: (..., 3) true positions p*, in the same frame.
    """
    return np.linalg.norm(np.asarray(p) - np.asarray(p_ref), axis=-1)


def rotation_error(q: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
    """Returns the smaller angle of q* q⁻¹, (...), in [0, pi] (in radians).

    Args:
        q: (..., 4) estimated unit quaternions w, x, y, z.
        q_ref: (..., 4) true unit quaternions q*, in the same frame.
    """
    # angle_between(a, b) is the angle of a⁻¹ b.
    return angle_between(conjugate(q_ref), conjugate(q))


@dataclass(frozen=True)
class ErrorTrace:
    """The errors of one object's estimates at N updates.

    Attributes:
        position: (N,) position errors (in meters), NaN where unknown.
        rotation: (N,) rotation errors (in radians), NaN where unknown.
        symmetric_rotation: (N,) the same up to the object's symmetry: the
            smallest angle to a rotation that looks like the true one. Without
            a symmetry it is ``rotation``.
    """

    position: np.ndarray
    rotation: np.ndarray
    symmetric_rotation: np.ndarray


def compute_errors(
    record: TrackRecord,
    name: str,
    truth: PoseRecord | None,
    symmetry: SymmetryConfig | None = None,
) -> ErrorTrace:
    """Compares one object's estimates with the ground truth.

    An error is known where the object is tracked and the time is within the
    span of the truth, which is never extrapolated.

    Args:
        record: what the estimator produced.
        name: one of the record's objects.
        truth: the object's ground truth, or None where there is none.
        symmetry: of the object, if it has any.
    """
    known, X, X_ref = comparable_poses(record, name, truth)
    position = np.full(len(record.times), np.nan)
    rotation = np.full(len(record.times), np.nan)
    symmetric = np.full(len(record.times), np.nan)
    q, q_ref = X[:, :4], X_ref[:, :4]
    position[known] = position_error(X[:, 4:], X_ref[:, 4:])
    rotation[known] = symmetric[known] = rotation_error(q, q_ref)
    if symmetry is not None and symmetry.axis:
        symmetric[known] = symmetric_rotation_error(q, q_ref, symmetry)
    return ErrorTrace(position, rotation, symmetric)


def comparable_poses(
    record: TrackRecord, name: str, truth: PoseRecord | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns an object's estimates where an error is known, and its truth.

    Args:
        record, name, truth: see compute_errors.

    Returns:
        Which of the N updates have a known error (N,), and the C poses there,
        estimated and true, (C, 7) each: qw qx qy qz, x y z (in meters).
    """
    k = record.object_names.index(name)
    known = np.zeros(len(record.times), dtype=bool)
    X_ref = np.empty((0, 7))
    if truth is not None and len(truth.times):
        known = np.array(record.tracked[:, k], dtype=bool)
        known &= record.times >= truth.times[0]
        known &= record.times <= truth.times[-1]
        q_ref, p_ref = interpolate_poses(truth, record.times[known])
        X_ref = np.concatenate([q_ref, p_ref], axis=-1)
    return known, record.poses[known, k], X_ref


def position_stddev(record: TrackRecord, name: str) -> np.ndarray:
    """Returns the root mean square distance of the particles to their mean.

    It is what the filter itself expects of its position error.

    Args:
        record: what the estimator produced.
        name: one of the record's objects.

    Returns:
        (N,) (in meters); NaN without particles, and while the object is not
        tracked.
    """
    return _stddev(record, name, slice(3, 6))


def rotation_stddev(record: TrackRecord, name: str) -> np.ndarray:
    """Returns the same for the rotation, (N,) (in radians)."""
    return _stddev(record, name, slice(0, 3))


def _stddev(record: TrackRecord, name: str, part: slice) -> np.ndarray:
    if record.particles.shape[1] == 0:
        return np.full(len(record.times), np.nan)
    k = record.object_names.index(name)
    covariance = record.covariances[:, k, part, part]
    stddev = np.sqrt(np.trace(covariance, axis1=-2, axis2=-1))
    return np.where(record.tracked[:, k], stddev, np.nan)
