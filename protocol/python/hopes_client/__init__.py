"""Client of the `hopes` daemon, which computes the homologically persistent skeleton of live streams of points.

In: the address of a daemon, or a recording. Out: `connect` and `read_recording`, and their types. Invariant: the names
in `__all__` are the public interface. `hopes_client.messages` and `hopes_client.wire` are for programs that need the
protocol itself.
"""

from .admin import Peer, StreamMemory
from .connection import Options
from .consumer import FollowOptions, Subscription
from .daemon import Daemon, connect
from .errors import (
    BodyError,
    ConnectionLost,
    DaemonClosed,
    DaemonError,
    DaemonTooOld,
    HopesError,
    InboxFull,
    Incomplete,
    Malformed,
    PeerSilent,
    ProtocolError,
    ResyncNeeded,
    StaleFrame,
    StreamEnded,
    TimedOut,
    TooLarge,
    UnsupportedVersion,
    VersionMismatch,
)
from .frame import Frame
from .messages import Dot, Memory, Refusal, Status, StreamInfo, StreamStatus
from .mirror import Mirror
from .producer import Answer, Producer
from .recording import Recording, read_recording
from .shared import Cut, FrameHeader, Simplify, View, Window
from .shared import DotsWanted as Dots
from .spaces import Metric, SpaceDot, SpaceInfo, SpaceTrack, SpaceTrackEvent
from .tracks import Happening, Track, TrackChanges, TrackEvent
from .version import VERSION as __version__

__all__ = [
    "Answer",
    "BodyError",
    "ConnectionLost",
    "Cut",
    "Daemon",
    "DaemonClosed",
    "DaemonError",
    "DaemonTooOld",
    "Dot",
    "Dots",
    "FollowOptions",
    "Frame",
    "FrameHeader",
    "Happening",
    "HopesError",
    "InboxFull",
    "Incomplete",
    "Malformed",
    "Memory",
    "Metric",
    "Mirror",
    "Options",
    "Peer",
    "PeerSilent",
    "Producer",
    "ProtocolError",
    "Recording",
    "Refusal",
    "ResyncNeeded",
    "Simplify",
    "SpaceDot",
    "SpaceInfo",
    "SpaceTrack",
    "SpaceTrackEvent",
    "StaleFrame",
    "Status",
    "StreamEnded",
    "StreamInfo",
    "StreamMemory",
    "StreamStatus",
    "Subscription",
    "TimedOut",
    "TooLarge",
    "Track",
    "TrackChanges",
    "TrackEvent",
    "UnsupportedVersion",
    "VersionMismatch",
    "View",
    "Window",
    "__version__",
    "connect",
    "read_recording",
]
