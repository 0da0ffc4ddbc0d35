//! Attacks on a daemon: peers that flood it, read nothing, or end in the midst of things. With each of them there,
//! another stream's frames come as before, memory stays within its limit, and a signal ends the daemon within seconds.

#[path = "attacks/ends.rs"]
mod ends;
#[path = "attacks/flood.rs"]
mod flood;
#[path = "attacks/mute.rs"]
mod mute;
#[path = "attacks/rivals.rs"]
mod rivals;
#[path = "attacks/scene.rs"]
mod scene;
#[path = "attacks/stuck.rs"]
mod stuck;
#[path = "attacks/torn.rs"]
mod torn;
#[path = "attacks/visitors.rs"]
mod visitors;

mod common;
