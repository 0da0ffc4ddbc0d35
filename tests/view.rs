//! The page's HTTP server from outside: a real process, real connections, every byte of a request sent by the test.

#[path = "view/answers.rs"]
mod answers;
mod common;
#[path = "view/demo.rs"]
mod demo;
#[path = "view/event_client.rs"]
mod event_client;
#[path = "view/events.rs"]
mod events;
#[path = "view/hostile.rs"]
mod hostile;
#[path = "view/origins.rs"]
mod origins;
#[path = "view/page.rs"]
mod page;
#[path = "view/proxy.rs"]
mod proxy;
#[path = "view/shutdown.rs"]
mod shutdown;
#[path = "view/websocket.rs"]
mod websocket;
