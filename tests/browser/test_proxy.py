"""The page behind a reverse proxy that shows it below a path.

In: a daemon, a proxy of the test. Out: whether the page loads and follows a stream through it.
Must not know: how the daemon checks hosts and origins.
"""

from __future__ import annotations

import socket
import socketserver
import threading
import unittest
from dataclasses import dataclass

from harness import TIMEOUT, BrowserTest, Daemon, Producer

PREFIX = "/hopes"


class Proxy(socketserver.ThreadingTCPServer):
    """Strips a path and passes everything on to a daemon, with the daemon's own `Host`."""

    daemon_threads = True
    daemon_host = ""

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.server_address[1]}"


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
        name, port = self.server.daemon_host.split(":")
        with socket.create_connection((name, int(port)), TIMEOUT) as daemon:
            daemon.settimeout(None)
            daemon.sendall("".join([*lines, "\r\n"]).encode())
            threading.Thread(target=self.pass_up, args=[daemon], daemon=True).start()
            while piece := daemon.recv(1 << 16):
                self.wfile.write(piece)

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


class BehindAProxy(BrowserTest):
    def test_the_page_loads_and_follows_below_a_path(self) -> None:
        proxy = Proxy(("127.0.0.1", 0), Request)
        self.addCleanup(proxy.server_close)
        threading.Thread(target=proxy.serve_forever, daemon=True).start()
        self.addCleanup(proxy.shutdown)
        daemon = Daemon(self, "--view-origin", f"http://{proxy.host}")
        proxy.daemon_host = daemon.host
        producer = Producer(self, daemon, rate=0)
        first = producer.make(1)
        page = self.open(Below(proxy.host))
        self.wait_for(page, "state.frame === argument", first)
        last = producer.make(2)
        state = self.wait_for(page, "state.frame === argument", last)
        self.assertGreater(state["points"], 0)


if __name__ == "__main__":
    unittest.main()
