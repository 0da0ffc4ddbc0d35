"""The page behind a reverse proxy that shows it below a path.

In: a daemon, a proxy of the test. Out: whether the page loads and follows a stream through it.
Must not know: how the daemon checks hosts and origins.
"""

from __future__ import annotations

import re
import socket
import socketserver
import threading
import unittest
from dataclasses import dataclass

from harness import TIMEOUT, BrowserTest, Daemon, Producer, until

PREFIX = "/hopes"


class Proxy(socketserver.ThreadingTCPServer):
    """Strips a path and passes everything on to a daemon, with the daemon's own `Host`."""

    daemon_threads = True
    daemon_host = ""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Request)
        #: The last event that each client of events has, as it says; and their connections.
        self.asked: list[str] = []
        self.events: list[socket.socket] = []

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.server_address[1]}"

    def end_events(self) -> None:
        """Breaks the connections of all clients of events."""
        while self.events:
            self.events.pop().shutdown(socket.SHUT_RDWR)


class Request(socketserver.StreamRequestHandler):
    """A request, then all bytes in both directions."""

    server: Proxy

    def handle(self) -> None:
        method, path, version = self.rfile.readline().decode().split()
        if not path.startswith(f"{PREFIX}/"):
            self.wfile.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
            return
        lines = [f"{method} {path.removeprefix(PREFIX)} {version}\r\n"]
        while (line := self.rfile.readline().decode()) not in ("\r\n", ""):
            lines.append(f"Host: {self.server.daemon_host}\r\n" if line.lower().startswith("host:") else line)
        if "/frames?" in path:
            last = [line.split(": ", 1)[1].strip() for line in lines if line.lower().startswith("last-event-id:")]
            self.server.asked.append("".join(last))
            self.server.events.append(self.connection)
        name, port = self.server.daemon_host.split(":")
        with socket.create_connection((name, int(port)), TIMEOUT) as daemon:
            daemon.settimeout(None)
            daemon.sendall("".join([*lines, "\r\n"]).encode())
            threading.Thread(target=self.pass_up, args=[daemon], daemon=True).start()
            self.pass_down(daemon)

    def pass_down(self, daemon: socket.socket) -> None:
        try:
            while piece := daemon.recv(1 << 16):
                self.wfile.write(piece)
        except OSError:
            pass  # The browser has ended the connection.

    def pass_up(self, daemon: socket.socket) -> None:
        try:
            while piece := self.rfile.read1(1 << 16):
                daemon.sendall(piece)
            daemon.shutdown(socket.SHUT_WR)
        except OSError:
            pass  # The daemon has ended the connection.


@dataclass
class Below:
    """The page at its path of a proxy."""

    host: str

    @property
    def url(self) -> str:
        return f"http://{self.host}{PREFIX}/"


# The numbers of the frames that a browser gets as events, and their ids.
FOLLOW = """() => {
  window.seen = [];
  const frames = new EventSource("api/streams/scan/frames?k=1");
  frames.addEventListener("frame", ({ data, lastEventId }) => seen.push([JSON.parse(data).frame, lastEventId]));
}"""


class BehindAProxy(BrowserTest):
    def start(self) -> tuple[Proxy, Producer]:
        proxy = Proxy()
        self.addCleanup(proxy.server_close)
        threading.Thread(target=proxy.serve_forever, daemon=True).start()
        self.addCleanup(proxy.shutdown)
        daemon = Daemon(self, "--view-origin", f"http://{proxy.host}")
        proxy.daemon_host = daemon.host
        return proxy, Producer(self, daemon, rate=0)

    def test_the_page_loads_and_follows_below_a_path(self) -> None:
        proxy, producer = self.start()
        first = producer.make(1)
        page = self.open(Below(proxy.host))
        self.wait_for(page, "state.frame === argument", first)
        last = producer.make(2)
        state = self.wait_for(page, "state.frame === argument", last)
        self.assertGreater(state["points"], 0)

    def test_a_browser_takes_frames_as_events_and_goes_on_after_a_loss(self) -> None:
        self.tolerated = re.compile("ERR_INCOMPLETE_CHUNKED_ENCODING|ERR_CONNECTION|ERR_EMPTY_RESPONSE")
        proxy, producer = self.start()
        producer.make(1)
        page = self.open(Below(proxy.host))
        page.evaluate(FOLLOW)
        page.wait_for_function("seen.length === 1")
        producer.make(1)
        page.wait_for_function("seen.length === 2")
        proxy.end_events()
        # The browser asks again by itself, with the last id: no frame comes twice.
        page.wait_for_function("seen.length === 2")
        until(lambda: len(proxy.asked) == 2, "the browser does not ask again")
        last = producer.make(1)
        page.wait_for_function("seen.length === 3")
        seen = page.evaluate("seen")
        self.assertEqual([number for number, _ in seen], [1, 2, last])
        self.assertEqual(proxy.asked, ["", seen[1][1]])


if __name__ == "__main__":
    unittest.main()
