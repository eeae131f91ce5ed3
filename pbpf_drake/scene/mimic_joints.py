"""Finds the robot's mimic joints in its model file.

Drake reads them, but doesn't tell.
"""

from xml.etree import ElementTree

from pydrake.multibody.parsing import PackageMap

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.model_facts import MimicJoint
from pbpf_drake.scene.model_packages import ResolveModelUrl, SceneFolder
from pbpf_drake.scene.scene_directives import FlatDirectives


def MimicJoints(scene: Scene, packages: PackageMap) -> dict[str, MimicJoint]:
    """Returns the robot's mimic joints by their names.

    Args:
        scene: its models have been parsed before.
        packages: where package:// leads to.

    Raises:
        ValueError: a mimic joint's number isn't one.
    """
    files = [
        ResolveModelUrl(d.add_model.file, SceneFolder(scene), packages)
        for d in FlatDirectives(scene, packages)
        if d.add_model is not None and d.add_model.name == scene.robot
    ]
    mimics: dict[str, MimicJoint] = {}
    for file in files:
        mimics |= parse_mimic_joints(file.read_bytes())
    return mimics


def parse_mimic_joints(text: bytes) -> dict[str, MimicJoint]:
    """Returns the mimic joints of a URDF or SDF file by their names.

    Args:
        text: of the file. What isn't XML has none.

    Raises:
        ValueError: a mimic joint's number isn't one.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return {}
    mimics = {}
    for joint in root.iter("joint"):
        # In URDF it is part of the joint, in SDF of the joint's axis.
        found = joint.find("mimic")
        mimic = joint.find("axis/mimic") if found is None else found
        if mimic is not None:
            name = joint.get("name", "")
            mimics[name] = _mimic_joint(name, mimic)
    return mimics


def _mimic_joint(name: str, mimic: ElementTree.Element) -> MimicJoint:
    def number(field: str, default: float) -> float:
        text = mimic.get(field) or mimic.findtext(field)
        try:
            return default if text is None else float(text)
        except ValueError:
            raise ValueError(
                f"joint {name!r}: mimic's {field} is {text!r}; expected a "
                "number"
            ) from None

    multiplier, offset = number("multiplier", 1.0), number("offset", 0.0)
    # SDF: q - offset = multiplier (q_leader - reference).
    offset -= multiplier * number("reference", 0.0)
    return MimicJoint(mimic.get("joint", ""), multiplier, offset)
