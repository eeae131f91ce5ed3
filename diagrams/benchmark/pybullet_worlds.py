"""PyBullet worlds in a process of their own; see pybullet_peer."""

from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
import os
from pathlib import Path
import tempfile
from typing import Any

import numpy as np

_STEPS, _TIME_STEP = 14, 1 / 90
# Where the authors load the Panda (in meters).
_BASE = (0.0, 0.0, 0.02)


@dataclass(frozen=True)
class WorldSetup:
    """What a process needs to make its worlds.

    Attributes:
        objects: the K objects as URDF.
        fixed: all that is fixed as URDF.
        joint_names: the robot's joints, in the order of the controls.
        num_worlds: of this process.
        seed: of the parameters that only PyBullet has.
    """

    objects: tuple[str, ...]
    fixed: str
    joint_names: tuple[str, ...]
    num_worlds: int
    seed: int


def ServeWorlds(pipe: Connection, setup: WorldSetup) -> None:
    """Makes worlds and does as it is told: what a process is for.

    Args:
        pipe: gets the name and the arguments of methods of the worlds, and
            None at the end; returns what these return.
        setup: what to make.
    """
    worlds = _Worlds(setup)
    pipe.send(None)
    while command := pipe.recv():
        name, *arguments = command
        pipe.send(getattr(worlds, name)(*arguments))


def _import_pybullet() -> Any:
    """Imports PyBullet without the line that it then writes to stderr.

    Optional packages are needed only where they are used.
    """
    stderr = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        try:
            import pybullet
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)
    return pybullet


class _Worlds:
    """The worlds of one process."""

    def __init__(self, setup: WorldSetup) -> None:
        self._bullet = _import_pybullet()
        self._rng = np.random.default_rng(setup.seed)
        with tempfile.TemporaryDirectory() as folder:
            files = []
            for i, text in enumerate((setup.fixed, *setup.objects)):
                files.append(str(Path(folder) / f"{i}.urdf"))
                Path(files[-1]).write_text(text, encoding="utf-8")
            worlds = [self._MakeWorld(files) for _ in range(setup.num_worlds)]
        self._clients = [client for client, _, _ in worlds]
        self._panda = worlds[0][1]
        self._objects = worlds[0][2]
        self._joints = self._FindJoints(setup.joint_names)

    def _MakeWorld(self, files: Sequence[str]) -> tuple[int, int, list[int]]:
        import pybullet_data

        bullet = self._bullet
        client = bullet.connect(bullet.DIRECT)
        bullet.setTimeStep(_TIME_STEP, physicsClientId=client)
        bullet.setGravity(0, 0, -9.81, physicsClientId=client)
        folder = Path(pybullet_data.getDataPath())
        panda = bullet.loadURDF(
            str(folder / "franka_panda" / "panda.urdf"),
            _BASE,
            useFixedBase=True,
            # Nothing looks; pictures are more than half of the memory.
            flags=bullet.URDF_IGNORE_VISUAL_SHAPES,
            physicsClientId=client,
        )
        bullet.loadURDF(files[0], useFixedBase=True, physicsClientId=client)
        objects = [
            bullet.loadURDF(file, physicsClientId=client) for file in files[1:]
        ]
        return client, panda, objects

    def _FindJoints(self, names: Sequence[str]) -> list[int]:
        bullet, client = self._bullet, self._clients[0]
        count = bullet.getNumJoints(self._panda, physicsClientId=client)
        found = {
            bullet.getJointInfo(self._panda, j, physicsClientId=client)[1]: j
            for j in range(count)
        }
        return [found[name.encode()] for name in names]

    def Reset(self, q: np.ndarray) -> None:
        """Puts the robot somewhere, at rest."""
        for client in self._clients:
            for joint, position in zip(self._joints, q, strict=True):
                self._bullet.resetJointState(
                    self._panda, joint, position, physicsClientId=client
                )

    def Update(
        self,
        target: np.ndarray,
        poses: np.ndarray,
        velocities: np.ndarray,
        theta: np.ndarray,
    ) -> np.ndarray:
        """Predicts the particles of this process; returns their poses."""
        found = np.empty_like(poses)
        for m, client in enumerate(self._clients):
            for k, body in enumerate(self._objects):
                self._SetTheta(client, body, theta[m, k])
                self._SetState(client, body, poses[m, k], velocities[m, k])
            self._Step(client, target)
            for k, body in enumerate(self._objects):
                found[m, k] = self._GetPose(client, body)
        return found

    def _SetTheta(self, client: int, body: int, theta: np.ndarray) -> None:
        """Writes θ; the rest of it is the authors' own distribution."""
        friction, mass = theta
        spinning, rolling = np.maximum(self._rng.normal(0.1, 0.3, 2), 0.001)
        self._bullet.changeDynamics(
            body,
            -1,
            mass=mass,
            lateralFriction=friction,
            spinningFriction=spinning,
            rollingFriction=rolling,
            restitution=self._rng.normal(0.9, 0.2),
            physicsClientId=client,
        )

    def _SetState(
        self, client: int, body: int, pose: np.ndarray, velocity: np.ndarray
    ) -> None:
        self._bullet.resetBasePositionAndOrientation(
            body, pose[4:], np.roll(pose[:4], -1), physicsClientId=client
        )
        self._bullet.resetBaseVelocity(
            body, velocity[3:], velocity[:3], physicsClientId=client
        )

    def _Step(self, client: int, target: np.ndarray) -> None:
        bullet = self._bullet
        for _ in range(_STEPS):
            for joint, position in zip(self._joints, target, strict=True):
                bullet.setJointMotorControl2(
                    self._panda,
                    joint,
                    bullet.POSITION_CONTROL,
                    targetPosition=position,
                    physicsClientId=client,
                )
            bullet.stepSimulation(physicsClientId=client)

    def _GetPose(self, client: int, body: int) -> np.ndarray:
        bullet = self._bullet
        p, q = bullet.getBasePositionAndOrientation(
            body, physicsClientId=client
        )
        return np.concatenate([np.roll(q, 1), p])
