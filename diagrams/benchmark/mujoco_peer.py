"""MuJoCo's ``rollout`` as a motion model, with a model per particle.

The robot is prescribed as it is in this project's own model: its joints have
huge armatures and coast at the measured speed, whatever they touch. The
friction of an object is that of all its contacts. Solver and contact parameters
are MuJoCo's defaults.
"""

import copy
from itertools import pairwise
from xml.etree import ElementTree as xml

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.diagrams.benchmark.peer_scene import (
    PeerLink,
    PeerObject,
    PeerScene,
    PeerShape,
)
from pbpf_drake.motion.control_path import ControlPath, simplify_path
from pbpf_drake.motion.motion_model import MotionInput
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import pose_array

# The step of the physics (in seconds).
_TIME_STEP = 0.004
# So large that nothing the robot touches slows it down (in kg m² or kg).
_ARMATURE = 1e5
# How far the robot may be off its path where that is simplified (in radians or
# meters).
_PATH_TOLERANCE = 5e-4
# The bits by which MuJoCo knows what collides: objects do with everything, and
# nothing else does.
_ROBOT, _OBJECT, _FIXED = 1, 2, 4


class MuJoCoPeer:
    """Predicts particles with MuJoCo.

    Args:
        scene: what there is.
        joint_names: the robot's joints, in the order of the controls.
        num_particles: M, the number of models.
        num_threads: of the rollouts.
    """

    def __init__(
        self,
        *,
        scene: PeerScene,
        joint_names: tuple[str, ...],
        num_particles: int,
        num_threads: int,
    ) -> None:
        # Optional packages are needed only where they are used.
        import mujoco
        from mujoco.rollout import Rollout

        self._mujoco = mujoco
        model = mujoco.MjModel.from_xml_string(make_mjcf(scene))
        self._joints = [model.joint(name) for name in joint_names]
        self._robot_q = [joint.qposadr[0] for joint in self._joints]
        self._robot_v = [joint.dofadr[0] for joint in self._joints]
        free = [model.joint(o.name) for o in scene.objects]
        self._object_q = np.array(
            [np.arange(7) + joint.qposadr[0] for joint in free]
        )
        self._object_v = np.array(
            [np.arange(6) + joint.dofadr[0] for joint in free]
        )
        self._bodies = [model.body(o.name).id for o in scene.objects]
        self._inertias = [model.body_inertia[b].copy() for b in self._bodies]
        self._masses = [o.mass for o in scene.objects]
        self._models = [copy.copy(model) for _ in range(num_particles)]
        self._nq, self._nv = model.nq, model.nv
        self._data = [mujoco.MjData(model) for _ in range(num_threads)]
        # Without threads of its own, it works in the caller's.
        self._rollout = Rollout(nthread=num_threads if num_threads > 1 else 0)

    def Close(self) -> None:
        """Ends the threads."""
        self._rollout.close()

    def Reset(self, q: np.ndarray) -> None:
        """Does nothing: every update sets the robot anyway."""

    def Prepare(self, parameters: PhysicalParameters) -> None:
        """Writes θ into the models."""
        shape = (len(self._models), len(self._bodies))
        friction = np.broadcast_to(parameters.friction, shape)
        mass = np.broadcast_to(parameters.mass, shape)
        for m, model in enumerate(self._models):
            for k, body in enumerate(self._bodies):
                scale = mass[m, k] / self._masses[k]
                model.body_mass[body] = mass[m, k]
                model.body_inertia[body] = scale * self._inertias[k]
                geoms = model.geom_bodyid == body
                model.geom_friction[geoms, 0] = friction[m, k]
            # MuJoCo derives other constants from masses.
            self._mujoco.mj_setConst(model, self._data[0])

    def Update(self, motion: MotionInput) -> np.ndarray:
        """Returns the predicted poses, (M, K, 7)."""
        path = simplify_path(motion.path, _PATH_TOLERANCE)
        state = np.zeros((len(motion.poses), 1 + self._nq + self._nv))
        q, v = state[:, 1 : 1 + self._nq], state[:, 1 + self._nq :]
        self._SetObjects(motion, q, v)
        for segment in pairwise(range(len(path.times))):
            steps = self._SetRobot(path, segment, q, v)
            found, _ = self._rollout.rollout(
                self._models[: len(state)], self._data, state, nstep=steps
            )
            state[:] = found[:, -1]
        found = q[:, self._object_q]
        return np.concatenate([found[..., 3:], found[..., :3]], axis=-1)

    def _SetObjects(
        self, motion: MotionInput, q: np.ndarray, v: np.ndarray
    ) -> None:
        """Sets poses and velocities; MuJoCo turns about the body's axes."""
        poses, velocities = motion.poses, motion.velocities
        q[:, self._object_q[:, :3]] = poses[..., 4:]
        q[:, self._object_q[:, 3:]] = poses[..., :4]
        v[:, self._object_v[:, :3]] = velocities[..., 3:]
        v[:, self._object_v[:, 3:]] = quaternions.rotate(
            quaternions.conjugate(poses[..., :4]), velocities[..., :3]
        )

    def _SetRobot(
        self,
        path: ControlPath,
        segment: tuple[int, int],
        q: np.ndarray,
        v: np.ndarray,
    ) -> int:
        """Sets the robot at the start of a segment; returns its steps."""
        start, end = path.positions[list(segment)]
        duration = path.times[segment[1]] - path.times[segment[0]]
        steps = max(1, round(duration / _TIME_STEP))
        q[:, self._robot_q] = start
        v[:, self._robot_v] = (end - start) / (steps * _TIME_STEP)
        return steps


def make_mjcf(scene: PeerScene) -> str:
    """Returns the scene as MuJoCo's XML.

    An object's body and its free joint have the object's name, the robot's
    joints have their own.
    """
    root = xml.Element("mujoco")
    xml.SubElement(root, "compiler", angle="radian")
    xml.SubElement(root, "option", timestep=str(_TIME_STEP))
    world = xml.SubElement(root, "worldbody")
    for shape in scene.fixed:
        _add_geom(world, shape, _FIXED)
    for link in scene.links:
        if not link.parent:
            _add_link(world, link, scene)
    for item in scene.objects:
        _add_object(world, item)
    return xml.tostring(root, encoding="unicode")


def _add_object(world: xml.Element, item: PeerObject) -> None:
    body = xml.SubElement(world, "body", name=item.name)
    xml.SubElement(body, "freejoint", name=item.name)
    inertia = item.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    xml.SubElement(
        body,
        "inertial",
        pos="0 0 0",
        mass=str(item.mass),
        fullinertia=_join(inertia),
    )
    for shape in item.shapes:
        geom = _add_geom(body, shape, _OBJECT, _ROBOT | _OBJECT | _FIXED)
        # So that the object's friction counts, not the larger one of the two.
        geom.set("priority", "1")


def _add_link(parent: xml.Element, link: PeerLink, scene: PeerScene) -> None:
    body = xml.SubElement(parent, "body", _pose(link.X_PB), name=link.name)
    if link.joint:
        xml.SubElement(
            body,
            "joint",
            name=link.joint,
            type="slide" if link.slides else "hinge",
            axis=_join(link.axis),
            pos=_join(link.p_BJ),
            armature=str(_ARMATURE),
        )
    # Their inertias don't matter beside the armatures.
    xml.SubElement(
        body, "inertial", pos="0 0 0", mass="1", diaginertia="0.01 0.01 0.01"
    )
    for shape in link.shapes:
        _add_geom(body, shape, _ROBOT)
    for child in scene.links:
        if child.parent == link.name:
            _add_link(body, child, scene)


def _add_geom(
    body: xml.Element, shape: PeerShape, group: int, others: int = 0
) -> xml.Element:
    """Adds a shape; MuJoCo wants halves of lengths."""
    size = np.array(shape.size)
    size = size / 2 if shape.kind == "box" else size * [1, 0.5][: len(size)]
    return xml.SubElement(
        body,
        "geom",
        _pose(shape.X_BG),
        type=shape.kind,
        size=_join(size),
        contype=str(group),
        conaffinity=str(others),
    )


def _pose(X: RigidTransform) -> dict[str, str]:
    pose = pose_array(X)
    return {"quat": _join(pose[:4]), "pos": _join(pose[4:])}


def _join(values: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in values)
