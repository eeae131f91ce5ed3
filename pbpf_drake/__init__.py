"""Physics-based particle filter that tracks pushed objects, for Drake.

A scene file says what there is: the robot, the objects to track, what is
fixed, and the camera. From it come the filter, which is a Drake system, and
all that is around it. This tracks the first two seconds of a recorded push::

    from pydrake.systems.analysis import Simulator

    import pbpf_drake as pbpf

    folder = pbpf.data_folder("diagrams")
    scene = pbpf.LoadScene(folder / "scenes" / "cheezit_1.yaml")
    log = pbpf.ReadLog(
        filename=folder / "logs" / "cheezit_1.mcap",
        scene=scene,
        joint_names=pbpf.MakePredictionModel(scene).joint_names,
    )
    tracking = pbpf.MakeTrackingDiagram(
        scene=scene, log=log, method="pbpf", config=scene.filter
    )
    simulator = Simulator(tracking.diagram)
    simulator.AdvanceTo(2.0)
    context = tracking.estimator.GetMyContextFromRoot(simulator.get_context())
    poses = tracking.estimator.GetOutputPort("estimated_poses").Eval(context)
    print(dict(zip(scene.object_names(), poses, strict=True)))

Plots are left to ``pbpf_drake.results.error_plot``: matplotlib takes long to
import.
"""

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.read_limits import ReadLimits
from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.distributions import PoseStddev, TruncatedGaussian
from pbpf_drake.config.log_topics import LogTopics
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.config.scene_config import LoadScene, Scene, TrackedObject
from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.filtering.add_particle_filter import (
    AddParticleFilter,
    AssembleParticleFilter,
    ConfigForMethod,
    MakeParticleFilter,
)
from pbpf_drake.filtering.live_filter import LiveFilter, Reading
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)
from pbpf_drake.filtering.slow_updates import LateUpdates
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.ground_truth_log_source import GroundTruthLogSource
from pbpf_drake.log.joint_log_source import JointLogSource
from pbpf_drake.log.log_inspection import InspectLog
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import (
    DetectionRecord,
    JointRecord,
    Log,
    PoseRecord,
)
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.motion.motion_model import (
    ConstantVelocityMotionModel,
    MotionInput,
    MotionModel,
    MotionResult,
)
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.results.pose_errors import (
    ErrorTrace,
    compute_errors,
    position_error,
    rotation_error,
)
from pbpf_drake.results.report import (
    MakeReport,
    WriteErrors,
    WriteReport,
)
from pbpf_drake.results.report_table import FormatTable
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import (
    MakePredictionModel,
    PredictionModel,
)
from pbpf_drake.scene.scene_models import (
    AddSceneModels,
    SceneModels,
    data_folder,
)
from pbpf_drake.tracking.tracking_diagram import (
    DefaultConfig,
    MakeTrackingDiagram,
    NumSteps,
    SceneOfLog,
    Track,
    TrackingDiagram,
)
from pbpf_drake.truth.truth_simulation import Recording, RecordRun
from pbpf_drake.views.estimate_recorder import (
    AddEstimateRecorder,
    EstimateRecorder,
)
from pbpf_drake.views.particle_visualizer import (
    AddParticleVisualizer,
    ParticleVisualizer,
)
from pbpf_drake.views.scene_meshcat import SaveReplay
from pbpf_drake.visibility.ray_casting import CastRays
from pbpf_drake.visibility.visibility_model import VisibilityModel

__all__ = [
    "AdaptiveCountConfig",
    "AddEstimateRecorder",
    "AddParticleFilter",
    "AddParticleVisualizer",
    "AddSceneModels",
    "AssembleParticleFilter",
    "CameraConfig",
    "CastRays",
    "ConfigForMethod",
    "ConstantVelocityMotionModel",
    "DefaultConfig",
    "Detection",
    "DetectionRecord",
    "DopeLogSource",
    "DopeMeasurement",
    "ErrorTrace",
    "EstimateRecorder",
    "FormatTable",
    "GroundTruthLogSource",
    "InspectLog",
    "JointLogSource",
    "JointRecord",
    "LateUpdates",
    "LiveFilter",
    "LoadScene",
    "Log",
    "LogError",
    "LogTopics",
    "MakeParticleFilter",
    "MakePredictionModel",
    "MakeReport",
    "MakeTrackingDiagram",
    "MotionInput",
    "MotionModel",
    "MotionResult",
    "NumSteps",
    "ParticleFilterConfig",
    "ParticleFilterUpdate",
    "ParticleVisualizer",
    "PhysicalParametersConfig",
    "PhysicsBasedParticleFilter",
    "PhysicsMotionModel",
    "PoseRecord",
    "PoseStddev",
    "PredictionModel",
    "ReadLimits",
    "ReadLog",
    "Reading",
    "RecordRun",
    "Recording",
    "RecordingConfig",
    "SaveReplay",
    "Scene",
    "SceneModels",
    "SceneOfLog",
    "SingleSnapshotEstimator",
    "SymmetryConfig",
    "Track",
    "TrackRecord",
    "TrackedObject",
    "TrackingDiagram",
    "TruncatedGaussian",
    "VisibilityConfig",
    "VisibilityModel",
    "WriteErrors",
    "WriteLog",
    "WriteReport",
    "compute_errors",
    "data_folder",
    "position_error",
    "rotation_error",
]
