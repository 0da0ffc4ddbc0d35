//! The page's texts: the state of the connection, counts, and the data of the picked cycle.
//!
//! In: the session, the picked cycle, rates.
//! Out: texts.
//! Invariants: texts are set and never parsed as HTML. An unchanged text is not set again, so that screen readers do
//! not repeat it.
//! Must not know: drawing.

import { colorOf } from "../drawing/colors.js";
import { formatCount, formatNumber } from "./numbers.js";

const el = (id) => document.getElementById(id);

function setText(id, text) {
  const element = el(id);
  if (element.textContent !== text) element.textContent = text;
}

/** A rate: events of the last second. */
export class Rate {
  constructor() {
    this.count = 0;
    this.since = performance.now();
    this.rate = 0;
  }

  add() {
    this.count += 1;
  }

  /** Events in a second; updated each second. */
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

/**
 * Shows the state of the session, and how many frames in a second are followed and drawn.
 * @param {import("../session/session.js").Session} session
 */
export function showStatus(session, followed, drawn) {
  const { connection, mirror, annotations, history, paused } = session;
  const { frame } = mirror;
  document.body.dataset.state = connection.state;
  setText("state", { connecting: "connecting", connected: paused ? "paused" : "live", gone: "gone" }[connection.state]);
  const rate = drawn < 0.7 * followed ? `${followed.toFixed(0)} (${drawn.toFixed(0)} drawn)` : followed.toFixed(0);
  setText("fps", paused ? "–" : rate);
  setText("lag", connection.state === "connected" ? `${Math.round(connection.lag)} ms` : "–");
  setText("frame", frame ? formatCount(frame.number) : "–");
  setText("points", frame ? formatCount(frame.points) : "–");
  setText("edges", formatCount(mirror.edges.count));
  setText("cycles", frame ? formatCount(frame.cycles) : "–");
  setText("tracks", session.noTracksReason ? "–" : formatCount(annotations.alive.length));
  setText("steps", paused ? `${formatCount(history.before)} frames back, ${formatCount(history.after)} on` : "");
  setText("gaps", frame?.view.cut.Derived ? gapsText(frame) : "");
  const { total, labels } = annotations.dots;
  const known = labels.length / 2;
  setText("dots", total > known ? `${formatCount(known)} of ${formatCount(total)} dots` : `${formatCount(total)} dots`);
  setText("lives-note", session.noTracksReason ? `No tracks: ${session.noTracksReason}` : "");
  showMessage(session);
}

/** The sides of the selected gaps; `vs` is infinite if no vertical gap is selected. */
const gapsText = ({ ds, vs }) => `ds ${formatNumber(ds)} · vs ${vs === null ? "∞" : formatNumber(vs)}`;

/** Shows the most important message, if there is one. */
function showMessage({ connection, choice, streams, mirror, notice }) {
  let text = notice;
  if (connection.state === "gone") text = `${connection.loss} Trying again …`;
  else if (connection.state === "connecting") text = "Connecting to the daemon …";
  else if (choice.stream === null)
    text = "The daemon has no streams yet. One appears here as soon as a producer opens it.";
  else if (!mirror.frame && !notice) {
    const isThere = streams.some((stream) => stream.name === choice.stream);
    text = isThere ? "Waiting for the first frame …" : `There is no stream “${choice.stream}” yet.`;
  }
  setText("message", text);
  el("message").hidden = text === "";
}

/** Shows the data of the picked cycle. @param {import("../drawing/picking.js").Pick | null} pick */
export function showCycle(pick, byId) {
  const box = el("cycle");
  box.hidden = pick === null;
  if (!pick) return;
  const track = pick.track === null ? null : byId.get(pick.track);
  const { birth, death } = track ?? pick;
  setText("cycle-id", pick.track === null ? "no track" : `track ${pick.track}`);
  el("cycle-color").setAttribute("fill", pick.track === null ? "currentColor" : colorOf(pick.track).css);
  setText("cycle-birth", formatNumber(Number.isNaN(birth) ? null : birth));
  setText("cycle-death", formatNumber(Number.isNaN(death) ? null : death));
  setText("cycle-persistence", formatNumber(Number.isNaN(death) ? null : death - birth));
  setText("cycle-age", track ? `${formatCount(track.age)} frames` : pick.track === null ? "–" : "ended");
}
