"""Producers.

In: points, with the producer's own times and tags. Out: `Batch`, `Retract` and `Commit` messages, or their forms for
spaces; an `Answer` for each
`send` and `retract`, a frame number for each `commit`. Invariants: messages are pipelined, but at most
`MOST_UNANSWERED` wait for their answer. Every message is answered in the end, or the producer (or the connection) fails
with the reason. The list of refusals is bounded, their count is not.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from types import TracebackType
from typing import Any, Callable

from .batches import AnyBatch, AnyRetract, SpaceBatches, batches_for, most_points
from .codec import Packed
from .connection import Connection, as_exception
from .errors import ConnectionLost, HopesError, ProtocolError, StreamEnded, TimedOut
from .messages import (
    Accepted,
    Close,
    Closed,
    Commit,
    Committed,
    Error,
    Message,
    Opened,
    Overloaded,
    Refusal,
    Refused,
)
from .points import Numbers, Points, list_tags, pack_numbers
from .shared import Window
from .spaces import Metric
from .timing import Deadline

#: How many messages may wait for their answers.
MOST_UNANSWERED = 32
#: How many refusals a producer keeps, the newest ones.
MOST_REFUSALS = 10_000

# The largest size of everything in a batch but points, times and tags, in bytes.
_BATCH_OVERHEAD = 64


@dataclass(eq=False)
class Answer:
    """The outcome of one `send` or `retract`.

    `refused` has the reasons (the first 1,000 of each batch) with the index in the sent points. `placed` has the vertex
    of each tag. Numbers grow until `done`.
    """

    points: int
    accepted: int = 0
    refused_count: int = 0
    dropped: int = 0
    refused: list[Refusal] = field(default_factory=list)
    placed: dict[int, int] = field(default_factory=dict)
    _missing: int = field(default=0, repr=False)
    _producer: Producer | None = field(default=None, repr=False)

    @property
    def done(self) -> bool:
        """Whether all answers have arrived."""
        return self._missing == 0

    def wait(self, timeout: float | None = None) -> Answer:
        """Waits until the answer is complete, and returns it."""
        if self._producer is not None:
            self._producer.await_answer(self, timeout)
        return self


@dataclass(frozen=True)
class _Part:
    """One message of an answer, and the index of its first point."""

    answer: Answer
    start: int


class Producer:
    """A producer of a stream. Leaving a `with` block waits for all answers and closes it. The stream stays.

    `refused` keeps the newest refusals, `refused_count` counts all. `accepted` and `dropped` (by overload) count
    points. `frame` is the newest known frame.
    """

    def __init__(
        self,
        connection: Connection,
        name: str,
        window: Window | None = None,
        resolution: float | None = None,
        timeout: float | None = None,
        metric: str | Metric | None = None,
        dimension: int | None = None,
    ) -> None:
        self.name = name
        self.accepted = 0
        self.refused: deque[Refusal] = deque(maxlen=MOST_REFUSALS)
        self.refused_count = 0
        self.dropped = 0
        self._connection = connection
        self._sequence = 0
        # By sequence number, in the order of sending. None stands for a commit.
        self._unanswered: dict[int, _Part | None] = {}
        self._closed = False
        # Why nothing more can be sent.
        self._end: HopesError | None = None
        self._batches = batches_for(metric, dimension)
        self._channel = connection.open_channel()
        try:
            question = self._batches.question(name, window, resolution)
            answer: Any = connection.ask(self._channel, question, self._batches.expected, connection.allowed(timeout))
        except BaseException:
            connection.close_channel(self._channel)
            raise
        self.opened: Opened = self._batches.opened(answer)
        self.frame = self.opened.frame

    @property
    def is_open(self) -> bool:
        """Whether more can be sent, as far as is known."""
        return self._end is None

    @property
    def metric(self) -> Metric | None:
        """The metric of a stream in R^d. None in the plane."""
        return self._batches.metric if isinstance(self._batches, SpaceBatches) else None

    @property
    def dimension(self) -> int | None:
        """The number of coordinates of a point: 2 in the plane. None: the first point fixes it."""
        return self._batches.dimension

    @property
    def unanswered(self) -> int:
        """The number of messages that wait for their answer."""
        return len(self._unanswered)

    def send(
        self,
        points: Points,
        *,
        times: Numbers | None = None,
        tags: Iterable[int] | Any | None = None,
        timeout: float | None = None,
    ) -> Answer:
        """Sends points: a list of (x, y), or an (n, 2) array. `times` and `tags` have one item for each, if given. A
        stream in R^d takes lists of d coordinates, or an (n, d) array.

        Does not wait for the answer (`Answer.wait` does), but waits if too many messages are unanswered. Points that do
        not fit into one batch are sent in several. `TimedOut.sent` is the number of points that were sent before.
        """
        packed = self._batches.pack(points)
        its_times = Packed(0, memoryview(b"")) if times is None else pack_numbers(times)
        its_tags = [] if tags is None else list_tags(tags)
        for count, what in ((its_times.count, "times"), (len(its_tags), "tags")):
            if count not in (0, packed.count):
                raise ValueError(f"there are {packed.count} points but {count} {what}")

        def batch(start: int, stop: int) -> AnyBatch:
            part_times = its_times.part(start, stop) if its_times.count else its_times
            return self._batches.batch(self._next(), packed.part(start, stop), part_times, its_tags[start:stop])

        return self._send_parts(packed, batch, timeout)

    def retract(self, points: Points, *, timeout: float | None = None) -> Answer:
        """Retracts the oldest point at each position. Waits no longer than `send` does."""
        packed = self._batches.pack(points)

        def retraction(start: int, stop: int) -> AnyRetract:
            return self._batches.retraction(self._next(), packed.part(start, stop))

        return self._send_parts(packed, retraction, timeout)

    def commit(self, time: float | None = None, *, timeout: float | None = None) -> int:
        """Commits a frame, waits for all answers, and returns the number of the frame."""
        deadline = Deadline(self._connection.allowed(timeout))
        self._send(Commit(self._next(), time), None, deadline)
        self._await_answers(deadline, 0)
        return self.frame

    def flush(self, timeout: float | None = None) -> None:
        """Waits for all answers."""
        self._await_answers(Deadline(self._connection.allowed(timeout)), 0)

    def await_answer(self, answer: Answer, timeout: float | None = None) -> None:
        """Waits until one answer is complete."""
        deadline = Deadline(self._connection.allowed(timeout))
        while not answer.done:
            self._await_answers(deadline, len(self._unanswered) - 1)

    def close(self, end: bool = False, timeout: float | None = None) -> int:
        """Waits for all answers and closes the producer, and ends the stream if `end`. Returns the last frame.

        Does nothing if the producer is closed already, or if the stream has ended.
        """
        deadline = Deadline(self._connection.allowed(timeout))
        self._await_answers(deadline, 0)
        if not self._closed:
            self._check()
            self._connection.send(self._channel, Close(end), deadline.left())
            while not self._closed:
                self._take(self._connection.receive(self._channel, deadline.left()))
            self._end = HopesError(f"the producer of {self.name!r} was closed")
        return self.frame

    def finish(self) -> None:
        """Waits for all answers and closes. No error if there are no missing answers and the daemon is gone."""
        self.flush()
        if self._end is None:
            with contextlib.suppress(ConnectionLost):
                self.close()

    def __enter__(self) -> Producer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()

    def _next(self) -> int:
        self._sequence += 1
        return self._sequence

    def _send_parts(
        self, packed: Packed, message: Callable[[int, int], AnyBatch | AnyRetract], timeout: float | None
    ) -> Answer:
        """Sends points in messages of a suitable size. `message` makes the one between two indices."""
        deadline = Deadline(self._connection.allowed(timeout))
        answer = Answer(packed.count, _producer=self)
        room = self._connection.welcome.largest_frame - _BATCH_OVERHEAD
        most = min(self.opened.largest_batch, most_points(packed, room))
        for start in range(0, packed.count, most):
            try:
                self._send(message(start, start + most), _Part(answer, start), deadline)
            except TimedOut as error:
                error.sent = start
                raise
            answer._missing += 1
        return answer

    def _send(self, message: AnyBatch | AnyRetract | Commit, part: _Part | None, deadline: Deadline) -> None:
        """Sends a message when the number of unanswered ones allows it."""
        self._take_waiting()
        self._await_answers(deadline, MOST_UNANSWERED - 1)
        self._check()
        self._connection.send(self._channel, message, deadline.left())
        self._unanswered[message.sequence] = part

    def _take_waiting(self) -> None:
        """Handles the answers that have arrived."""
        while self._end is None:
            message = self._connection.receive_waiting(self._channel)
            if message is None:
                return
            self._take(message)

    def _await_answers(self, deadline: Deadline, most: int) -> None:
        """Waits until at most `most` messages are unanswered."""
        while len(self._unanswered) > most:
            self._check()
            self._take(self._connection.receive(self._channel, deadline.left()))

    def _check(self) -> None:
        if self._end is not None:
            raise self._end.with_traceback(None)

    def _take(self, message: Message) -> None:
        """Handles a message from the daemon."""
        if isinstance(message, Closed):
            self._closed = True
            self.frame = message.frame
            self._end = StreamEnded(self.name, message.frame)
            self._connection.close_channel(self._channel)
        elif isinstance(message, Error):
            # The error does not say which message it answers, so the outcome of the unanswered ones is unknown.
            self._end = as_exception(message)
            raise self._end
        elif isinstance(message, Committed):
            self._settle(message.sequence)
            self.frame = message.frame
        elif isinstance(message, (Accepted, Refused, Overloaded)):
            part = self._settle(message.sequence)
            if part is None:
                raise ProtocolError(f"a commit was answered with {type(message).__name__}")
            self._count(part, message)
        else:
            raise ProtocolError(f"{type(message).__name__} came for a producer")

    def _settle(self, sequence: int) -> _Part | None:
        """The part of an answer that belongs to this message."""
        if sequence not in self._unanswered:
            raise ProtocolError(f"an answer came to message {sequence}, which waits for none")
        return self._unanswered.pop(sequence)

    def _count(self, part: _Part, message: Accepted | Refused | Overloaded) -> None:
        """Stores the outcome of one message."""
        answer = part.answer
        answer._missing -= 1
        if isinstance(message, Overloaded):
            answer.dropped += message.points
            self.dropped += message.points
            return
        answer.placed.update(message.placed)
        accepted = message.points if isinstance(message, Accepted) else message.accepted
        answer.accepted += accepted
        self.accepted += accepted
        if isinstance(message, Refused):
            refusals = [replace(refusal, index=part.start + refusal.index) for refusal in message.reasons]
            answer.refused += refusals
            answer.refused_count += message.refused
            self.refused += refusals
            self.refused_count += message.refused
