"""Objects that are given as meshes, as a user has them."""

import base64
import json

from filter_fixtures import (
    BLOCKS_SCENE,
    PERIOD,
    FilterRun,
    detections,
    probe_at,
    small_config,
)
from mesh_fixtures import write_dae
import numpy as np
from pydrake.geometry import Mesh
import pytest
import trimesh

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.motion.particle_plant import MakeParticlePlant
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.shapes.surface_sampling import MakeSurface

# A wedge, 80 mm long, 60 mm wide and 40 mm high: half a box. Its centre of mass
# is at a third of length and height.
CORNERS = np.array(
    [[0, 0, 0], [80, 0, 0], [0, 0, 40], [0, 60, 0], [80, 60, 0], [0, 60, 40]]
) * [1e-3, 1e-3, 1e-3]
CENTER = [0.08 / 3, 0.03, 0.04 / 3]
VOLUME = 0.5 * 0.08 * 0.06 * 0.04
FACES = np.array(
    [[0, 1, 2], [3, 5, 4], [0, 3, 1], [1, 3, 4], [0, 2, 3], [2, 5, 3],
     [1, 4, 2], [2, 4, 5]]
)  # fmt: skip


def _write_obj(path, corners, faces) -> None:
    lines = ["v " + " ".join(map(str, corner)) for corner in corners]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def _write_gltf(path, corners, faces) -> None:
    # In glTF the y axis points up; Drake turns it to where z is.
    points = np.asarray(corners)[:, [0, 2, 1]] * [1, 1, -1]
    points = points.astype("<f4")
    indices = np.asarray(faces, dtype="<u2").ravel()
    data = points.tobytes() + indices.tobytes()
    uri = base64.b64encode(data).decode()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
        {
            "buffer": 0,
            "byteOffset": points.nbytes,
            "byteLength": indices.nbytes,
        },
    ]
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": len(points),
            "type": "VEC3",
            "min": points.min(axis=0).tolist(),
            "max": points.max(axis=0).tolist(),
        },
        {
            "bufferView": 1,
            "componentType": 5123,
            "count": indices.size,
            "type": "SCALAR",
        },
    ]
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": f"data:application/octet-stream;base64,{uri}",
            }
        ],
        "bufferViews": views,
        "accessors": accessors,
    }
    path.write_text(json.dumps(gltf))


def _write_others(path, corners, faces) -> None:
    if path.suffix == ".dae":
        write_dae(path)
        return
    data = trimesh.Trimesh(corners, faces).export(file_type=path.suffix[1:])
    path.write_bytes(data)


WRITERS = {
    "obj": _write_obj,
    "gltf": _write_gltf,
    "stl": _write_others,
    "ply": _write_others,
    "dae": _write_others,
}
MODEL = """
- add_model:
    name: wedge
    file: package://scene/wedge.{ending}
    default_free_body_pose:
      {body}: {{translation: [0.16, -0.03, 0.0]}}
"""


def _scene(
    folder, ending: str = "obj", *, scale=1.0, faces=FACES, body="wedge"
) -> Scene:
    """Returns a scene in which the wedge is 5 mm from the probe."""
    WRITERS[ending](folder / f"wedge.{ending}", scale * CORNERS, faces)
    path = folder / "wedge.yaml"
    model = MODEL.format(ending=ending, body=body)
    path.write_text(BLOCKS_SCENE.format(blocks=model, names="wedge: {}"))
    return LoadScene(path)


@pytest.fixture(params=WRITERS)
def scene(request, tmp_path) -> Scene:
    return _scene(tmp_path, request.param)


def test_mass_and_inertia_are_those_of_the_hull(scene):
    model = MakePredictionModel(scene)
    body = model.diagram.plant().get_body(model.models.objects[0])
    inertia = body.default_spatial_inertia()
    assert body.name() == "wedge"
    assert inertia.get_mass() == pytest.approx(500 * VOLUME, rel=1e-5)
    np.testing.assert_allclose(inertia.get_com(), CENTER, rtol=1e-5)
    assert inertia.IsPhysicallyValid()
    np.testing.assert_allclose(model.nominal_poses[0, 4:], [0.16, -0.03, 0])


def test_collision_shape_is_the_hull_with_points_at_its_corners(scene):
    model = MakePredictionModel(scene)
    (geometry,) = model.geometries(model.models.objects[0])
    shape = model.diagram.scene_graph().model_inspector().GetShape(geometry)
    assert isinstance(shape, Mesh)
    contact = MakeParticlePlant(model, ())
    inspector = contact.diagram.scene_graph().model_inspector()
    points = [inspector.GetPoseInFrame(p).translation() for p in contact.points]
    for corner in CORNERS:
        assert np.linalg.norm(np.array(points) - corner, axis=1).min() < 1e-6
    assert len(points) == len(CORNERS)


def test_surface_is_that_of_the_hull(scene):
    model = MakePredictionModel(scene)
    (geometry,) = model.geometries(model.models.objects[0])
    shape = model.diagram.scene_graph().model_inspector().GetShape(geometry)
    slope = 0.06 * np.hypot(0.08, 0.04)
    area = 0.08 * 0.04 + 0.06 * (0.08 + 0.04) + slope
    assert MakeSurface(shape).area == pytest.approx(area, rel=1e-5)


def test_a_scan_that_is_open_will_do(tmp_path):
    whole = MakePredictionModel(_scene(tmp_path))
    scan = MakePredictionModel(_scene(tmp_path, faces=FACES[:-2]))
    masses = [
        m.diagram.plant().get_body(m.models.objects[0]).default_mass()
        for m in (whole, scan)
    ]
    assert masses[0] == pytest.approx(masses[1])


def test_a_pushed_mesh_is_tracked_by_physics_and_visibility(scene):
    config = small_config(scene, num_particles=10, use_visibility=True)
    run = FilterRun(scene, config)
    run.measure(detections(0.1, wedge=[0.16, -0.03, 0.0]))
    # The probe goes on by 32 mm; the first 5 are not in contact.
    for i in range(1, 3):
        run.update(i)
    start = run["estimated_poses"][0, 4]
    run.move_joints(lambda t: probe_at((t - 2.5 * PERIOD) / PERIOD), 4)
    assert run["tracked"] == [1]
    assert np.all(np.isfinite(run["particles"]))
    assert run["estimated_poses"][0, 4] > start + 0.005


def test_a_mesh_in_millimetres_is_refused_with_a_hint(tmp_path):
    message = "'wedge' is 88.2 m long; .*millimetres.*<scale>0.001 0.001 0.001<"
    with pytest.raises(ValueError, match=message):
        MakePredictionModel(_scene(tmp_path, scale=1000))


def test_a_large_mesh_is_taken_as_it_is(tmp_path):
    model = MakePredictionModel(_scene(tmp_path, scale=20))
    body = model.diagram.plant().get_body(model.models.objects[0])
    assert body.default_mass() == pytest.approx(20**3 * 500 * VOLUME)


def test_a_mesh_that_is_scaled_twice_is_refused(tmp_path):
    with pytest.raises(ValueError, match="'wedge' is 8.*e-05 m long; .*scaled"):
        MakePredictionModel(_scene(tmp_path, scale=1e-3))


def test_a_mesh_without_volume_is_named(tmp_path):
    scene = _scene(tmp_path)
    _write_obj(tmp_path / "wedge.obj", CORNERS[:3], FACES[:1])
    with pytest.raises(ValueError, match=r"'wedge': .*wedge\.obj has no conv"):
        MakePredictionModel(scene)


def test_a_mesh_that_is_missing_is_named(tmp_path):
    scene = _scene(tmp_path)
    (tmp_path / "wedge.obj").unlink()
    with pytest.raises(ValueError, match=r"wedge\.obj' which does not exist"):
        MakePredictionModel(scene)


def test_a_pose_of_another_body_is_refused(tmp_path):
    with pytest.raises(ValueError, match="that of 'base' in 'world'; expected"):
        MakePredictionModel(_scene(tmp_path, body="base"))
