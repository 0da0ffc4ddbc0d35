"""Administration of a real daemon.

In: the environment variable `HOPES_BIN`, as in `test_daemon`. Invariants: as in `test_daemon`.
"""

from __future__ import annotations

import unittest

import hopes_client as hopes

from .test_daemon import HOPES_BIN, SQUARE, TIMEOUT, WithDaemon


@unittest.skipUnless(HOPES_BIN, "HOPES_BIN is not set: there is no daemon to test against")
class Administration(WithDaemon):
    def named(self, software: str) -> hopes.Daemon:
        daemon = hopes.connect(self.process.tcp, timeout=TIMEOUT, software=software)
        self.addCleanup(daemon.close)
        return daemon

    def test_peers(self) -> None:
        software = f"{self.name} sensör"
        sensor = self.named(software)
        sensor.producer(self.name)
        found = [peer for peer in self.daemon.peers() if peer.software == software]
        self.assertEqual(len(found), 1)
        peer = found[0]
        self.assertEqual((peer.place, peer.producers, peer.consumers), (self.process.tcp, 1, 0))
        self.assertGreaterEqual(peer.connected_ms, peer.silent_ms)
        self.assertGreater(min(peer.received, peer.sent), 0)

    def test_disconnect(self) -> None:
        victim = self.named(self.name)
        number = next(peer.peer for peer in self.daemon.peers() if peer.software == self.name)
        self.daemon.disconnect(number)
        with self.assertRaises(hopes.ConnectionLost):
            for _ in range(100):
                victim.list_streams()
        with self.assertRaises(hopes.DaemonError) as caught:
            self.daemon.disconnect(2**64 - 1)
        self.assertEqual(caught.exception.code, 18)
        self.assertEqual(self.daemon.list_streams(self.name), [], "the others go on")

    def test_stop_stream(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, SQUARE)
        subscription = self.follow(daemon=self.another_connection())
        self.assertEqual(next(subscription).number, 1)
        self.assertEqual(self.another_connection().stop_stream(self.name), 1)
        self.assertEqual(list(subscription), [], "it has ended")
        with self.assertRaises(hopes.StreamEnded) as ended:
            stream.send(SQUARE)
            stream.commit()
        self.assertEqual(ended.exception.frame, 1)
        with self.assertRaises(hopes.DaemonError) as caught:
            self.daemon.stop_stream(self.name)
        self.assertEqual(caught.exception.code, 17)

    def test_memory(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, [(float(i), float(i * i)) for i in range(1000)])
        memory = self.daemon.memory()
        mine = next(share for share in memory.streams if share.name == self.name)
        self.assertEqual(memory.limit, 0)
        self.assertGreater(mine.points, 16_000)
        parts = sum(share.points + share.views + share.queue for share in memory.streams) + memory.peers
        self.assertGreaterEqual(memory.held, parts)
