"""The daemon is killed and restarted: the page says so, and follows the new one."""

from __future__ import annotations

import re
import unittest

from harness import BrowserTest, Daemon, Producer


class Restart(BrowserTest):
    def test_the_page_reconnects_to_a_restarted_daemon(self) -> None:
        # The browser itself logs that it cannot connect; a page cannot prevent that.
        self.tolerated = re.compile(r"WebSocket connection to '\S+' failed")
        daemon = Daemon(self, "--track", "view")
        producer = Producer(self, daemon, points=400)
        page = self.open(daemon)
        self.wait_for(page, "state.seen > 20")
        daemon.kill()
        page.locator("body[data-state=gone]").wait_for()
        self.assertEqual(page.inner_text("#state"), "gone")
        self.assertTrue(page.locator("#message").is_visible())
        self.assertEqual(page.inner_text("#message"), "The daemon does not answer. Trying again …")
        self.assertFalse(self.state(page)["connected"])
        producer.stop()

        daemon.start()
        self.wait_for(page, "state.connected")
        successor = Producer(self, daemon, points=300, seed=2)
        self.wait_for(page, "state.points === 300 && state.vertices === 300 && state.seen > 0 && state.seen < 20")
        self.wait_for(page, "state.seen >= argument && state.tracks > 0", successor.newest + 20)
        self.assertEqual(page.inner_text("#state"), "live")
        self.assertFalse(page.locator("#message").is_visible())
        self.assertGreater(self.see(page).point, 300)


if __name__ == "__main__":
    unittest.main()
