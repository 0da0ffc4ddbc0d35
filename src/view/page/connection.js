//! The way to the daemon: a WebSocket that carries the protocol's bytes, and comes back by itself.
//!
//! In: messages to send. Out: messages that came, and how things stand. Invariants: after a loss it tries again, at
//! growing pauses of at most 5 s, for ever; every timer of a connection ends with it; messages of channels that
//! nobody listens to are not even read. Must not know: streams, views, the page.

import { BodyError } from "./bytes.js";
import { BANNER, FrameError, Inbox, readBanner, writeBanner } from "./frames.js";
import { VERSIONS, agree, readMessage, typeOf, writeMessage } from "./protocol.js";

const SHORTEST_PAUSE = 250;
const LONGEST_PAUSE = 5000;
/** How often the daemon is asked whether it is there, and so how far behind we are. */
const PING_EVERY = 500;
/** Who says nothing at all for so long, although asked, is gone. */
const PATIENCE = 15_000;
/** A connection that lasted so long was a good one: the next loss is tried anew at once. */
const GOOD = 3000;

/**
 * @typedef {{up: () => void, message: (channel: number, name: string, body: any) => void, state: () => void,
 *   listens: (channel: number) => boolean}} Listener
 */

export class Connection {
  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    /** @type {"connecting" | "connected" | "gone"} */
    this.state = "connecting";
    /** What the daemon said before it went. */
    this.reason = "";
    /** Why the connection was lost. */
    this.loss = "";
    this.pause = SHORTEST_PAUSE;
    this.version = VERSIONS.lowest;
    /** What the daemon said of itself. */
    this.welcome = null;
    this.roundTrip = 0;
    /** When the question was asked that is not answered yet, or null. */
    this.asked = null;
    this.token = 0;
  }

  /** How far behind the daemon we are, in milliseconds: how long an answer takes through all that is sent before it. */
  get lag() {
    const waiting = this.asked === null ? 0 : performance.now() - this.asked;
    return Math.max(this.roundTrip, waiting);
  }

  /** Connects, now. */
  start() {
    clearTimeout(this.retry);
    this.opened = performance.now();
    this.heard = this.opened;
    this.phase = "banner";
    this.inbox = new Inbox();
    this.welcome = null;
    this.asked = null;
    const socket = new WebSocket(this.url, "hopes");
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(writeBanner(VERSIONS.lowest, VERSIONS.highest));
    socket.onmessage = ({ data }) => this.take(socket, data);
    socket.onclose = () => this.lose(socket, this.reason || "The daemon does not answer.");
    this.socket = socket;
  }

  /** Tells the daemon something. */
  send(channel, name, body) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(writeMessage(this.version, channel, name, body));
  }

  /** Takes bytes, and deals with all that is whole. */
  take(socket, data) {
    if (socket !== this.socket) return;
    this.heard = performance.now();
    try {
      if (!(data instanceof ArrayBuffer)) throw new FrameError("malformed", "the daemon sent text");
      this.inbox.push(new Uint8Array(data));
      if (this.phase === "banner" && !this.greet()) return;
      for (let frame; (frame = this.inbox.next((version) => this.speaks(version)));) this.deal(frame);
    } catch (error) {
      if (!(error instanceof FrameError || error instanceof BodyError)) throw error;
      this.lose(socket, `What the daemon sent cannot be read: ${error.message}.`);
    }
  }

  /** Until it has said welcome, the daemon may speak version 1. */
  speaks(version) {
    return version === this.version || (this.phase === "welcome" && version === 1);
  }

  /** Reads the banner, and says hello. False if there is more to come. */
  greet() {
    if (this.inbox.rest.length < BANNER) return false;
    const banner = readBanner(this.inbox.rest);
    this.inbox.skip(BANNER);
    const version = agree(banner);
    if (version === null) {
      const speaks = `${banner.lowest} to ${banner.highest}`;
      throw new FrameError(
        "unsupported version",
        `it speaks versions ${speaks}, the page ${VERSIONS.lowest} to ${VERSIONS.highest}`,
      );
    }
    this.version = version;
    this.phase = "welcome";
    this.send(0, "Hello", { software: "hopes page", capabilities: [] });
    return true;
  }

  deal({ type, channel, body }) {
    if (channel !== 0 && !this.listener.listens(channel)) return;
    const isKnown = channel === 0 || this.phase === "up" || type === typeOf("Error");
    if (!isKnown) throw new FrameError("malformed", "a message came before the welcome");
    const message = readMessage(this.version, type, body);
    if (channel === 0) this.answer(message.name, message.body);
    else this.listener.message(channel, message.name, message.body);
  }

  /** Deals with a message of the connection itself. */
  answer(name, body) {
    if (name === "Welcome") this.comeUp(body);
    else if (name === "Ping") this.send(0, "Pong", body);
    else if (name === "Pong") this.hearPong(body);
    else if (name === "Goodbye") this.reason = `The daemon has ended: ${body.reason || "goodbye"}.`;
    else if (name === "Error") this.reason = `The daemon refuses: ${body.text}.`;
  }

  comeUp(welcome) {
    this.welcome = welcome;
    this.phase = "up";
    this.state = "connected";
    this.reason = "";
    this.timer = setInterval(() => this.tick(), PING_EVERY);
    this.listener.state();
    this.listener.up();
  }

  hearPong({ token }) {
    if (token !== this.token || this.asked === null) return;
    this.roundTrip = performance.now() - this.asked;
    this.asked = null;
  }

  /** Asks the daemon whether it is there. A hidden page only answers, since its timers are held up. */
  tick() {
    if (document.hidden) {
      this.asked = null;
      this.heard = performance.now();
      return;
    }
    if (performance.now() - this.heard > PATIENCE) return this.lose(this.socket, "The daemon says nothing any more.");
    if (this.asked !== null) return;
    this.token += 1;
    this.asked = performance.now();
    this.send(0, "Ping", { token: this.token });
  }

  /** The connection is lost: says why, and tries again. */
  lose(socket, reason) {
    if (socket !== this.socket) return;
    this.socket = null;
    socket.close();
    clearInterval(this.timer);
    const lasted = this.welcome ? performance.now() - this.opened : 0;
    this.pause = lasted > GOOD ? SHORTEST_PAUSE : Math.min(2 * this.pause, LONGEST_PAUSE);
    this.reason = "";
    this.loss = reason;
    this.state = "gone";
    this.retry = setTimeout(() => this.start(), this.pause);
    this.listener.state();
  }
}
