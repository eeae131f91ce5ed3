"""A small scene with shapes and colors, and what Meshcat makes of it."""

import base64
from pathlib import Path
import struct

from pydrake.geometry import Meshcat

from pbpf_drake.scene import LoadScene, Scene

_ARM = """<?xml version="1.0"?>
<sdf version="1.7"><model name="arm">
  <link name="base">
    <visual name="foot">
      <geometry><box><size>0.1 0.1 0.02</size></box></geometry>
    </visual>
  </link>
  <link name="hand">
    <visual name="ball">
      <geometry><sphere><radius>0.03</radius></sphere></geometry>
      <material><diffuse>0.25 0.5 0.75 1</diffuse></material>
    </visual>
  </link>
  <link name="invisible"/>
  <joint name="slide" type="prismatic">
    <parent>base</parent><child>hand</child>
    <axis><xyz>0 1 0</xyz></axis>
  </joint>
  <joint name="turn" type="revolute">
    <parent>hand</parent><child>invisible</child>
    <axis><xyz>0 0 1</xyz></axis>
  </joint>
</model></sdf>
"""
_BOX = """<?xml version="1.0"?>
<sdf version="1.7"><model name="box"><link name="box">
  <visual name="label">
    <geometry><box><size>0.05 0.05 0.2004</size></box></geometry>
    <material><diffuse>1 1 0 1</diffuse></material>
  </visual>
  <visual name="carton">
    <pose>0 0 0 0 0 0</pose>
    <geometry><box><size>0.1 0.15 0.2</size></box></geometry>
    <material><diffuse>0.8 0 0 1</diffuse></material>
  </visual>
</link></model></sdf>
"""
_WALL = """<?xml version="1.0"?>
<sdf version="1.7"><model name="wall"><link name="wall">
  <visual name="wall">
    <pose>0 0 0.1 0 0 0</pose>
    <geometry><cylinder><radius>0.02</radius><length>0.2</length></cylinder>
    </geometry>
  </visual>
</link></model></sdf>
"""
_SCENE = """
directives:
- add_model: {name: arm, file: package://scene/arm.sdf}
- add_weld:
    parent: world
    child: arm::base
    X_PC: {translation: [0.0, -0.5, 0.25]}
- add_model: {name: wall, file: package://scene/wall.sdf}
- add_weld:
    parent: world
    child: wall::wall
    X_PC: {translation: [0.375, 0.125, 0.0]}
- add_model:
    name: red
    file: package://scene/box.sdf
    default_free_body_pose: {box: {translation: [0.5, 0.0, 0.1]}}
- add_model:
    name: blue
    file: package://scene/box.sdf
    default_free_body_pose: {box: {translation: [0.7, 0.0, 0.1]}}
robot: arm
tracked: {red: {}, blue: {}}
camera:
  X_WC: {translation: [1.6, 0.0, 0.1], rotation: !Rpy {deg: [-90, 0, 90]}}
filter: {period: 0.25, max_detection_age: 0.2}
"""


def write_visual_scene(folder) -> Scene:
    """Returns a scene of an arm (2 joints), a wall and two boxes."""
    for name, text in (("arm", _ARM), ("box", _BOX), ("wall", _WALL)):
        (folder / f"{name}.sdf").write_text(text)
    (folder / "scene.yaml").write_text(_SCENE)
    return LoadScene(folder / "scene.yaml")


class Page:
    """What a page of Meshcat tells a browser, as packed messages.

    Attributes:
        commands: in their order.
    """

    def __init__(self, source: Meshcat | Path):
        """Reads a saved page, or what Meshcat would save now."""
        is_saved = isinstance(source, Path)
        html = source.read_text("utf-8") if is_saved else source.StaticHtml()
        parts = html.split("data:application/octet-binary;base64,")[1:]
        self.commands = [
            base64.b64decode(part[: part.index('"')]) for part in parts
        ]

    def find(self, kind: str, path: str) -> list[bytes]:
        """Returns the messages of a kind, such as "set_object", on a path."""
        path = path if path.startswith("/") else f"/drake/{path}"
        return [
            c for c in self.commands if kind.encode() in c and has_text(c, path)
        ]


def has_text(command: bytes, text: str) -> bool:
    """Tells if a packed message has exactly this string."""
    data = text.encode()
    length = len(data)
    header = [0xA0 | length] if length < 32 else [0xD9, length]
    return bytes(header) + data in command


def has_number(command: bytes, number: float) -> bool:
    """Tells if a packed message has this number to the last bit."""
    return b"\xcb" + struct.pack(">d", number) in command
