"""Visibility against two references that share no code with it."""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
)
from pydrake.math import RigidTransform
from pydrake.planning import RobotDiagramBuilder
from pydrake.systems.sensors import CameraInfo
from sphere_tracing import trace

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.scene_models import AddSceneModels, data_folder
from pbpf_drake.shapes.surface_sampling import BodySurface
from pbpf_drake.visibility.visibility_model import VisibilityModel

SHAPES = {
    "box": "<box><size>0.16 0.21 0.06</size></box>",
    "can": "<cylinder><radius>0.05</radius><length>0.14</length></cylinder>",
    "wall": "<box><size>0.05 0.2 0.2</size></box>",
    "pillar": "<cylinder><radius>0.03</radius><length>0.3</length></cylinder>",
    "table": "<box><size>2 2 0.1</size></box>",
}
ARM = """
<robot name="arm">
  <link name="base"/>
  <link name="upper">{upper}</link>
  <link name="lower">{lower}</link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0.3 0 0"/>
    <parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
</robot>
"""
BAR = '<origin xyz="0.15 0 0"/><geometry><box size="0.3 0.05 0.06"/></geometry>'
ROD = (
    '<origin xyz="0.15 0 0" rpy="0 1.5708 0"/>'
    '<geometry><cylinder radius="0.04" length="0.3"/></geometry>'
)
MODELS = """
directives:
- add_model: {name: arm, file: package://scene/arm.urdf}
- add_weld:
    {parent: world, child: arm::base, X_PC: {translation: [-0.3, 0, 0.25]}}
- add_model: {name: box, file: package://scene/box.sdf}
- add_model: {name: can, file: package://scene/can.sdf}
"""
FIXED = """
- add_model: {name: wall, file: package://scene/wall.sdf}
- add_weld:
    {parent: world, child: wall::wall, X_PC: {translation: [0.4, 0.1, 0.1]}}
- add_model: {name: pillar, file: package://scene/pillar.sdf}
- add_weld:
    parent: world
    child: pillar::pillar
    X_PC: {translation: [0.3, -0.1, 0.1], rotation: !Rpy {deg: [20, 10, 0]}}
- add_model: {name: table, file: package://scene/table.sdf}
- add_weld:
    {parent: world, child: table::table, X_PC: {translation: [0, 0, -0.15]}}
"""
ROLES = """
robot: arm
tracked: {box: {}, can: {}}
camera:
  X_WC: {translation: [1, 0, 0.35], rotation: !Rpy {deg: [-110, 0, 90]}}
"""
OBJECTS = ["box", "can"]


def _both(inner):
    """The same geometry to see and to hit."""
    return f"<visual>{inner}</visual><collision>{inner}</collision>"


def _load(folder, text):
    for name, shape in SHAPES.items():
        geometry = f"<geometry>{shape}</geometry>"
        (folder / f"{name}.sdf").write_text(
            f"<sdf version='1.7'><model name='{name}'><link name='{name}'>"
            f"<visual name='v'>{geometry}</visual>"
            f"<collision name='c'>{geometry}</collision></link></model></sdf>"
        )
    arm = ARM.format(upper=_both(BAR), lower=_both(ROD))
    (folder / "arm.urdf").write_text(arm)
    (folder / "scene.yaml").write_text(text)
    return LoadScene(folder / "scene.yaml")


class _World:
    """The scene as Drake has it, with one particle's poses in it."""

    def __init__(self, scene, *, renders=False):
        builder = RobotDiagramBuilder(time_step=0.0)
        if renders:
            builder.scene_graph().AddRenderer(
                "vtk", MakeRenderEngineVtk(RenderEngineVtkParams())
            )
        self.models = AddSceneModels(builder.plant(), scene)
        self.camera = scene.camera
        self.diagram = builder.Build()
        self.plant = self.diagram.plant()
        self.root = self.diagram.CreateDefaultContext()

    def SetPoses(self, particle, q):
        context = self.diagram.mutable_plant_context(self.root)
        self.plant.SetPositions(context, self.models.robot, q)
        for index, pose in zip(self.models.objects, particle, strict=True):
            X_WO = RigidTransform(Quaternion(wxyz=pose[:4]), pose[4:7])
            self.plant.SetFreeBodyPose(
                context, self.plant.get_body(index), X_WO
            )

    def query_object(self):
        scene_graph = self.diagram.scene_graph()
        return scene_graph.get_query_output_port().Eval(
            self.diagram.scene_graph_context(self.root)
        )

    def Sees(self, k):
        """Returns where in a rendered image object k is, (height, width)."""
        c = self.camera
        info = CameraInfo(
            width=c.width,
            height=c.height,
            focal_x=c.fx,
            focal_y=c.fy,
            center_x=c.cx,
            center_y=c.cy,
        )
        core = RenderCameraCore(
            "vtk", info, ClippingRange(0.01, 10.0), RigidTransform()
        )
        image = self.query_object().RenderLabelImage(
            camera=ColorRenderCamera(core),
            parent_frame=self.diagram.scene_graph().world_frame_id(),
            X_PC=c.pose(),
        )
        return np.array(image.data)[..., 0] == int(self.models.objects[k])


def _surface_points(name, rng, n):
    """Independent points, uniform over a box or a can."""
    if name == "box":
        h = 0.5 * np.array([0.16, 0.21, 0.06])
        areas = np.tile(np.prod(h) / h, 2)
        face = rng.choice(6, n, p=areas / areas.sum())
        p = rng.uniform(-1, 1, (n, 3))
        p[np.arange(n), face % 3] = np.where(face < 3, 1, -1)
        return p * h
    radius, length = 0.05, 0.14
    angle = rng.uniform(0, 2 * np.pi, n)
    distance, z = np.full(n, radius), rng.uniform(-1, 1, n) * length / 2
    on_end = rng.random(n) < radius / (radius + length)
    distance[on_end] = radius * np.sqrt(rng.random(on_end.sum()))
    z[on_end] = np.where(z[on_end] > 0, 0.5, -0.5) * length
    return np.stack(
        [distance * np.cos(angle), distance * np.sin(angle), z], axis=-1
    )


def _pixels(camera, p_WT):
    """Returns the points' columns and rows, and which are in the image."""
    x, y, z = camera.pose().inverse() @ p_WT.T
    u = np.rint(camera.cx + camera.fx * x / z).astype(int)
    v = np.rint(camera.cy + camera.fy * y / z).astype(int)
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    return np.where(inside, u, 0), np.where(inside, v, 0), inside & (z > 0)


def _label_reference(world, alone, particle, k, rng):
    """The share of surface points whose pixel shows the object.

    At its outline, pixels of points on it need not show the object even when
    it is alone: the image can't tell there, and those points don't count.
    """
    p_OT = _surface_points(OBJECTS[k], rng, 20000)
    p_WT = particle[k, 4:] + quaternions.rotate(particle[k, :4], p_OT)
    u, v, inside = _pixels(world.camera, p_WT)
    seen = inside & world.Sees(k)[v, u]
    return np.mean(seen[~inside | alone.Sees(k)[v, u]])


def _particles(rng, num):
    """Objects before and behind the obstacles and the arm, turned anyhow."""
    q = quaternions.normalize(rng.normal(size=(num, 2, 4)))
    p = rng.uniform([0.0, -0.3, 0.0], [0.5, 0.3, 0.2], (num, 2, 3))
    return np.concatenate([q, p], axis=-1)


def test_visibility_agrees_with_label_images(tmp_path):
    scene = _load(tmp_path, MODELS + FIXED + ROLES)
    away = MODELS.replace("[-0.3, 0, 0.25]", "[9, 0, 0]")
    world = _World(scene, renders=True)
    alone = _World(_load(tmp_path, away + ROLES), renders=True)
    fine = VisibilityModel(scene=scene, num_rays=2000)
    default = ParticleFilterConfig().num_rays
    coarse = VisibilityModel(scene=scene, num_rays=default)
    rng = np.random.default_rng(4)
    far = np.array([1, 0, 0, 0, 9, 0, 0.0])
    references, scores, coarse_scores = [], [], []
    for particle in _particles(rng, 10):
        q = rng.uniform([-0.6, -0.3], [0.6, 0.5])
        world.SetPoses(particle, q)
        for k in range(2):
            alone.SetPoses(
                [particle[k] if j == k else far for j in range(2)], q
            )
            references.append(_label_reference(world, alone, particle, k, rng))
        for model, results in ((fine, scores), (coarse, coarse_scores)):
            v = model.Score(
                particles=particle[None],
                known=np.full(2, True),
                robot_positions=q,
                rng=rng,
                scratch=model.MakeScratch(),
            )
            results.extend(v[0])
    assert np.count_nonzero(np.abs(np.array(references) - 0.5) < 0.45) >= 10
    np.testing.assert_allclose(scores, references, atol=0.02)
    np.testing.assert_allclose(coarse_scores, references, atol=0.05)


def _first_bodies(world, p_WT):
    """Returns which bodies sphere tracing first meets on the way."""
    query_object = world.query_object()
    inspector = query_object.inspector()
    origin = world.camera.pose().translation()
    # A little beyond the target, lest the walk ends before the surface.
    met = [
        trace(query_object, origin, p + 1e-6 * (p - origin))[1] for p in p_WT
    ]
    frames = [inspector.GetFrameId(id) for id in met]
    return [world.plant.GetBodyFromFrameId(f).index() for f in frames]


def test_visibility_agrees_with_sphere_tracing_in_the_papers_scene():
    scenes = data_folder("diagrams") / "scenes"
    scene = LoadScene(scenes / "cheezit_1.yaml")
    model, world = VisibilityModel(scene=scene, num_rays=48), _World(scene)
    box = world.plant.get_body(world.models.objects[0])
    nominal = world.plant.GetPositions(world.plant.CreateDefaultContext())
    joints = world.plant.GetPositionsFromArray(world.models.robot, nominal)
    start = nominal[box.floating_positions_start() :][:7]
    surface = BodySurface(
        shapes=[Box(0.16, 0.21344, 0.061)], X_BG=[RigidTransform()]
    )
    rng = np.random.default_rng(0)
    scores, met = [], set()
    for seed in range(6):
        turn = quaternions.from_rotation_vector(rng.normal(0, 0.3, 3))
        q_WO = quaternions.multiply(turn, start[:4])
        p_WO = start[4:] + rng.uniform([-0.2, -0.15, -0.02], [0.2, 0.4, 0.1])
        particle = np.concatenate([q_WO, p_WO])
        positions = joints + rng.normal(0, 0.2, joints.shape)
        v = model.Score(
            particles=particle[None, None],
            known=np.array([True]),
            robot_positions=positions,
            rng=np.random.default_rng(seed),
            scratch=model.MakeScratch(),
        ).item()
        world.SetPoses(particle[None], positions)
        p_OT = surface.sample(np.random.default_rng(seed), 48)
        p_WT = p_WO + quaternions.rotate(q_WO, p_OT)
        first = _first_bodies(world, p_WT)
        inside = _pixels(scene.camera, p_WT)[2]
        reference = np.mean(inside & [i == box.index() for i in first])
        assert abs(v - reference) <= 1 / 48
        scores.append(v)
        met |= set(first)
    assert len(np.unique(scores)) >= 4
    robot = set(world.plant.GetBodyIndices(world.models.robot))
    assert met & robot and met & set(world.models.fixed)
