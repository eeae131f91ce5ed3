"""Places the messages of all topics of a log on one line of time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.bags.log_notes import LogNotes, TopicNotes
from pbpf_drake.log.detection_ages import ahead_warning
from pbpf_drake.log.log_clock import LogClock, find_clock
from pbpf_drake.log.log_samples import RawStamped, SampleT, Stamped
from pbpf_drake.log.log_stretches import LogStretch, find_stretch


@dataclass(frozen=True)
class LogTimeline:
    """When the messages of a log are.

    Attributes:
        stretch: the part of the log that is used.
        clock: how log times and stamps are related in it.
    """

    stretch: LogStretch
    clock: LogClock

    def Place(
        self, messages: Sequence[RawStamped[SampleT]], notes: TopicNotes
    ) -> list[Stamped[SampleT]]:
        """Returns the messages of a topic in the order received.

        Args:
            messages: in any order.
            notes: counts what is left out.
        """
        return self.clock.Place(self.stretch.Of(messages, notes), notes)

    def AheadWarning(self, messages: Sequence[RawStamped[object]]) -> str:
        """Returns a clause if the sender's clock is ahead, or nothing.

        Args:
            messages: of one sender.
        """
        ahead = [
            m.stamp - m.log_time + self.clock.delay
            for m in messages
            if m.stamp and self.stretch.Has(m)
        ]
        if not ahead or not self.clock.is_shared:
            return ""
        return ahead_warning(np.array(ahead) / 1e9)


def find_timeline(
    reference: Sequence[RawStamped[object]], notes: LogNotes
) -> LogTimeline:
    """Returns the line of time of a log.

    Args:
        reference: the messages of a topic that has some all the time, with
            little delay; at least one.
        notes: says what is special about their times.
    """
    stretch = find_stretch(reference, notes)
    in_it = [m for m in reference if stretch.Has(m)]
    return LogTimeline(stretch, find_clock(in_it, notes))
