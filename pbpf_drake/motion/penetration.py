"""Moves objects out of what they penetrate, before they are simulated.

Noise puts particles into the table and into the hand. A physics engine would
shoot them out. Here they are pushed out instead, along the normal of the
deepest penetration, until nothing is deep: first by links and each other, then
by fixed models. What stands on something is not lifted by the robot or by
another object, but slid and turned as by a push.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometrySet,
    PenetrationAsPointPair,
)

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.particle_plant import ContactModel
from pbpf_drake.motion.push_on_support import MassDistribution, push_on_support
from pbpf_drake.shapes.contact_points import REST_DEPTH

# What is left of a penetration (in meters). Of one by what may carry an object
# it is that of an object at rest, or it would fall.
TOUCH = 8e-5
# What is deeper than this times as much is pushed out.
_TOLERANCE = 1.25
# Each push makes some way for one contact; a box between hand, table and
# another box needs a few.
_MAX_PUSHES = 10
# What was pushed isn't pushed back: within 60° of it.
_BACK = 0.5


@dataclass(frozen=True)
class _Penetration:
    """The deepest of one particle.

    Attributes:
        particle: its index.
        objects: the two that penetrate; -1 for a link or a fixed model.
        fixed: whether one of them is a fixed model.
        normal: (3,) where the first goes; the second goes the other way.
        p_WC: (3,) where they touch (in meters).
        distance: the way that they have to go apart (in meters).
    """

    particle: int
    objects: tuple[int, int]
    fixed: bool
    normal: np.ndarray
    p_WC: np.ndarray
    distance: float


class PenetrationResolver:
    """Moves objects out of links, fixed models and each other.

    Args:
        model: the contact model.
        contacts: of the same scene.
    """

    def __init__(self, model: ContactModel, contacts: FixedContacts) -> None:
        plant, scene_graph = model.diagram.plant(), model.diagram.scene_graph()
        root = model.diagram.CreateDefaultContext()
        self._model = model
        self._contacts = contacts
        self._plant = plant
        self._context = plant.GetMyMutableContextFromRoot(root)
        self._geometry = scene_graph.GetMyMutableContextFromRoot(root)
        self._query = scene_graph.get_query_output_port()
        # Of these, most by far, FixedContacts knows.
        scene_graph.collision_filter_manager(self._geometry).Apply(
            CollisionFilterDeclaration().ExcludeBetween(
                GeometrySet(list(model.points)),
                GeometrySet(list(model.fixed_geometries)),
            )
        )
        self._masses = MassDistribution.OfBodies(
            [plant.get_body(index) for index in model.objects]
        )

    def PushOut(self, q: np.ndarray, supports: np.ndarray) -> np.ndarray:
        """Returns q with the objects moved, (m, nq).

        Of two objects that penetrate, each goes half the way, unless one of
        them would go back to where it was pushed from. What penetrates a fixed
        model is moved along the normal and keeps its rotation.

        Args:
            q: (m, nq) positions of the model's plant in m particles; the
                links' are kept.
            supports: (m, K, 3) normals of what the objects stand on, or zeros.
        """
        q = q.copy()
        # Where each object was pushed to by what doesn't give way.
        pushed = np.zeros((*supports.shape[:2], _MAX_PUSHES, 3))
        num_pushes = np.zeros(len(q), dtype=int)
        # Which may still be in links or objects, and which have moved since the
        # fixed models were looked at. These wait until none of those is left.
        left, moved = list(range(len(q))), set(range(len(q)))
        while left or moved:
            found = self._FindPairs(q, left)
            if not found:
                found = self._FindOnFixed(q, sorted(moved))
                moved.clear()
            found = [p for p in found if num_pushes[p.particle] < _MAX_PUSHES]
            left = [p.particle for p in found]
            if found:
                self._Push(q, found, supports, pushed, num_pushes)
                num_pushes[left] += 1
                moved.update(left)
        return q

    def _FindPairs(
        self, q: np.ndarray, particles: Sequence[int]
    ) -> list[_Penetration]:
        """Returns each particle's deepest one that FixedContacts doesn't know.

        It is one by a link or by another object, or one by a fixed model that
        touches an object's core, or its shape where that has no points.
        """
        found = []
        for particle in particles:
            deepest = self._DeepestPair(q[particle])
            if deepest is not None:
                found.append(self._Describe(particle, *deepest))
        return found

    def _FindOnFixed(
        self, q: np.ndarray, particles: Sequence[int]
    ) -> list[_Penetration]:
        """Returns each particle's deepest one by a fixed model."""
        contacts = self._contacts.Find(q[particles][:, self._model.object_q])
        allowed = allowed_depth(contacts.normals[:, 2])
        excess = contacts.depths - _TOLERANCE * allowed
        order = np.argsort(excess, kind="stable")
        # Of each particle's, the last counts.
        deepest = dict(zip(contacts.particles[order], order, strict=True))
        return [
            _Penetration(
                particle=particles[m],
                objects=(int(contacts.objects[i]), -1),
                fixed=True,
                normal=contacts.normals[i],
                p_WC=contacts.points[i],
                distance=contacts.depths[i] - allowed[i],
            )
            for m, i in deepest.items()
            if excess[i] > 0
        ]

    def _DeepestPair(
        self, q: np.ndarray
    ) -> tuple[PenetrationAsPointPair, float] | None:
        """Returns the pair that is too deep by the most, and its way out."""
        self._plant.SetPositions(self._context, q)
        query = self._query.Eval(self._geometry)
        links = self._model.link_geometries
        deepest, most = None, 0.0
        for pair in query.ComputePointPairPenetration():
            depth, allowed = pair.depth, TOUCH
            if depth <= _TOLERANCE * TOUCH + most:
                continue
            if pair.id_A not in links and pair.id_B not in links:
                allowed = float(allowed_depth(pair.nhat_BA_W[2]))
            if depth - _TOLERANCE * allowed > most:
                deepest = pair, depth - allowed
                most = depth - _TOLERANCE * allowed
        return deepest

    def _Describe(
        self, particle: int, pair: PenetrationAsPointPair, distance: float
    ) -> _Penetration:
        ids, owners = (pair.id_A, pair.id_B), self._model.owners
        return _Penetration(
            particle=particle,
            objects=(owners.get(ids[0], -1), owners.get(ids[1], -1)),
            fixed=not self._model.fixed_geometries.isdisjoint(ids),
            normal=pair.nhat_BA_W,
            p_WC=(pair.p_WCa + pair.p_WCb) / 2,
            distance=distance,
        )

    def _Push(
        self,
        q: np.ndarray,
        found: list[_Penetration],
        supports: np.ndarray,
        pushed: np.ndarray,
        num_pushes: np.ndarray,
    ) -> None:
        """Moves what penetrates, and notes what can't go back any more.

        Args:
            q: (m, nq) changed.
            found: n penetrations, of different particles.
            supports: (m, K, 3) as in PushOut.
            pushed: (m, K, pushes, 3) changed.
            num_pushes: (m,) so far.
        """
        m = np.array([p.particle for p in found])
        objects = np.array([p.objects for p in found])
        normals = np.array([[p.normal, -p.normal] for p in found])
        is_object = objects >= 0
        ways = pushed[m[:, None], objects]
        back = np.einsum("nspi,nsi->nsp", ways, normals).min(axis=2) <= -_BACK
        free = is_object & ~back
        free = np.where(free.any(axis=1, keepdims=True), free, is_object)
        num_free = free.sum(axis=1)
        # Of each object that moves: its penetration, and which side it is.
        n, side = np.nonzero(free)
        m, k, normals = m[n], objects[n, side], normals[n, side]
        fixed = np.array([p.fixed for p in found])[n]
        X_WO = m[:, None], self._model.object_q[k]
        q[X_WO] = push_on_support(
            q[X_WO],
            self._masses.of(k),
            p_WC=np.array([p.p_WC for p in found])[n],
            normals=normals,
            distances=(np.array([p.distance for p in found]) / num_free)[n],
            supports=np.where(fixed[:, None], 0.0, supports[m, k]),
        )
        alone = num_free[n] == 1
        pushed[m[alone], k[alone], num_pushes[m[alone]]] = normals[alone]


def is_too_deep(depth: np.ndarray, upwards: np.ndarray) -> np.ndarray:
    """Returns which penetrations by fixed models or objects are too deep.

    Args:
        depth: (...) of the penetrations (in meters).
        upwards: (...) the z components of their normals.
    """
    return depth > _TOLERANCE * allowed_depth(upwards)


def allowed_depth(upwards: np.ndarray) -> np.ndarray:
    """Returns how deep fixed models or objects may be left (in meters).

    Args:
        upwards: (...) the z components of the normals.
    """
    return np.maximum(TOUCH, REST_DEPTH * np.abs(upwards))
