//! Daemons that are started at once at one path: exactly one of them gets it.

use rustix::process::Signal;

use crate::common::peers::{Daemon, ProducerAndConsumer, serve_at, socket_in};
use crate::common::process::{Running, eventually};

const RIVALS: usize = 6;

#[test]
fn of_daemons_that_start_at_once_exactly_one_listens() {
    for round in 0..5 {
        let folder = tempfile::tempdir().unwrap();
        let socket = socket_in(&folder);
        if round % 2 == 1 {
            leave_a_socket_behind(&socket);
        }
        let mut rivals: Vec<Running> = (0..RIVALS).map(|_| serve_at(&socket).start()).collect();
        let place = eventually("all but one have ended", || {
            let alive: Vec<usize> = (0..RIVALS).filter(|&rival| rivals[rival].is_alive()).collect();
            if let [last] = alive[..] { Some(last) } else { None }
        });
        let mut winner = rivals.swap_remove(place);
        for rival in rivals {
            let finished = rival.ends();
            assert_eq!(finished.code, Some(1), "{}", finished.err);
            assert!(finished.err.contains("another daemon is listening at"), "{}", finished.err);
        }
        winner.until_log("listening at ");
        let daemon = Daemon { running: winner, address: format!("unix:{}", socket.display()), folder };
        ProducerAndConsumer::new(&daemon, "cam").step();
        daemon.stop();
    }
}

/// As a daemon does that is killed.
fn leave_a_socket_behind(socket: &std::path::Path) {
    let mut killed = serve_at(socket).start();
    killed.until_log("listening at ");
    killed.signal(Signal::KILL);
    killed.ends();
    assert!(socket.exists());
}
