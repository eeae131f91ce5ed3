"""The sources of a log in a diagram."""

from dataclasses import replace

from filter_fixtures import make_push_log, planar_scene
import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from pbpf_drake.tracking.add_log_sources import AddLogSources

LOG = make_push_log(duration=1.0)


def _play(scene, time: float) -> dict:
    """What the sources say at a time, by port."""
    builder = DiagramBuilder()
    ports = AddLogSources(builder=builder, scene=scene, log=LOG)
    context = builder.Build().CreateDefaultContext()
    context.SetTime(time)
    return {
        name: port.Eval(port.get_system().GetMyContextFromRoot(context))
        for name, port in ports.items()
    }


def test_the_ports_play_joints_and_detections_of_the_log():
    time = LOG.joints.times[3]
    found = _play(planar_scene(), time)
    assert list(found) == ["joint_positions", "dope_measurement"]
    np.testing.assert_allclose(
        found["joint_positions"], LOG.joints.positions[3]
    )
    known = [d for d in LOG.detections if d.received <= time]
    detections = found["dope_measurement"].detections
    assert detections["block"].time == known[-1].time


def test_detections_are_from_where_the_scene_has_its_camera():
    scene = planar_scene()
    shift = RigidTransform([0.0, 0.3, 0.0])
    X_WC = Transform(shift @ scene.camera.pose())
    moved = replace(scene, camera=replace(scene.camera, X_WC=X_WC))
    here, there = (
        _play(s, 0.9)["dope_measurement"].detections["block"].X_WO
        for s in (scene, moved)
    )
    np.testing.assert_allclose(
        there.translation(), (shift @ here).translation(), atol=1e-12
    )
