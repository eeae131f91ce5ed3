"""A camera with a detector that looks at a simulated truth."""

from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.planning import RobotDiagramBuilder
from pydrake.systems.framework import Context, LeafSystem, State

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.truth.simulated_detector import SimulatedDetector
from pbpf_drake.truth.true_visibility import (
    AddLabelRenderer,
    VisibilityCamera,
)


@dataclass
class _Memory:
    """The detector's state; it is copied with the context.

    Attributes:
        detector: with the state of its random generator.
        next: its answer to the last image, which isn't out yet.
    """

    detector: SimulatedDetector
    next: DopeMeasurement


class SimulatedCamera(LeafSystem):
    """Detects the objects of a truth that the scene's camera sees.

    Every image is rendered. An object that is hidden in it isn't detected, or
    is detected in a wrong place: see SimulatedDetector. The detector answers
    when its latency has passed.

    .. pydrake_system::

        name: SimulatedCamera
        input_ports:
        - state
        output_ports:
        - dope_measurement
        - visibility

    Input ``state``: positions, then velocities of a plant with the models of
    the scene. Output ``dope_measurement``: a DopeMeasurement, the last answer.
    Output ``visibility``: (K,) visible shares of the objects in the last
    image, in [0, 1].

    State: the detector and its last answer, which are abstract, and the shares,
    which are discrete. Events: in every period of the detector an image, and
    an answer when the latency has passed.

    Args:
        scene: its ``recording.detector`` says how the detector errs.
        num_states: of the plant.
        rng: all errors are drawn from it.

    Raises:
        ValueError: the detector would answer only after the next image.
    """

    def __init__(
        self, *, scene: Scene, num_states: int, rng: np.random.Generator
    ) -> None:
        super().__init__()
        config = scene.recording.detector
        if config.latency >= config.period:
            raise ValueError(
                f"recording.detector.latency is {config.latency:g}; expected "
                f"less than its period, {config.period:g}"
            )
        builder = RobotDiagramBuilder(time_step=0.0)
        models = AddSceneModels(builder.plant(), scene)
        AddLabelRenderer(builder.scene_graph())
        diagram = builder.Build()
        plant = diagram.plant()
        self._camera = VisibilityCamera(
            diagram=diagram, objects=models.objects, camera=scene.camera
        )
        self._X_WC = scene.camera.pose()
        self._num_positions = plant.num_positions()
        self._starts = [
            plant.get_body(b).floating_positions_start() for b in models.objects
        ]
        detector = SimulatedDetector(
            config=config, names=scene.object_names(), X_WC=self._X_WC, rng=rng
        )
        self._state_port = self.DeclareVectorInputPort("state", num_states)
        self._memory = self.DeclareAbstractState(
            Value(_Memory(detector, DopeMeasurement()))
        )
        self._answer = self.DeclareAbstractState(Value(DopeMeasurement()))
        self._shares = self.DeclareDiscreteState(np.ones(len(models.objects)))
        self.DeclareStateOutputPort("dope_measurement", self._answer)
        self.DeclareStateOutputPort("visibility", self._shares)
        for offset, update in (
            (0.0, self._Look),
            (config.latency, self._GiveAnswer),
        ):
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                period_sec=config.period, offset_sec=offset, update=update
            )

    def _Look(self, context: Context, state: State) -> None:
        """Takes an image, and detects what is in it."""
        q = self._state_port.Eval(context)[: self._num_positions]
        poses = [rigid_transform(q[s : s + 7]) for s in self._starts]
        shares = self._camera.CalcVisibility(q)
        state.get_mutable_discrete_state(self._shares).set_value(shares)
        memory = state.get_mutable_abstract_state(int(self._memory))
        detector, last = memory.get_value().detector, memory.get_value().next
        found = detector.Detect(
            time=context.get_time(), poses=poses, visibility=shares
        )
        new = {d.name: self._Detection(d.X_CO, d.time) for d in found}
        memory.set_value(
            _Memory(detector, DopeMeasurement({**last.detections, **new}))
        )

    def _Detection(self, X_CO: RigidTransform, time: float) -> Detection:
        return Detection(X_WO=self._X_WC @ X_CO, time=time)

    def _GiveAnswer(self, context: Context, state: State) -> None:
        """Makes the answer for the last image known."""
        memory = context.get_abstract_state(int(self._memory)).get_value()
        answer = state.get_mutable_abstract_state(int(self._answer))
        answer.set_value(memory.next)
