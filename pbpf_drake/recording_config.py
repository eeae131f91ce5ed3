"""Configuration of the truth simulation that records a log of a scene.

Nothing here is known to the filter: contact model, step, friction, mass and
the detector's errors are the truth's own.
"""

from dataclasses import dataclass, field


@dataclass(kw_only=True)
class RecordingConfig:
    """How diagrams/record_scene.py simulates a scene."""

    # Length of the log (in seconds).
    duration: float = 25.0
