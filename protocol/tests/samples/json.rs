//! Messages as JSON: `{"type": …, "number": …, "channel": …, "body": {…}}`.
//!
//! In: a channel and a message, or JSON. Out: the other. Invariants: fields have the order of the wire. Must not know:
//! files, bytes.

use hopes_protocol::*;
use serde::{Deserialize, Serialize};

/// The content of the JSON file of a vector.
#[derive(Serialize, Deserialize)]
pub struct Entry<T> {
    #[serde(rename = "type")]
    pub name: String,
    pub number: u16,
    pub channel: u32,
    pub body: T,
}

/// The content of the JSON file of a banner.
#[derive(Serialize, Deserialize)]
pub struct BannerEntry {
    #[serde(rename = "type")]
    pub name: String,
    pub lowest: u16,
    pub highest: u16,
}

/// Indented JSON with a line end.
pub fn pretty(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("it has no map whose keys are not text") + "\n"
}

macro_rules! bodies {
    ($($name:ident($body:ty),)*) => {
        pub fn of(channel: u32, message: &Message) -> String {
            let number = message.kind();
            match message {
                $(Message::$name(body) => pretty(&Entry { name: stringify!($name).into(), number, channel, body }),)*
            }
        }

        pub fn read(text: &str) -> (u32, Message) {
            let head: Entry<serde_json::Value> = serde_json::from_str(text).expect("it has type, number, channel and body");
            match head.name.as_str() {
                $(stringify!($name) => typed::<$body>(text),)*
                name => panic!("no message is called {name}"),
            }
        }
    };
}

bodies! {
    Hello(Hello),
    Welcome(Welcome),
    Ping(Ping),
    Pong(Pong),
    Goodbye(Goodbye),
    Error(Report),
    ListStreams(ListStreams),
    Streams(Streams),
    GetStatus(StatusWanted),
    Status(Status),
    ListSpaces(ListSpaces),
    Spaces(Spaces),
    Open(Open),
    Opened(Opened),
    Batch(Batch),
    Retract(Retract),
    Commit(Commit),
    Close(Close),
    Closed(Closed),
    Accepted(Accepted),
    Refused(Refused),
    Committed(Committed),
    Overloaded(Overloaded),
    OpenSpace(OpenSpace),
    SpaceOpened(SpaceOpened),
    SpaceBatch(SpaceBatch),
    SpaceRetract(SpaceRetract),
    Subscribe(Subscribe),
    ChangeView(ChangeView),
    Unsubscribe(Unsubscribe),
    StreamOpened(StreamOpened),
    StreamClosed(StreamClosed),
    Snapshot(Snapshot),
    Diff(Diff),
    Dots(Dots),
    Heartbeat(Heartbeat),
    Lagged(Lagged),
    Resumed(Resumed),
    Unsubscribed(Unsubscribed),
    WantTracks(WantTracks),
    Tracks(Tracks),
    SpaceSnapshot(SpaceSnapshot),
    SpaceDiff(SpaceDiff),
    SpaceDots(SpaceDots),
    SpaceTracks(SpaceTracks),
    ListPeers(ListPeers),
    Peers(Peers),
    StopStream(StopStream),
    StreamStopped(StreamStopped),
    Disconnect(Disconnect),
    Disconnected(Disconnected),
    GetMemory(GetMemory),
    Memory(Memory),
    Elapsed(Elapsed),
}

fn typed<T: serde::de::DeserializeOwned + Into<Message>>(text: &str) -> (u32, Message) {
    let entry: Entry<T> = serde_json::from_str(text).expect("its body is that of its type");
    let message = entry.body.into();
    assert_eq!(entry.number, message.kind(), "number and type must fit");
    (entry.channel, message)
}
