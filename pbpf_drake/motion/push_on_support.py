"""Where a push takes what stands on something."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import RigidBody

from pbpf_drake.poses import quaternions

# An object slides along its support only if it is pushed within 45° of it. This
# is cos² 45°.
_MIN_SLIDE = 0.5


@dataclass(frozen=True)
class MassDistribution:
    """How objects resist being turned, whatever their mass.

    Attributes:
        p_OCm: (..., 3) the centres of mass in the objects' frames O (in
            meters).
        G_OCm_O: (..., 3, 3) the inertias about the centres of mass, divided
            by the mass, in O (in m²).
    """

    p_OCm: np.ndarray
    G_OCm_O: np.ndarray

    @classmethod
    def OfBodies(cls, bodies: Sequence[RigidBody]) -> "MassDistribution":
        """Returns those of K bodies, whose frames are O, (K, ...)."""
        p_OCm, G_OCm_O = (
            np.zeros((len(bodies), 3)),
            np.zeros((len(bodies), 3, 3)),
        )
        for k, body in enumerate(bodies):
            M_O = body.default_spatial_inertia()
            p_OCm[k] = M_O.get_com()
            M_Cm = M_O.Shift(M_O.get_com())
            G_OCm_O[k] = M_Cm.get_unit_inertia().CopyToFullMatrix3()
        return cls(p_OCm=p_OCm, G_OCm_O=G_OCm_O)

    def of(self, objects: np.ndarray) -> "MassDistribution":
        """Returns those of some objects, by their indices (...)."""
        return MassDistribution(
            p_OCm=self.p_OCm[objects], G_OCm_O=self.G_OCm_O[objects]
        )


def push_on_support(
    X_WO: np.ndarray,
    masses: MassDistribution,
    *,
    p_WC: np.ndarray,
    normals: np.ndarray,
    distances: np.ndarray,
    supports: np.ndarray,
) -> np.ndarray:
    """Returns where objects go that are pushed at a point each, (..., 7).

    They slide along their support and turn about its normal, as if an impulse
    acted at the point, along the normal of the push. Of all motions that take
    the point as far, this has the least kinetic energy. Without turning,
    objects that are pushed off their centres would turn less than real ones.
    An object that stands on nothing, or is pushed into its support or off it,
    is moved along the normal of the push, without turning.

    Args:
        X_WO: (..., 7): qw qx qy qz, x y z (in meters).
        masses: of the objects, (..., 3) and (..., 3, 3).
        p_WC: (..., 3) the points that are pushed (in meters).
        normals: (..., 3) where they are pushed to, unit vectors.
        distances: (...) how far they move along the normals (in meters), to
            first order.
        supports: (..., 3) normals of what the objects stand on, or zeros.
    """
    q, p_WO = X_WO[..., :4], X_WO[..., 4:]
    along = normals - _dot(normals, supports)[..., None] * supports
    share = _dot(along, along)
    slides = supports.any(axis=-1) & (share >= _MIN_SLIDE)
    axes = quaternions.rotate(quaternions.conjugate(q), supports)
    squared_radius = np.einsum("...i,...ij,...j", axes, masses.G_OCm_O, axes)
    squared_radius = np.where(slides, squared_radius, 1.0)
    p_OCm_W = quaternions.rotate(q, masses.p_OCm)
    torque = _dot(np.cross(p_WC - p_WO - p_OCm_W, along), supports)
    impulse = distances / np.where(
        slides, share + torque**2 / squared_radius, 1.0
    )
    angle = np.where(slides, impulse * torque / squared_radius, 0.0)
    turn = quaternions.from_rotation_vector(angle[..., None] * supports)
    shift = impulse[..., None] * np.where(slides[..., None], along, normals)
    # It is the centre of mass that moves by the shift.
    p_WN = p_WO + shift + p_OCm_W - quaternions.rotate(turn, p_OCm_W)
    q_N = quaternions.normalize(quaternions.multiply(turn, q))
    return np.where(
        slides[..., None],
        np.concatenate([q_N, p_WN], axis=-1),
        np.concatenate([q, p_WO + shift], axis=-1),
    )


def _dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (u * v).sum(axis=-1)
