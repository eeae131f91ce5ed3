import numpy as np
import pytest

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.visibility.visibility_model import (
    VisibilityModel,
    in_image,
    visibility_log_factor,
)

BOX = "<box><size>0.1 0.2 0.3</size></box>"
SMALL = "<box><size>0.04 0.04 0.04</size></box>"
CAN = "<cylinder><radius>0.05</radius><length>0.2</length></cylinder>"
# Its edge is at x = 0, where it stands between the camera and everything.
WALL = "<box><size>2 4 0.01</size></box>", (1, 0, 0.4)
SHIELD = "<box><size>4 4 0.01</size></box>", (0, 0, 0.4)
AHEAD = [1, 0, 0, 0, 0, 0, 1.0]


def _sdf(path, name, geometry):
    collision = (
        f"<collision name='c'><geometry>{geometry}</geometry></collision>"
    )
    path.write_text(
        f"<sdf version='1.7'><model name='{name}'><link name='{name}'>"
        f"{collision if geometry else ''}</link></model></sdf>"
    )


def _scene(folder, *, objects, fixed=(), camera=""):
    """A camera at the world's origin, its optical frame is the world's.

    The robot is a ball on a rail; at q = 0 it is 1 m behind the camera.
    """
    (folder / "ball.urdf").write_text(
        "<robot name='ball'><link name='base'/><link name='ball'><collision>"
        "<origin xyz='0 0 -1'/><geometry><sphere radius='0.3'/></geometry>"
        "</collision></link><joint name='rail' type='prismatic'>"
        "<parent link='base'/><child link='ball'/><axis xyz='0 0 1'/>"
        "<limit lower='-3' upper='3' effort='1' velocity='1'/></joint></robot>"
    )
    lines = [
        "directives:",
        "- add_model: {name: robot, file: package://scene/ball.urdf}",
        "- add_weld: {parent: world, child: robot::base}",
    ]
    for i, (geometry, p_WF) in enumerate(fixed):
        _sdf(folder / f"fixed_{i}.sdf", "fixed", geometry)
        lines += [
            f"- add_model: {{name: fixed_{i}, "
            f"file: package://scene/fixed_{i}.sdf}}",
            f"- add_weld: {{parent: world, child: fixed_{i}::fixed, "
            f"X_PC: {{translation: {list(p_WF)}}}}}",
        ]
    for name, geometry in objects.items():
        _sdf(folder / f"{name}.sdf", name, geometry)
        lines.append(
            f"- add_model: {{name: {name}, file: package://scene/{name}.sdf}}"
        )
    lines.append("robot: robot")
    lines.append(
        f"tracked: {{{', '.join(f'{name}: {{}}' for name in objects)}}}"
    )
    lines.append(f"camera: {{{camera}}}")
    (folder / "scene.yaml").write_text("\n".join(lines))
    return LoadScene(folder / "scene.yaml")


def _score(model, particles, *, q=0.0, active=None, seed=0, scratch=None):
    particles = np.array(particles, dtype=float)
    if active is None:
        active = np.full(particles.shape[1], True)
    return model.Score(
        particles=particles,
        active=np.array(active),
        robot_positions=np.array([q]),
        rng=np.random.default_rng(seed),
        scratch=scratch or model.MakeScratch(),
    )


def _random_particles(num, num_objects, seed=1):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(num, num_objects, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    p = rng.normal(size=(num, num_objects, 3)) * 0.1 + [0, 0, 1]
    return np.concatenate([q, p], axis=-1)


@pytest.mark.parametrize("geometry", [BOX, CAN])
def test_nothing_in_the_way_is_a_visibility_of_one(tmp_path, geometry):
    model = VisibilityModel(
        scene=_scene(tmp_path, objects={"thing": geometry}), num_rays=100
    )
    v = _score(model, _random_particles(20, 1))
    np.testing.assert_array_equal(v, np.ones((20, 1)))


@pytest.mark.parametrize("geometry", [BOX, CAN])
def test_half_a_wall_hides_half_and_a_shield_hides_all(tmp_path, geometry):
    for fixed, expected in ((WALL, 0.5), (SHIELD, 0.0)):
        scene = _scene(tmp_path, objects={"thing": geometry}, fixed=[fixed])
        v = _score(VisibilityModel(scene=scene, num_rays=2000), [[AHEAD]])
        assert v.item() == pytest.approx(expected, abs=0.005)


def test_the_robot_hides_what_its_joints_put_it_in_front_of(tmp_path):
    scene = _scene(tmp_path, objects={"thing": SMALL})
    model = VisibilityModel(scene=scene, num_rays=20)
    scratch = model.MakeScratch()
    for q, expected in ((0, 1), (1.6, 0), (2.5, 1), (1.6, 0), (0, 1)):
        assert _score(model, [[AHEAD]], q=q, scratch=scratch) == expected


@pytest.mark.parametrize(
    ("camera", "expected"),
    [
        # The image begins at the optical axis, or ends there.
        ("cx: -0.5", 0.5),
        ("cy: -0.5", 0.5),
        ("cx: 639.5", 0.5),
        ("cy: 479.5", 0.5),
        ("X_WC: {translation: [0, 0, 2]}", 0.0),
        (
            "X_WC: {translation: [0, 0, 2], rotation: !Rpy {deg: [180, 0, 0]}}",
            1,
        ),
    ],
)
def test_what_the_image_does_not_contain_is_not_visible(
    tmp_path, camera, expected
):
    scene = _scene(tmp_path, objects={"thing": BOX}, camera=camera)
    v = _score(VisibilityModel(scene=scene, num_rays=2000), [[AHEAD]])
    assert v.item() == pytest.approx(expected, abs=0.005)


def test_in_image_ends_half_a_pixel_beyond_the_outer_pixels_centres():
    camera = CameraConfig(width=4, height=2, fx=1, fy=1, cx=0, cy=0)
    inside = [[-0.49, -0.49, 1], [3.49, 1.49, 1], [6.9, 2.9, 2]]
    outside = [[-0.51, 0, 1], [0, -0.51, 1], [3.51, 0, 1], [0, 1.51, 1]]
    assert np.all(in_image(np.array(inside), camera))
    assert not np.any(in_image(np.array(outside), camera))
    assert not np.any(in_image(np.array([[0, 0, -1.0], [0, 0, 0]]), camera))


def test_a_box_on_a_table_that_it_touches_is_all_visible(tmp_path):
    # y points down in the image; the camera looks down at the table.
    table = "<box><size>2 0.1 2</size></box>", (0, 0.55, 1)
    camera = "X_WC: {rotation: !Rpy {deg: [-20, 0, 0]}}"
    scene = _scene(
        tmp_path, objects={"thing": BOX}, fixed=[table], camera=camera
    )
    model = VisibilityModel(scene=scene, num_rays=500)
    v = _score(model, [[[1, 0, 0, 0, 0, 0.4, 1]], [[1, 0, 0, 0, 0, 0.5, 1]]])
    assert v[0, 0] == 1
    # Sunk by half of its height, it hides what is below its visible part
    # before the table does.
    assert 0.6 < v[1, 0] < 0.95


def test_objects_of_the_same_particle_hide_each_other(tmp_path):
    scene = _scene(tmp_path, objects={"box": BOX, "small": SMALL})
    model = VisibilityModel(scene=scene, num_rays=500)
    near = [1, 0, 0, 0, 0, 0, 0.7]
    far = [1, 0, 0, 0, 0, 0, 1.3]
    aside = [1, 0, 0, 0, 0.3, 0, 1]
    particles = [[near, far], [aside, near], [aside, far]]
    np.testing.assert_array_equal(
        _score(model, particles), [[1, 0], [1, 1], [1, 1]]
    )
    v = _score(model, [[far, near]])
    assert v[0, 1] == 1 and 0.5 < v[0, 0] < 0.99


def test_an_object_that_is_not_active_hides_nothing_and_scores_one(tmp_path):
    scene = _scene(tmp_path, objects={"box": BOX, "small": SMALL}, fixed=[WALL])
    model = VisibilityModel(scene=scene, num_rays=1000)
    near = [1, 0, 0, 0, 0, 0, 0.7]
    far = [1, 0, 0, 0, 0, 0, 1.3]
    v = _score(model, [[near, far]], active=[False, True])
    np.testing.assert_allclose(v, [[1, 0.5]], atol=0.01)
    v = _score(model, [[near, far]], active=[False, False])
    np.testing.assert_array_equal(v, [[1, 1]])
    # Nor do particles without a pose yet disturb the others.
    v = _score(model, [[np.full(7, np.nan), far]], active=[False, True])
    np.testing.assert_allclose(v, [[1, 0.5]], atol=0.01)


def _crowd(tmp_path):
    scene = _scene(tmp_path, objects={"box": BOX, "can": CAN}, fixed=[WALL])
    model = VisibilityModel(scene=scene, num_rays=48)
    return model, _random_particles(30, 2)


def test_many_particles_at_once_score_as_each_alone(tmp_path):
    model, particles = _crowd(tmp_path)
    v = _score(model, particles)
    alone = [_score(model, particles[m : m + 1])[0] for m in range(30)]
    np.testing.assert_array_equal(v, alone)
    assert len(np.unique(v)) > 10


def test_state_behind_the_poses_is_not_used(tmp_path):
    model, particles = _crowd(tmp_path)
    wider = np.concatenate([particles, np.full((30, 2, 6), np.nan)], axis=-1)
    np.testing.assert_array_equal(
        _score(model, wider), _score(model, particles)
    )


@pytest.mark.parametrize("parallelism", [2, 3, 40])
def test_processes_agree_with_one_to_the_bit(tmp_path, parallelism):
    model, particles = _crowd(tmp_path)
    scratch = model.MakeScratch(parallelism)
    alone = [_score(model, particles, q=q) for q in (0.0, 1.5)]
    shared = [
        _score(model, particles, q=q, scratch=scratch) for q in (0.0, 1.5)
    ]
    np.testing.assert_array_equal(alone, shared)
    assert len(np.unique(alone)) > 10


def test_the_seed_decides_the_points(tmp_path):
    model, particles = _crowd(tmp_path)
    v = _score(model, particles, seed=1)
    np.testing.assert_array_equal(v, _score(model, particles, seed=1))
    assert np.any(v != _score(model, particles, seed=2))


def test_an_object_without_collision_geometry_is_refused(tmp_path):
    scene = _scene(tmp_path, objects={"ghost": ""})
    with pytest.raises(ValueError, match="'ghost' has no collision geometry"):
        VisibilityModel(scene=scene, num_rays=1)


def test_a_camera_inside_a_fixed_model_is_refused(tmp_path):
    scene = _scene(
        tmp_path, objects={"thing": BOX}, fixed=[WALL, (BOX, (0, 0.01, 0))]
    )
    with pytest.raises(ValueError, match="camera.X_WC is inside .*fixed_1"):
        VisibilityModel(scene=scene, num_rays=1)


def test_without_a_detection_hidden_particles_get_the_high_weight():
    config = VisibilityConfig(
        high_weight=0.75, low_weight=0.25, high_visibility=0.95
    )
    factor = visibility_log_factor(
        np.array([0, 0.94, 0.95, 1]), detected=False, config=config
    )
    np.testing.assert_allclose(np.exp(factor), [0.75, 0.75, 0.25, 0.25])


def test_with_a_detection_hidden_particles_are_penalised():
    config = VisibilityConfig(low_visibility=0.5, penalty=0.33)
    factor = visibility_log_factor(
        np.array([0, 0.49, 0.5, 1]), detected=True, config=config
    )
    np.testing.assert_allclose(np.exp(factor), [0.33, 0.33, 1, 1])
