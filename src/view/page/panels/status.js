//! The page's texts: the state of the connection, counts, and the data of the picked cycle.
//!
//! In: the session, the picked cycle, rates.
//! Out: texts.
//! Invariants: texts are set and never parsed as HTML. An unchanged text is not set again, so that screen readers do
//! not repeat it.
//! Must not know: drawing.

import { colorOf } from "../drawing/colors.js";
import { formatCount, formatNumber } from "./numbers.js";
import { spaceName } from "./spaces.js";

/** Milliseconds after which points without a frame are a sign that nobody closes frames. */
const COMMIT_PATIENCE = 2000;

const NOT_FOLLOWED =
  "This daemon follows no holes over time. To follow them, start it with a rule: `--track view` follows the cycles " +
  "of the view, `--track top:20` the most persistent ones, `--track above:5` those above a persistence.";
const NO_TRACK_YET =
  "No track yet. A hole becomes a track when it has been there for some frames: 2, unless `--track-confirm` says " +
  "otherwise.";

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
  el("legend-simplified").hidden = annotations.simplified === null;
  setText("space", frame ? spaceName(mirror) : "");
  setText("words", frame ? wordsFor(frame, session.noTracksReason ? null : annotations.alive.length) : "–");
  document.body.dataset.space = frame && mirror.metric !== null ? "any" : "plane";
  setText("steps", paused ? `${formatCount(history.before)} frames back, ${formatCount(history.after)} on` : "");
  const gaps = frame?.view.cut.Derived ? frame : null;
  setText("ds", gaps ? `ds ${formatNumber(gaps.ds)}` : "");
  setText("vs", gaps ? `vs ${gaps.vs === null ? "∞" : formatNumber(gaps.vs)}` : "");
  const { total, labels } = annotations.dots;
  const known = labels.length / 2;
  setText("dots", total > known ? `${formatCount(known)} of ${formatCount(total)} dots` : `${formatCount(total)} dots`);
  showLives(session);
  showMessage(session);
}

const counted = (count, one, many) => `${formatCount(count)} ${count === 1 ? one : many}`;

/** How many cycles and tracks there are, in words; `tracks` is null if none are followed. */
export function wordsFor({ cycles }, tracks) {
  const shown = `${counted(cycles, "cycle", "cycles")} in the view`;
  return tracks === null ? `${shown}, no tracks` : `${shown}, ${counted(tracks, "track", "tracks")}`;
}

/** Says why there are no lives, and what to do. */
function showLives({ noTracksReason, tracks, mirror }) {
  const isBlank = mirror.frame !== null && tracks.lifetimes.byId.size === 0;
  el("lives-blank").hidden = !isBlank;
  el("lives-legend").hidden = isBlank || mirror.frame === null;
  if (isBlank) setMarkedText("lives-blank", noTracksReason ? NOT_FOLLOWED : NO_TRACK_YET);
}

/** Sets a text in which what stands between two backquotes is code. */
function setMarkedText(id, text) {
  const element = el(id);
  if (element.textContent === text.replaceAll("`", "")) return;
  const parts = text.split("`").map((part, i) => {
    const code = document.createElement("code");
    code.textContent = part;
    return i % 2 ? code : part;
  });
  element.replaceChildren(...parts);
}

/** Shows the most important message, if there is one. */
function showMessage({ connection, choice, streams, mirror, notice, chosenAt }) {
  let text = notice;
  if (connection.state === "gone") text = `${connection.loss} Trying again …`;
  else if (connection.state === "connecting") text = "Connecting to the daemon …";
  else if (choice.stream === null)
    text = "The daemon has no streams yet. One appears here as soon as a producer opens it.";
  else if (!mirror.frame && !notice) {
    const stream = streams.find(({ name }) => name === choice.stream);
    text = stream ? waitingFor(stream, performance.now() - chosenAt) : `There is no stream “${choice.stream}” yet.`;
  }
  setMarkedText("message", text);
  el("message").hidden = text === "";
}

/** What a stream without frames waits for, after so many milliseconds. */
export function waitingFor({ frame, points: committed, vertices }, waited) {
  // Points that a producer has not committed count as vertices only.
  const points = Math.max(committed, vertices);
  if (frame > 0 || points === 0 || waited < COMMIT_PATIENCE) return "Waiting for the first frame …";
  return (
    `${counted(points, "point waits", "points wait")} for a commit: a frame is computed when it is closed. Close it ` +
    'by a blank line in text, by `{"commit":true}` in JSON lines, by `commit()` in a client, or let the daemon do it: ' +
    "`--frame-points 1000` after so many points, `--frame-every 100ms` after so long."
  );
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
