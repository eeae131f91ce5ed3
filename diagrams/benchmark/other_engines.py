"""Lets other physics engines make the filter's predictions.

They get what the filter's motion model got at each timed update: the same
particles and controls, and θ of the same distribution.
"""

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from time import perf_counter
from typing import Protocol

import numpy as np

from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.diagrams.benchmark.benchmark_reference import Sample
from pbpf_drake.diagrams.benchmark.mujoco_peer import MuJoCoPeer
from pbpf_drake.diagrams.benchmark.peer_scene import ReadPeerScene
from pbpf_drake.diagrams.benchmark.pybullet_peer import PyBulletPeer
from pbpf_drake.motion.motion_model import MotionInput
from pbpf_drake.motion.physical_parameters import (
    PhysicalParameters,
    SamplePhysicalParameters,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel

# Called as the packages that have them.
ENGINES = ("pybullet", "mujoco")


class Peer(Protocol):
    """Another engine, with M worlds."""

    def Reset(self, q: np.ndarray) -> None:
        """Puts the robot somewhere, at rest, before a pass through the log."""

    def Prepare(self, parameters: PhysicalParameters) -> None:
        """Takes the particles' θ for the next update; this isn't timed."""

    def Update(self, motion: MotionInput) -> np.ndarray:
        """Returns the predicted poses, (M, K, 7); this is what is timed."""

    def Close(self) -> None:
        """Ends threads or processes."""


def MakePeer(
    engine: str, scene: Scene, *, num_particles: int, num_threads: int
) -> Peer:
    """Makes an engine for a scene.

    Args:
        engine: "pybullet" or "mujoco".
        scene: its models; the robot is the Panda.
        num_particles: M.
        num_threads: threads or processes that predict particles.
    """
    peer_scene = ReadPeerScene(scene)
    joint_names = MakePredictionModel(scene).joint_names
    if engine == "pybullet":
        return PyBulletPeer(
            scene=peer_scene,
            joint_names=joint_names,
            num_particles=num_particles,
            num_processes=num_threads,
        )
    return MuJoCoPeer(
        scene=peer_scene,
        joint_names=joint_names,
        num_particles=num_particles,
        num_threads=num_threads,
    )


def CheckPeerPackages() -> None:
    """Makes sure that the other engines are installed.

    Raises:
        ValueError: one isn't; the message says how to install it.
    """
    missing = [name for name in ENGINES if find_spec(name) is None]
    if missing:
        raise ValueError(
            f"--peers needs the package {' and '.join(missing)}; install what "
            'it needs with: pip install "pbpf_drake[peers]"'
        )


def RunPeer(
    peer: Peer,
    *,
    passes: Sequence[Sequence[MotionInput]],
    samples: Sequence[Sample],
    physics: PhysicalParametersConfig,
    on_update: Callable[[], object] = lambda: None,
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times an engine, and takes its predictions of the samples.

    Args:
        peer: the engine.
        passes: inputs of the filter's motion model; see FilterRun.
        samples: taken from the same updates.
        physics: the distribution of θ for updates that aren't samples.
        on_update: called after each update.

    Returns:
        Wall times (N,) of the updates (in seconds), and the poses of each
        sample.
    """
    by_update = {sample.update: sample for sample in samples}
    rng = np.random.default_rng(0)
    seconds: list[float] = []
    predictions = []
    for motions in passes:
        peer.Reset(motions[0].path.positions[0])
        for motion in motions:
            sample = by_update.get(len(seconds))
            parameters = SamplePhysicalParameters(
                physics, motion.poses.shape[:2], rng
            )
            peer.Prepare(sample.parameters if sample else parameters)
            begin = perf_counter()
            poses = peer.Update(motion)
            seconds.append(perf_counter() - begin)
            if sample:
                predictions.append(poses[: len(sample.motion.poses)])
            on_update()
    return np.array(seconds), predictions
