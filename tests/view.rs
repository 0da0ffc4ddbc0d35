//! The live page as browsers, scrapers and strangers meet it: a real process, real connections, every byte of a
//! request said by the test.

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
