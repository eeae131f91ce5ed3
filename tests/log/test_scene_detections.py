"""The detections of every object of a scene are read and counted."""

from log_fixtures import has_warning
from mcap_fixtures import DETECTIONS

from pbpf_drake.config.scene_config import Scene, TrackedObject


def test_every_object_has_its_own_count(faulty):
    scene = Scene(
        robot="arm", tracked={"box": TrackedObject(), "can": TrackedObject()}
    )
    faulty.joints(0.0)
    for i in range(10):
        faulty.detection(0.1 * i)
        faulty.detection(0.1 * i + 0.01, name="can", q=(int(i > 4), 0, 0, 0))
    log = faulty.read(scene)
    counts = {u.name: (u.read, u.used) for u in log.usage if u.name}
    assert counts == {"box": (10, 10), "can": (10, 5)}
    assert has_warning(log, DETECTIONS, "only 5 of 10 detections of 'can'")
    assert not has_warning(log, "of 'box'")
    times = [(d.received, d.time) for d in log.detections]
    assert times == sorted(times) and len(times) == 15
