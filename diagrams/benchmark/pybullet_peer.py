"""PyBullet as a motion model, as the paper's authors used it.

Each particle has a world of its own with PyBullet's stock Panda, which position
control drives towards the joints' positions at the end of the period. A world
makes 14 steps of 1/90 s per update; before that, the object's pose and velocity
are set and θ is written. The worlds are spread over processes.
"""

from collections.abc import Sequence
import multiprocessing
from multiprocessing.connection import Connection
from typing import Any
from xml.etree import ElementTree as xml

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from pbpf_drake.diagrams.benchmark.peer_scene import PeerScene, PeerShape
from pbpf_drake.diagrams.benchmark.pybullet_worlds import (
    ServeWorlds,
    WorldSetup,
)
from pbpf_drake.motion.motion_model import MotionInput
from pbpf_drake.motion.physical_parameters import PhysicalParameters

# Each world takes 41 MB.
MAX_WORLDS = 300


class PyBulletPeer:
    """Predicts particles with PyBullet.

    Args:
        scene: what there is; its robot is replaced by the stock Panda.
        joint_names: the robot's joints, in the order of the controls.
        num_particles: M, the number of worlds.
        num_processes: that they are spread over.
    """

    def __init__(
        self,
        *,
        scene: PeerScene,
        joint_names: tuple[str, ...],
        num_particles: int,
        num_processes: int,
    ) -> None:
        shares = np.array_split(np.arange(num_particles), num_processes)
        self._shares = [slice(s[0], s[-1] + 1) for s in shares if len(s)]
        self._shape = (num_particles, len(scene.objects))
        context = multiprocessing.get_context("spawn")
        self._pipes: list[Connection] = []
        self._processes = []
        for seed, share in enumerate(self._shares):
            setup = WorldSetup(
                objects=tuple(
                    make_urdf(o.name, o.shapes, mass=o.mass)
                    for o in scene.objects
                ),
                fixed=make_urdf("fixed", scene.fixed, mass=0.0),
                joint_names=joint_names,
                num_worlds=share.stop - share.start,
                seed=seed,
            )
            ours, theirs = context.Pipe()
            process = context.Process(
                target=ServeWorlds, args=(theirs, setup), daemon=True
            )
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)
        self._Receive()

    def Close(self) -> None:
        """Ends the processes."""
        for pipe in self._pipes:
            pipe.send(None)
        for process in self._processes:
            process.join()

    def Reset(self, q: np.ndarray) -> None:
        """Puts the robot of all worlds somewhere, at rest.

        Args:
            q: (n,) its joints (in radians or meters).
        """
        for pipe in self._pipes:
            pipe.send(("Reset", q))
        self._Receive()

    def Prepare(self, parameters: PhysicalParameters) -> None:
        """Notes θ; it is written in the next update, as the authors do."""
        self._theta = np.stack(
            [
                np.broadcast_to(value, self._shape)
                for value in (parameters.friction, parameters.mass)
            ],
            axis=-1,
        )

    def Update(self, motion: MotionInput) -> np.ndarray:
        """Returns the predicted poses, (M, K, 7)."""
        target = motion.path.positions[-1]
        for pipe, share in zip(self._pipes, self._shares, strict=True):
            arrays = (a[share] for a in (motion.poses, motion.velocities))
            pipe.send(("Update", target, *arrays, self._theta[share]))
        return np.concatenate(self._Receive())

    def _Receive(self) -> list[Any]:
        return [pipe.recv() for pipe in self._pipes]


def make_urdf(name: str, shapes: Sequence[PeerShape], *, mass: float) -> str:
    """Returns a body as URDF; PyBullet finds its inertia by its shapes.

    Args:
        name: of the model and its link.
        shapes: its collision shapes.
        mass: in kilograms; 0 is a fixed body, with the friction coefficient
            of 1 that PyBullet's plane has.
    """
    robot = xml.Element("robot", name=name)
    link = xml.SubElement(robot, "link", name=name)
    inertial = xml.SubElement(link, "inertial")
    xml.SubElement(inertial, "mass", value=str(mass))
    unused = dict.fromkeys(("ixx", "iyy", "izz"), "1")
    xml.SubElement(inertial, "inertia", unused, ixy="0", ixz="0", iyz="0")
    contact = xml.SubElement(link, "contact")
    xml.SubElement(contact, "lateral_friction", value="1")
    for shape in shapes:
        collision = xml.SubElement(link, "collision")
        xml.SubElement(collision, "origin", _origin(shape.X_BG))
        geometry = xml.SubElement(collision, "geometry")
        xml.SubElement(geometry, shape.kind, _size(shape))
    return xml.tostring(robot, encoding="unicode")


def _origin(X: RigidTransform) -> dict[str, str]:
    rpy = RollPitchYaw(X.rotation()).vector()
    return {"xyz": _join(X.translation()), "rpy": _join(rpy)}


def _size(shape: PeerShape) -> dict[str, str]:
    if shape.kind == "box":
        return {"size": _join(shape.size)}
    return dict(zip(("radius", "length"), map(str, shape.size), strict=False))


def _join(values: Sequence[float] | np.ndarray) -> str:
    # Without the sign of zeros.
    return " ".join(repr(float(x) + 0.0) for x in values)
