//! The connection to the daemon: a WebSocket that carries the protocol's bytes and reconnects by itself.
//!
//! In: messages to send.
//! Out: received messages; the state of the connection.
//! Invariants: after a loss it reconnects for ever, after growing pauses of at most 5 s. Every timer of a connection
//! ends with it. Messages of channels without a subscription are not decoded.
//! Must not know: streams, views, the page.

import { BodyError } from "./bytes.js";
import { BANNER, FrameError, ReceiveBuffer, readBanner, writeBanner } from "./frames.js";
import { VERSIONS, agree, readMessage, typeOf, writeMessage } from "./protocol.js";

/** Milliseconds before the first attempt to reconnect, and before any attempt at the most. */
const MIN_PAUSE = 250;
const MAX_PAUSE = 5000;
/** Milliseconds between pings. Their round trip also measures the lag. */
const PING_INTERVAL = 500;
/** A daemon that sends nothing for so many milliseconds, although it is pinged, is lost. */
const TIMEOUT = 15_000;
/** A connection that lasted so many milliseconds was stable: after it the shortest pause applies again. */
const STABLE = 3000;

/**
 * @typedef {{connected: () => void, message: (channel: number, name: string, body: any) => void,
 *   stateChanged: () => void, isSubscribed: (channel: number) => boolean}} Listener
 */

export class Connection {
  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    /** @type {"connecting" | "connected" | "gone"} */
    this.state = "connecting";
    /** Why the daemon says that it closes the connection. */
    this.reason = "";
    /** Why the last connection was lost. */
    this.loss = "";
    this.pause = MIN_PAUSE;
    this.version = VERSIONS.lowest;
    /** The daemon's `Welcome`. */
    this.welcome = null;
    this.roundTrip = 0;
    /** When the ping was sent that is not answered yet, or null. */
    this.pingedAt = null;
    this.token = 0;
  }

  /** How far the page is behind the daemon, in milliseconds: the round trip of a ping through all that is queued. */
  get lag() {
    const waiting = this.pingedAt === null ? 0 : performance.now() - this.pingedAt;
    return Math.max(this.roundTrip, waiting);
  }

  connect() {
    clearTimeout(this.retry);
    this.openedAt = performance.now();
    this.receivedAt = this.openedAt;
    /** What is expected next. @type {"banner" | "welcome" | "messages"} */
    this.phase = "banner";
    this.received = new ReceiveBuffer();
    this.welcome = null;
    this.pingedAt = null;
    const socket = new WebSocket(this.url, "hopes");
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(writeBanner(VERSIONS.lowest, VERSIONS.highest));
    socket.onmessage = ({ data }) => this.receive(socket, data);
    socket.onclose = () => this.disconnect(socket, this.reason || "The daemon does not answer.");
    this.socket = socket;
  }

  send(channel, name, body) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(writeMessage(this.version, channel, name, body));
  }

  /** Takes bytes, and handles every frame that is complete. */
  receive(socket, data) {
    if (socket !== this.socket) return;
    this.receivedAt = performance.now();
    try {
      if (!(data instanceof ArrayBuffer)) throw new FrameError("malformed", "the daemon sent text");
      this.received.push(new Uint8Array(data));
      if (this.phase === "banner" && !this.handleBanner()) return;
      for (let frame; (frame = this.received.next((version) => this.acceptsVersion(version)));) this.handleFrame(frame);
    } catch (error) {
      if (!(error instanceof FrameError || error instanceof BodyError)) throw error;
      this.disconnect(socket, `What the daemon sent cannot be read: ${error.message}.`);
    }
  }

  /** Before its `Welcome` the daemon may send frames of version 1. */
  acceptsVersion(version) {
    return version === this.version || (this.phase === "welcome" && version === 1);
  }

  /** Reads the daemon's banner and sends `Hello`. False if bytes of the banner are missing. */
  handleBanner() {
    if (this.received.rest.length < BANNER) return false;
    const banner = readBanner(this.received.rest);
    this.received.skip(BANNER);
    const version = agree(banner);
    if (version === null) {
      const theirs = `${banner.lowest} to ${banner.highest}`;
      throw new FrameError(
        "unsupported version",
        `it speaks versions ${theirs}, the page ${VERSIONS.lowest} to ${VERSIONS.highest}`,
      );
    }
    this.version = version;
    this.phase = "welcome";
    this.send(0, "Hello", { software: "hopes page", capabilities: [] });
    return true;
  }

  handleFrame({ type, channel, body }) {
    if (channel !== 0 && !this.listener.isSubscribed(channel)) return;
    const isExpected = channel === 0 || this.phase === "messages" || type === typeOf("Error");
    if (!isExpected) throw new FrameError("malformed", "a message came before the welcome");
    const message = readMessage(this.version, type, body);
    if (channel === 0) this.handleOwnMessage(message.name, message.body);
    else this.listener.message(channel, message.name, message.body);
  }

  /** Handles a message of channel 0, which belongs to the connection itself. */
  handleOwnMessage(name, body) {
    if (name === "Welcome") this.handleWelcome(body);
    else if (name === "Ping") this.send(0, "Pong", body);
    else if (name === "Pong") this.handlePong(body);
    else if (name === "Goodbye") this.reason = `The daemon has ended: ${body.reason || "goodbye"}.`;
    else if (name === "Error") this.reason = `The daemon refuses: ${body.text}.`;
  }

  handleWelcome(welcome) {
    this.welcome = welcome;
    this.phase = "messages";
    this.state = "connected";
    this.reason = "";
    this.timer = setInterval(() => this.tick(), PING_INTERVAL);
    this.listener.stateChanged();
    this.listener.connected();
  }

  handlePong({ token }) {
    if (token !== this.token || this.pingedAt === null) return;
    this.roundTrip = performance.now() - this.pingedAt;
    this.pingedAt = null;
  }

  /** Pings the daemon. A hidden page sends no pings, since browsers delay its timers. */
  tick() {
    if (document.hidden) {
      this.pingedAt = null;
      this.receivedAt = performance.now();
      return;
    }
    if (performance.now() - this.receivedAt > TIMEOUT) {
      return this.disconnect(this.socket, "The daemon has sent nothing for too long.");
    }
    if (this.pingedAt !== null) return;
    this.token += 1;
    this.pingedAt = performance.now();
    this.send(0, "Ping", { token: this.token });
  }

  /** Closes the connection, says why, and schedules the next attempt. */
  disconnect(socket, reason) {
    if (socket !== this.socket) return;
    this.socket = null;
    socket.close();
    clearInterval(this.timer);
    const lasted = this.welcome ? performance.now() - this.openedAt : 0;
    this.pause = lasted > STABLE ? MIN_PAUSE : Math.min(2 * this.pause, MAX_PAUSE);
    this.reason = "";
    this.loss = reason;
    this.state = "gone";
    this.retry = setTimeout(() => this.connect(), this.pause);
    this.listener.stateChanged();
  }
}
