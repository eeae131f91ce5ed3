"""Adds systems to a diagram that play a log."""

from pydrake.systems.framework import DiagramBuilder, OutputPort

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.joint_log_source import JointLogSource
from pbpf_drake.log.log_records import Log


def AddLogSources(
    *, builder: DiagramBuilder, scene: Scene, log: Log
) -> dict[str, OutputPort]:
    """Adds the sources of a log that estimators need.

    Args:
        builder: the diagram to add to.
        scene: its camera made the detections.
        log: what to play.

    Returns:
        The output ports by the names of the estimators' inputs:
        ``joint_positions`` and ``dope_measurement``.
    """
    joints = builder.AddNamedSystem(
        "joint_log_source", JointLogSource(record=log.joints)
    )
    dope = builder.AddNamedSystem(
        "dope_log_source",
        DopeLogSource(detections=log.detections, X_WC=scene.camera.pose()),
    )
    return {
        "joint_positions": joints.GetOutputPort("joint_positions"),
        "dope_measurement": dope.GetOutputPort("dope_measurement"),
    }
