//! What the page says in words: how the connection stands, counts, and what is known of one cycle.
//!
//! In: the session, what is meant, rates. Out: texts. Invariants: texts are set, never parsed as HTML; a text that
//! stays the same is not touched, so that nobody is read the same thing twice. Must not know: drawing.

import { short, whole } from "./canvas.js";
import { colorOf } from "./colors.js";

const el = (id) => document.getElementById(id);

function say(id, text) {
  const element = el(id);
  if (element.textContent !== text) element.textContent = text;
}

/** Counts what happens in the last second. */
export class Rate {
  constructor() {
    this.count = 0;
    this.since = performance.now();
    this.rate = 0;
  }

  add() {
    this.count += 1;
  }

  /** How many a second; measured anew each second. */
  get value() {
    const passed = performance.now() - this.since;
    if (passed >= 1000) {
      this.rate = (1000 * this.count) / passed;
      this.count = 0;
      this.since += passed;
    }
    return this.rate;
  }
}

/** Says how things stand. @param {import("./session.js").Session} session */
export function showStatus(session, followed, drawn) {
  const { connection, mirror, beside, history, paused } = session;
  const { frame } = mirror;
  document.body.dataset.state = connection.state;
  say("state", { connecting: "connecting", connected: paused ? "paused" : "live", gone: "gone" }[connection.state]);
  const rate = drawn < 0.7 * followed ? `${followed.toFixed(0)} (${drawn.toFixed(0)} drawn)` : followed.toFixed(0);
  say("fps", paused ? "–" : rate);
  say("lag", connection.state === "connected" ? `${Math.round(connection.lag)} ms` : "–");
  say("frame", frame ? whole(frame.number) : "–");
  say("points", frame ? whole(frame.points) : "–");
  say("edges", whole(mirror.edges.count));
  say("cycles", frame ? whole(frame.cycles) : "–");
  say("tracks", session.trackless ? "–" : whole(beside.alive.length));
  say("steps", paused ? `${whole(history.before)} frames back, ${whole(history.after)} on` : "");
  say("gaps", frame?.view.cut.Derived ? `ds ${short(frame.ds)} · vs ${frame.vs === null ? "∞" : short(frame.vs)}` : "");
  const { total, labels } = beside.dots;
  const known = labels.length / 2;
  say("dots", total > known ? `${whole(known)} of ${whole(total)} dots` : `${whole(total)} dots`);
  say("lives-note", session.trackless ? `No tracks: ${session.trackless}` : "");
  showMessage(session);
}

/** The one thing that the user should know now, if there is any. */
function showMessage({ connection, choice, streams, mirror, notice }) {
  let text = notice;
  if (connection.state === "gone") text = `${connection.loss} Trying again …`;
  else if (connection.state === "connecting") text = "Connecting to the daemon …";
  else if (choice.stream === null)
    text = "The daemon has no streams yet. One appears here as soon as somebody feeds it.";
  else if (!mirror.frame && !notice) {
    const isThere = streams.some((stream) => stream.name === choice.stream);
    text = isThere ? "Waiting for the first frame …" : `There is no stream “${choice.stream}” yet.`;
  }
  say("message", text);
  el("message").hidden = text === "";
}

/** Says what is known of the cycle that is meant. @param {import("./cycles.js").Hit | null} hit */
export function showCycle(hit, byId) {
  const box = el("cycle");
  box.hidden = hit === null;
  if (!hit) return;
  const track = hit.track === null ? null : byId.get(hit.track);
  const { birth, death } = track ?? hit;
  say("cycle-id", hit.track === null ? "no track" : `track ${hit.track}`);
  el("cycle-color").setAttribute("fill", hit.track === null ? "currentColor" : colorOf(hit.track).css);
  say("cycle-birth", short(Number.isNaN(birth) ? null : birth));
  say("cycle-death", short(Number.isNaN(death) ? null : death));
  say("cycle-persistence", short(Number.isNaN(death) ? null : death - birth));
  say("cycle-age", track ? `${whole(track.age)} frames` : hit.track === null ? "–" : "ended");
}
