"""What the paper reports (Tables 1 and 2), and how often it measured it."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class MeanErrors:
    """Mean and standard deviation, pooled over runs and time.

    Attributes:
        pos_mean, pos_std: of the position error (in meters).
        rot_mean, rot_std: of the rotation error (in radians).
    """

    pos_mean: float
    pos_std: float
    rot_mean: float
    rot_std: float


# The scene files of the paper's eight scenes, in its order.
SCENES = (
    "cheezit_1",
    "cheezit_2",
    "cheezit_3",
    "cheezit_4",
    "soup_1",
    "soup_2",
    "soup_3",
    "scene_5",
)
# What the paper calls the models.
OBJECT_TITLES = {"cracker": "Cheezit", "gelatin": "Gelatin", "soup": "Soup"}
METHOD_TITLES = {
    "pbpf": "PBPF",
    "pbpf-v": "PBPF-V",
    "dope": "DOPE",
    "cvpf": "CVPF",
}

# By scene, tracked model and method.
PAPER: Mapping[tuple[str, str, str], MeanErrors] = {
    ("cheezit_1", "cracker", "pbpf"): MeanErrors(0.081, 0.020, 0.484, 0.272),
    ("cheezit_1", "cracker", "pbpf-v"): MeanErrors(0.063, 0.020, 0.396, 0.295),
    ("cheezit_1", "cracker", "dope"): MeanErrors(0.289, 0.218, 1.345, 1.168),
    ("cheezit_1", "cracker", "cvpf"): MeanErrors(2.359, 7.421, 1.472, 0.951),
    ("cheezit_2", "cracker", "pbpf"): MeanErrors(0.070, 0.030, 0.426, 0.309),
    ("cheezit_2", "cracker", "pbpf-v"): MeanErrors(0.058, 0.021, 0.294, 0.204),
    ("cheezit_2", "cracker", "dope"): MeanErrors(0.293, 0.248, 1.046, 1.027),
    ("cheezit_2", "cracker", "cvpf"): MeanErrors(0.407, 0.678, 0.878, 0.952),
    ("cheezit_3", "cracker", "pbpf"): MeanErrors(0.019, 0.024, 0.367, 0.187),
    ("cheezit_3", "cracker", "dope"): MeanErrors(0.052, 0.033, 0.375, 0.447),
    ("cheezit_3", "cracker", "cvpf"): MeanErrors(25.14, 152.8, 0.879, 0.952),
    ("cheezit_4", "cracker", "pbpf"): MeanErrors(0.018, 0.008, 0.092, 0.067),
    ("cheezit_4", "cracker", "dope"): MeanErrors(0.017, 0.002, 0.201, 0.013),
    ("cheezit_4", "cracker", "cvpf"): MeanErrors(0.029, 0.012, 0.207, 0.022),
    ("soup_1", "soup", "pbpf"): MeanErrors(0.043, 0.023, 1.133, 0.364),
    ("soup_1", "soup", "pbpf-v"): MeanErrors(0.045, 0.027, 1.077, 0.395),
    ("soup_1", "soup", "dope"): MeanErrors(0.215, 0.117, 1.174, 0.372),
    ("soup_1", "soup", "cvpf"): MeanErrors(0.298, 0.153, 1.884, 0.794),
    ("soup_2", "soup", "pbpf"): MeanErrors(0.049, 0.032, 0.851, 0.249),
    ("soup_2", "soup", "pbpf-v"): MeanErrors(0.046, 0.028, 0.724, 0.262),
    ("soup_2", "soup", "dope"): MeanErrors(0.206, 0.112, 0.776, 0.222),
    ("soup_2", "soup", "cvpf"): MeanErrors(0.240, 0.126, 1.702, 0.845),
    ("soup_3", "soup", "pbpf"): MeanErrors(0.026, 0.021, 0.405, 0.455),
    ("soup_3", "soup", "dope"): MeanErrors(0.071, 0.140, 0.438, 0.482),
    ("soup_3", "soup", "cvpf"): MeanErrors(6.528, 52.09, 1.174, 0.982),
    ("scene_5", "cracker", "pbpf-v"): MeanErrors(0.031, 0.011, 0.126, 0.087),
    ("scene_5", "cracker", "dope"): MeanErrors(0.058, 0.108, 0.158, 0.337),
    ("scene_5", "gelatin", "pbpf-v"): MeanErrors(0.031, 0.023, 0.056, 0.030),
    ("scene_5", "gelatin", "dope"): MeanErrors(0.179, 0.665, 0.272, 0.410),
    ("scene_5", "soup", "pbpf-v"): MeanErrors(0.027, 0.013, 0.346, 0.139),
    ("scene_5", "soup", "dope"): MeanErrors(0.045, 0.029, 1.193, 1.192),
}

_RUNS_AND_REPEATS = {"scene_5": (1, 20)}


def paper_methods(scene: str) -> tuple[str, ...]:
    """Returns the methods that the paper evaluated in a scene, maybe none."""
    return tuple(dict.fromkeys(m for s, _, m in PAPER if s == scene))


def paper_runs_and_repeats(scene: str) -> tuple[int, int]:
    """Returns how many runs of a scene, and evaluations of each, there were.

    For a scene that isn't the paper's, they are those of Scenes 1 to 4.
    """
    return _RUNS_AND_REPEATS.get(scene, (10, 10))
