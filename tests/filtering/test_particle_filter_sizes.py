"""One particle and a thousand, three objects, and tracks that are lost."""

from dataclasses import replace

from filter_fixtures import (
    BLOCK,
    PERIOD,
    PROBE,
    SCENES,
    FilterRun,
    assert_same,
    block_at,
    detections,
    planar_scene,
    probe_at,
    small_config,
    write_blocks_scene,
)
import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene, Scene

# On the table: a lying carton, a lying gelatin box and a standing can.
THREE = {
    "cracker": [0.45, 0.25, 0.0305],
    "gelatin": [0.6, -0.1, 0.01395],
    "soup": [0.65, 0.05, 0.05],
}
# The axis of the can is its local y.
UPRIGHT = RotationMatrix.MakeXRotation(np.pi / 2)


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _assert_tracks(run: FilterRun, positions, atol: float) -> None:
    for name, value in run.ports().items():
        assert np.all(np.isfinite(value)), name
    poses = run["estimated_poses"]
    np.testing.assert_allclose(poses[:, 4:], positions, atol=atol)
    assert np.sum(run["weights"]) == pytest.approx(1)


@pytest.mark.parametrize("motion", ["physics", "constant_velocity"])
def test_one_particle_is_enough_to_run(scene, motion):
    config = small_config(
        scene, num_particles=1, motion=motion, use_visibility=True
    )
    run = FilterRun(scene, config)
    for i in range(1, 6):
        run.measure(detections(PERIOD * i - 0.01, block=BLOCK))
        run.update(i)
        np.testing.assert_array_equal(run["weights"], [1])
        np.testing.assert_allclose(run["covariances"], 0, atol=1e-12)
        np.testing.assert_allclose(
            run["particles"][4:], run["estimated_poses"][0, 4:], atol=1e-12
        )
        _assert_tracks(run, [BLOCK], atol=0.1)


@pytest.mark.parametrize("motion", ["physics", "constant_velocity"])
def test_a_thousand_particles_can_be_used(scene, motion):
    config = small_config(scene, num_particles=1000, motion=motion)
    run = FilterRun(scene, config)
    # With physics, that takes seconds.
    for i in range(1, 2 if motion == "physics" else 5):
        run.measure(detections(PERIOD * i - 0.01, block=BLOCK))
        run.update(i)
        _assert_tracks(run, [BLOCK], atol=0.01)
    assert run["weights"].shape == (1000,)
    assert 100 < run["effective_sample_size"] <= 1000


def _write_three(folder) -> Scene:
    """The arm of the shipped scene, its camera and table; three objects."""
    text = (SCENES / "cheezit_1.yaml").read_text()
    head, rest = text.split("- add_model:\n    name: cracker\n")
    camera = rest[rest.index("camera:") : rest.index("# (The log that")]
    turns = {"cracker": 0, "gelatin": 0, "soup": 90}
    models = "".join(
        f"""
- add_model:
    name: {name}
    file: package://pbpf_drake/{name}/{name}.sdf
    default_free_body_pose:
      {name}:
        translation: {p}
        rotation: !Rpy {{deg: [{turns[name]}, 0, 0]}}
"""
        for name, p in THREE.items()
    )
    head = head[: head.rindex("# The box stands")]
    path = folder / "three.yaml"
    path.write_text(
        f"{head}{models}\nrobot: panda\n"
        f"tracked: {{cracker: {{}}, gelatin: {{}}, soup: {{}}}}\n{camera}"
    )
    return LoadScene(path)


def test_three_objects_are_tracked_with_physics_and_visibility(tmp_path):
    scene = _write_three(tmp_path)
    config = ParticleFilterConfig(num_particles=20, use_visibility=True)
    poses = {name: RigidTransform(p) for name, p in THREE.items()}
    poses["soup"] = RigidTransform(UPRIGHT, THREE["soup"])
    start = [-0.41639, 0.82541, -0.07092, -2.13369, 1.08407, 1.49705, 0.93831]
    run = FilterRun(scene, config, joints=[*start, 0.0, 0.0])
    for i in range(1, 6):
        # The can is seen from the third update on, the others by turns.
        seen = {"cracker": i % 2, "gelatin": i != 2, "soup": i > 2}
        found = {name: X_WO for name, X_WO in poses.items() if seen[name]}
        run.measure(detections(PERIOD * i - 0.01, **found))
        run.update(i)
        np.testing.assert_array_equal(
            run["detected"], [bool(x) for x in seen.values()]
        )
        np.testing.assert_array_equal(run["tracked"], [1, 1, i > 2])
        _assert_tracks(run, list(THREE.values()), atol=0.03)
    assert run["particles"].shape == (20 * 3 * 7,)
    spread = run["covariances"].reshape(3, 6, 6)
    assert np.all(np.linalg.eigvalsh(spread) > -1e-12)


@pytest.mark.parametrize("use_visibility", [False, True])
def test_what_is_never_detected_does_not_influence_another(
    tmp_path, use_visibility
):
    """It may even be in the same place."""
    results = []
    for second in ([0.2, 0.0, 0.0065], [0.4, 0.3, 0.5]):
        scene = write_blocks_scene(tmp_path, {"one": BLOCK, "two": second})
        config = small_config(scene, use_visibility=use_visibility)
        run = FilterRun(scene, config)
        for i in range(1, 4):
            run.set_joints(probe_at(i))
            run.measure(detections(PERIOD * i - 0.02, one=block_at(i)))
            run.update(i)
        ports = run.ports()
        np.testing.assert_array_equal(ports["tracked"], [1, 0])
        np.testing.assert_array_equal(ports["detected"], [1, 0])
        np.testing.assert_allclose(
            ports["estimated_poses"][1], [1, 0, 0, 0, *second], atol=1e-15
        )
        for name, shape in (
            ("particles", (8, 2, 7)),
            ("covariances", (1, 2, 36)),
        ):
            ports[name] = ports[name].reshape(shape)[:, 0]
        ports["estimated_poses"] = ports["estimated_poses"][:1]
        results.append(ports)
    assert_same(*results)


def test_objects_may_be_detected_one_after_the_other(tmp_path):
    second = [0.5, 0.2, 0.0065]
    scene = write_blocks_scene(tmp_path, {"one": BLOCK, "two": second})
    run = FilterRun(scene, replace(small_config(scene), use_visibility=True))
    run.measure(detections(0.1, one=BLOCK))
    run.update(1)
    np.testing.assert_array_equal(run["tracked"], [1, 0])
    run.measure(detections(0.3, two=second))
    run.update(2)
    np.testing.assert_array_equal(run["tracked"], [1, 1])
    np.testing.assert_array_equal(run["detected"], [0, 1])
    np.testing.assert_allclose(
        run["estimated_poses"][1, 4:6], second[:2], atol=0.05
    )


def _poke(scene, **changes) -> list[float]:
    """Errors after the block was put from behind the probe to before it.

    Its particles can't follow: the probe is in between.
    """
    config = replace(scene.filter, num_particles=30, **changes)
    run = FilterRun(scene, config, joints=[0.25, 0.0])
    behind, before = ([x, 0.0, BLOCK[2]] for x in (0.19, 0.33))
    errors = []
    for i in range(1, 10):
        position = behind if i <= 3 else before
        run.measure(detections(PERIOD * i - 0.01, block=position))
        run.update(i)
        errors.append(run["estimated_poses"][0, 4] - position[0])
    return errors


def test_particles_on_the_wrong_side_of_the_probe_are_recovered(scene):
    errors = _poke(scene, recover_lost_tracks=True)
    assert abs(errors[2]) < 0.015
    assert errors[3] < -0.1
    # Three detections agree, and the fourth is used with the particles back.
    np.testing.assert_allclose(errors[6:], 0, atol=0.015)


def test_without_recovery_they_stay_on_the_wrong_side(scene):
    assert _poke(scene)[-1] < -0.05


def test_the_probe_can_be_where_the_first_particles_would_be(scene):
    """They are pushed out of it before they are seen."""
    run = FilterRun(scene, small_config(scene, num_particles=30))
    run.set_joints([0.21, 0.0])
    run.measure(detections(0.1, block=[0.25, 0.0, BLOCK[2]]))
    run.update(1)
    p = run["particles"].reshape(30, 7)[:, 4:6]
    # No centre is nearer to the probe than the block's half width.
    assert np.min(np.linalg.norm(p - [0.21, 0.0], axis=1)) > 0.045
    assert PROBE[0] < 0.21
