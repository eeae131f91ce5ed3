"""What a user brings: an arm, an object and a scene that aren't the paper's."""

from pathlib import Path

import numpy as np

# Universal Robots' published Denavit-Hartenberg parameters of the UR5e: a, d
# (in meters) and alpha (in radians) of each joint.
UR5E = (
    (0.0, 0.1625, np.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, np.pi / 2),
    (0.0, 0.0997, -np.pi / 2),
    (0.0, 0.0996, 0.0),
)
_LINK = """
  <link name="link{i}">
    <inertial>
      <mass value="2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    {shapes}
  </link>"""
# A thick line from the joint's axis to the next joint.
_SHAPE = """
    <{role}><origin xyz="{x} {y} {z}" rpy="0 {pitch} 0"/>
      <geometry><capsule radius="{radius}" length="{length}"/></geometry>
    </{role}>"""
# A joint turns about z; then come d along z, a along x, and alpha about x.
_JOINT = """
  <joint name="joint{i}" type="revolute">
    <parent link="link{before}"/><child link="link{i}"/>
    <origin xyz="{a} 0 {d}" rpy="{alpha} 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-6.28" upper="6.28" effort="150" velocity="3"/>
  </joint>
  <transmission name="transmission{i}">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="joint{i}"/>
    <actuator name="actuator{i}"/>
  </transmission>"""


def _shape(length: float, along: str, radius: float) -> str:
    """A capsule from the link's origin along x or z."""
    middle = {"x": 0.0, "z": 0.0, along: length / 2}
    return "".join(
        _SHAPE.format(
            role=role,
            x=middle["x"],
            y=0,
            z=middle["z"],
            pitch=np.pi / 2 if along == "x" else 0.0,
            radius=radius,
            length=abs(length),
        )
        for role in ("visual", "collision")
    )


def write_arm(path: Path) -> None:
    """Writes a UR5e of capsules, with a rod of 0.15 m for a tool."""
    parts = [_LINK.format(i=0, shapes="")]
    a = d = alpha = 0.0
    for i, (next_a, next_d, next_alpha) in enumerate(UR5E, 1):
        shapes = ""
        if next_d:
            shapes += _shape(next_d, "z", 0.04)
        if next_a:
            shapes += _shape(next_a, "x", 0.04)
        if i == len(UR5E):
            shapes = _shape(next_d + 0.15, "z", 0.012)
        parts.append(_LINK.format(i=i, shapes=shapes))
        parts.append(_JOINT.format(i=i, before=i - 1, a=a, d=d, alpha=alpha))
        a, d, alpha = next_a, next_d, next_alpha
    path.write_text(f'<robot name="ur5e">{"".join(parts)}\n</robot>\n')


def write_mug(path: Path, *, scale: float = 1.0) -> None:
    """Writes a mug as an open mesh: a ring of 24 sides, with a bottom."""
    angles = 2 * np.pi * np.arange(24) / 24
    ring = 0.04 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = [(*p, z) for z in (0.0, 0.09) for p in ring]
    lines = ["v " + " ".join(f"{scale * x:.6f}" for x in p) for p in corners]
    for i in range(24):
        j = (i + 1) % 24
        lines.append(f"f {i + 1} {j + 1} {j + 25} {i + 25}")
    lines.append("f " + " ".join(str(i) for i in range(24, 0, -1)))
    path.write_text("\n".join(lines) + "\n")


SCENE = """
directives:
- add_model: {name: table, file: package://pbpf_drake/table/table.sdf}
- add_weld:
    parent: world
    child: table::table
    X_PC: {translation: [0.5, 0.0, 0.0]}
- add_model:
    name: arm
    file: package://scene/ur5e.urdf
    default_joint_positions:
      joint1: [2.5528]
      joint2: [-1.2661]
      joint3: [2.2259]
      joint4: [-2.5297]
      joint5: [-1.5701]
      joint6: [0.0]
- add_weld:
    parent: world
    child: arm::link0
    X_PC: {translation: [0.0, 0.0, 0.05]}
- add_model:
    name: mug
    file: package://scene/mug.obj
    default_free_body_pose:
      mug: {translation: [0.45, -0.05, 0.0]}

robot: arm
tracked: {mug: {}}
camera:
  X_WC:
    translation: [1.15, 0.1, 0.6]
    rotation: !Rpy {deg: [-125.0, 0.0, 90.0]}

recording:
  duration: 3.0
  time_step: 0.002
  stiffness: [600, 600, 600, 250, 150, 50]
  damping: [50, 50, 50, 30, 25, 15]
  path:
    end_effector: link6
    waypoints:
    - {time: 0.2, translation: [0.0, 0.0, 0.0]}
    - {time: 2.8, translation: [0.0, 0.15, 0.0]}
"""
