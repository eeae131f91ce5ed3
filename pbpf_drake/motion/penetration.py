"""Moves objects out of what they penetrate, before they are simulated.

Noise puts objects into the table and into the hand. A physics engine would
shoot them out. So they are pushed out before, along the normal of their deepest
penetration, again and again until none is deep: first out of links and of each
other, then out of fixed models. An object that stands on something is not
lifted by the robot or by another object; it slides and turns as if pushed.
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
from pbpf_drake.motion.particle_plant import ParticlePlant
from pbpf_drake.motion.push_on_support import MassDistribution, push_on_support
from pbpf_drake.shapes.contact_points import REST_DEPTH

# An object that was pushed out still penetrates by this much (in meters). Where
# it may be carried, it stays as deep as at rest, or it would fall: see
# allowed_depth.
TOUCH = 8e-5
# An object is pushed out where it is more than this many times as deep.
_TOLERANCE = 1.25
# One push is for one contact only. A box between the hand, the table and
# another box needs a few pushes.
_MAX_PUSHES = 10
# An object is not pushed back to where it was pushed from: not within 60° of
# the opposite direction. This is cos 60°.
_BACK = 0.5


@dataclass(frozen=True)
class _Penetration:
    """The deepest penetration of one particle.

    Attributes:
        particle: its index.
        objects: the indices of the two objects that penetrate each other; -1
            stands for a link or a fixed model.
        fixed: whether one of the two is a fixed model.
        normal: (3,) the direction in which the first has to move; the second
            has to move the other way.
        p_WC: (3,) where they touch (in meters).
        distance: how far they have to move apart (in meters).
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
        particle_plant: what particles are simulated in.
        contacts: finds the contacts with fixed models, of the same scene.
    """

    def __init__(
        self, particle_plant: ParticlePlant, contacts: FixedContacts
    ) -> None:
        diagram = particle_plant.diagram
        plant, scene_graph = diagram.plant(), diagram.scene_graph()
        root = diagram.CreateDefaultContext()
        self._particle_plant = particle_plant
        self._contacts = contacts
        self._plant = plant
        self._context = plant.GetMyMutableContextFromRoot(root)
        self._geometry = scene_graph.GetMyMutableContextFromRoot(root)
        self._query = scene_graph.get_query_output_port()
        # By far the most contacts are these, and FixedContacts finds them.
        scene_graph.collision_filter_manager(self._geometry).Apply(
            CollisionFilterDeclaration().ExcludeBetween(
                GeometrySet(list(particle_plant.points)),
                GeometrySet(list(particle_plant.fixed_geometries)),
            )
        )
        self._masses = MassDistribution.OfBodies(
            [plant.get_body(index) for index in particle_plant.objects]
        )

    def PushOut(self, q: np.ndarray, supports: np.ndarray) -> np.ndarray:
        """Returns q with the objects moved, (m, nq).

        Two objects that penetrate each other go half the way each, unless one
        of them would go back to where it was pushed from. An object that
        penetrates a fixed model moves along the normal, without turning.

        Args:
            q: (m, nq) the plant's positions for m particles; those of the links
                stay the same.
            supports: (m, K, 3) normals of what the objects stand on, or zeros.
        """
        q = q.copy()
        # The directions in which each object was pushed by what did not move.
        pushed = np.zeros((*supports.shape[:2], _MAX_PUSHES, 3))
        num_pushes = np.zeros(len(q), dtype=int)
        # The particles that may still have objects in links or in each other,
        # and those that moved since fixed models were last looked at. That is
        # done only when none is left of the first.
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
        """Returns the deepest penetration of each particle in the plant.

        It is by a link or another object, or by a fixed model that touches an
        object's core, or the object itself where it has no points. Points that
        penetrate fixed models are left to _FindOnFixed.
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
        """Returns the deepest penetration by fixed models of each particle."""
        contacts = self._contacts.Find(
            q[particles][:, self._particle_plant.object_q]
        )
        allowed = allowed_depth(contacts.normals[:, 2])
        excess = contacts.depths - _TOLERANCE * allowed
        order = np.argsort(excess, kind="stable")
        # The last one of a particle, which is the deepest, replaces the others.
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
        """Returns the pair that is most too deep, and how far to move it."""
        self._plant.SetPositions(self._context, q)
        query = self._query.Eval(self._geometry)
        robot = self._particle_plant.link_geometries
        deepest, most = None, 0.0
        for pair in query.ComputePointPairPenetration():
            depth, allowed = pair.depth, TOUCH
            if depth <= _TOLERANCE * TOUCH + most:
                continue
            if pair.id_A not in robot and pair.id_B not in robot:
                allowed = float(allowed_depth(pair.nhat_BA_W[2]))
            if depth - _TOLERANCE * allowed > most:
                deepest = pair, depth - allowed
                most = depth - _TOLERANCE * allowed
        return deepest

    def _Describe(
        self, particle: int, pair: PenetrationAsPointPair, distance: float
    ) -> _Penetration:
        ids, owners = (pair.id_A, pair.id_B), self._particle_plant.owners
        return _Penetration(
            particle=particle,
            objects=(owners.get(ids[0], -1), owners.get(ids[1], -1)),
            fixed=not self._particle_plant.fixed_geometries.isdisjoint(ids),
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
        """Moves objects apart, and records which way they were pushed.

        Args:
            q: (m, nq) the positions, changed.
            found: n penetrations, of different particles.
            supports: (m, K, 3) as in PushOut.
            pushed: (m, K, pushes, 3) the directions in which objects were
                pushed by what did not move, changed.
            num_pushes: (m,) how often each particle was pushed so far.
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
        # For each object that moves, which penetration it is in, and on which
        # side of it: the first or the second.
        n, side = np.nonzero(free)
        m, k, normals = m[n], objects[n, side], normals[n, side]
        fixed = np.array([p.fixed for p in found])[n]
        X_WO = m[:, None], self._particle_plant.object_q[k]
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
        depth: (...) how deep they are (in meters).
        upwards: (...) the z components of their normals.
    """
    return depth > _TOLERANCE * allowed_depth(upwards)


def allowed_depth(upwards: np.ndarray) -> np.ndarray:
    """Returns how deep objects may stay in fixed models or each other, (...).

    The steeper the normal, the more of an object's weight the contact may have
    to carry, and the deeper the object sinks in at rest.

    Args:
        upwards: (...) the z components of the normals.

    Returns:
        The depths (in meters).
    """
    return np.maximum(TOUCH, REST_DEPTH * np.abs(upwards))
