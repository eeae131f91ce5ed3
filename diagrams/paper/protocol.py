"""What is to be recorded and evaluated: the paper's protocol, or less."""

from collections.abc import Sequence
from dataclasses import dataclass
import functools
import math

from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.scene_run import SceneRun, scene_name, scene_path
from pbpf_drake.diagrams.paper.evaluation import Evaluation, evaluation_config
from pbpf_drake.diagrams.paper.paper_values import (
    SCENES,
    paper_methods,
    paper_runs_and_repeats,
)

# How much of the time of an update with physics one without physics takes, for
# each particle and object.
_COST_WITHOUT_PHYSICS = 0.02


@dataclass(frozen=True)
class Protocol:
    """What to evaluate, and how often. None stands for what the paper did.

    Attributes:
        scenes: names or files.
        methods: for all scenes.
        runs: of each scene.
        repeats: evaluations of each run and method.
        duration: of each log (in seconds); None is the scene's.
        particles: of each filter; None is the scene's and the method's.
    """

    scenes: Sequence[str]
    methods: Sequence[str] | None = None
    runs: int | None = None
    repeats: int | None = None
    duration: float | None = None
    particles: int | None = None

    def ValidateOrThrow(self) -> None:
        """Raises ValueError, naming the option, if one can't be used."""
        for name in "runs", "repeats", "particles":
            value = getattr(self, name)
            if value is not None and not 1 <= value <= 1000:
                raise ValueError(
                    f"--{name} is {value}; expected between 1 and 1000"
                )
        if self.duration is not None and not 0 < self.duration < math.inf:
            raise ValueError(
                f"--duration is {self.duration:g}; expected more than 0"
            )
        for scene in self.scenes:
            name, path = scene_name(scene), scene_path(scene)
            if name in SCENES and path.resolve() != scene_path(name).resolve():
                raise ValueError(
                    f"--scenes has {scene}, which is called as the paper's "
                    f"scene {name}; expected another name of the file"
                )
        names = [scene_name(scene) for scene in self.scenes]
        if len(set(names)) < len(names):
            raise ValueError(
                f"--scenes has two of the same name; they are {names}"
            )


def scene_runs(protocol: Protocol) -> list[SceneRun]:
    """Returns what is to be recorded."""
    return [
        SceneRun(scene, run, protocol.duration)
        for scene in protocol.scenes
        for run in range(
            protocol.runs or paper_runs_and_repeats(scene_name(scene))[0]
        )
    ]


def evaluations(protocol: Protocol) -> list[Evaluation]:
    """Returns what is to be evaluated, run by run.

    DOPE draws nothing at random: it is evaluated once.
    """
    found = []
    for scene_run in scene_runs(protocol):
        name = scene_name(scene_run.scene)
        repeats = protocol.repeats or paper_runs_and_repeats(name)[1]
        for method in protocol.methods or paper_methods(name) or METHODS:
            found += [
                Evaluation(scene_run, method, repeat, protocol.particles)
                for repeat in range(1 if method == "dope" else repeats)
            ]
    return found


def evaluation_cost(evaluation: Evaluation) -> float:
    """Returns about how long an evaluation takes, in any unit."""
    scene_run = evaluation.scene_run
    scene = _load_scene(scene_run.scene)
    config = evaluation_config(evaluation, scene)
    updates = (scene_run.duration or scene.recording.duration) / config.period
    if evaluation.method == "dope":
        return updates
    physics = config.motion == "physics"
    each = 1.0 if physics else _COST_WITHOUT_PHYSICS
    return updates * (1 + each * config.num_particles * len(scene.tracked))


def recording_cost(scene_run: SceneRun) -> float:
    """Returns about how long a recording takes, in any unit."""
    scene = _load_scene(scene_run.scene)
    return scene_run.duration or scene.recording.duration


@functools.cache
def _load_scene(scene: str) -> Scene:
    """Returns a scene to look at, but not to change: it is shared."""
    return LoadScene(scene_path(scene))
