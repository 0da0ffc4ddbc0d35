//! The live page as browsers, scrapers and attackers see it: a real process, real connections, and requests whose every
//! byte is written by the test.

#[path = "view/answers.rs"]
mod answers;
mod common;
#[path = "view/demo.rs"]
mod demo;
#[path = "view/ending.rs"]
mod ending;
#[path = "view/hostile.rs"]
mod hostile;
#[path = "view/page.rs"]
mod page;
#[path = "view/strangers.rs"]
mod strangers;
#[path = "view/websocket.rs"]
mod websocket;
