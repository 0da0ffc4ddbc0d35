//! The controls: stream, view, pause and steps, by pointer or by keys.
//!
//! In: the page's elements, the session.
//! Out: choices, which go to the session and into the address, so that a reload keeps them.
//! Invariants: every control is a plain form element with a label. Keys that an element handles itself are left to it.
//! Must not know: bytes of messages, drawing.

import { formatNumber } from "./numbers.js";
import { shortSpaceName } from "./spaces.js";

/** The end of the slider's range. The scale grows with the square of its value, so small scales have more room. */
const SLIDER = 1000;
const MAX_RANK = 1000;

const el = (id) => document.getElementById(id);

/** The choice in the hash of an address. */
export function choiceFrom(hash) {
  const parameters = new URLSearchParams(hash.replace(/^#/, ""));
  const rank = (name) => Math.min(MAX_RANK, Math.max(1, Math.trunc(Number(parameters.get(name))) || 1));
  const alpha = Number(parameters.get("alpha"));
  const cuts = {
    full: "Full",
    reduced: { Reduced: alpha > 0 && Number.isFinite(alpha) ? alpha : 1 },
    derived: { Derived: [rank("k"), rank("l")] },
  };
  const cut = cuts[parameters.get("view")] ?? cuts.derived;
  const simplify = parameters.get("simplify") === "yes" && cut !== "Full" ? "AtScale" : "No";
  return { stream: parameters.get("stream"), view: { cut, simplify } };
}

/** The hash of an address for a choice. */
export function hashOf({ stream, view: { cut, simplify } }) {
  const parameters = new URLSearchParams();
  if (stream !== null) parameters.set("stream", stream);
  parameters.set("view", kindOf(cut));
  if (cut.Derived) ["k", "l"].forEach((name, i) => parameters.set(name, cut.Derived[i]));
  if (cut.Reduced !== undefined) parameters.set("alpha", cut.Reduced);
  if (simplify !== "No") parameters.set("simplify", "yes");
  return `#${parameters}`;
}

const kindOf = (cut) => (cut === "Full" ? "full" : cut.Derived ? "derived" : "reduced");

/** A stream in the list: its name, and its space if that is not the plane. */
const labelOf = (name, space) => (space ? `${name} (${shortSpaceName(space)})` : name);

export class Controls {
  /**
   * @param {import("../session/session.js").Session} session
   * @param {{fit: () => void, pickNext: (by: number) => void, unpick: () => void}} actions of the page
   */
  constructor(session, actions) {
    this.session = session;
    this.actions = actions;
    const { cut, simplify } = session.choice.view;
    this.ranks = cut.Derived ?? [1, 1];
    this.alpha = cut.Reduced ?? null;
    this.largest = 1;
    el(`view-${kindOf(cut)}`).checked = true;
    el("simplify").checked = simplify !== "No";
    this.listen();
    this.show();
  }

  listen() {
    el("stream").addEventListener("change", () => this.session.chooseStream(el("stream").value));
    for (const kind of ["full", "reduced", "derived"])
      el(`view-${kind}`).addEventListener("change", () => this.applyView());
    el("simplify").addEventListener("change", () => this.applyView());
    ["k", "l"].forEach((name, i) => {
      el(`${name}-less`).addEventListener("click", () => this.changeRank(i, -1));
      el(`${name}-more`).addEventListener("click", () => this.changeRank(i, 1));
    });
    el("alpha").addEventListener("input", () => {
      this.alpha = Math.max(Number.MIN_VALUE, this.largest * (el("alpha").value / SLIDER) ** 2);
      this.applyView();
    });
    el("pause").addEventListener("click", () => this.session.setPaused(!this.session.paused));
    el("back").addEventListener("click", () => this.step(-1));
    el("forward").addEventListener("click", () => this.step(1));
    el("help-open").addEventListener("click", () => this.openHelp());
    el("fit").addEventListener("click", () => this.actions.fit());
    addEventListener("keydown", (event) => this.key(event));
  }

  /** The chosen kind of view. */
  get kind() {
    return ["full", "reduced", "derived"].find((kind) => el(`view-${kind}`).checked);
  }

  /** Changes the rank k (0) or l (1). */
  changeRank(which, by) {
    el("view-derived").checked = true;
    this.ranks = this.ranks.map((rank, i) => (i === which ? Math.min(MAX_RANK, Math.max(1, rank + by)) : rank));
    this.applyView();
  }

  /** Lets the session follow the chosen view. */
  applyView() {
    this.alpha ??= this.largest / 4;
    const cut = { full: "Full", reduced: { Reduced: this.alpha }, derived: { Derived: this.ranks } }[this.kind];
    const simplify = el("simplify").checked && cut !== "Full" ? "AtScale" : "No";
    this.session.chooseView({ cut, simplify });
    this.show();
  }

  /** Pauses, and shows the frame that is `by` frames later. */
  step(by) {
    this.session.setPaused(true);
    this.session.step(by);
    this.show();
  }

  /** Sets the scale at the slider's end: the largest one of the diagram. */
  setLargest(largest) {
    if (largest === this.largest) return;
    this.largest = largest;
    this.show();
  }

  /** Shows the chosen values. */
  show() {
    const { kind } = this;
    el("derived-set").hidden = kind !== "derived";
    el("reduced-set").hidden = kind !== "reduced";
    el("simplify").disabled = kind === "full";
    el("k").textContent = this.ranks[0];
    el("l").textContent = this.ranks[1];
    const alpha = this.alpha ?? this.largest / 4;
    if (document.activeElement !== el("alpha"))
      el("alpha").value = SLIDER * Math.sqrt(Math.min(1, alpha / this.largest));
    el("alpha-value").textContent = formatNumber(alpha);
    const { paused, history } = this.session;
    el("pause").setAttribute("aria-pressed", paused);
    el("pause-word").textContent = paused ? "Go on" : "Pause";
    el("back").disabled = history.before === 0;
    el("forward").disabled = !paused || history.after === 0;
    const hash = hashOf(this.session.choice);
    if (location.hash !== hash) window.history.replaceState(null, "", hash);
  }

  /** Lists the streams to choose from. */
  showStreams() {
    const { streams, spaces, choice } = this.session;
    const options = streams.map(({ name, stream }) => ({ name, label: labelOf(name, spaces.get(stream)) }));
    if (choice.stream !== null && !options.some(({ name }) => name === choice.stream)) {
      options.push({ name: choice.stream, label: choice.stream });
    }
    const listed = options.map(({ label }) => label).join("\n");
    const select = el("stream");
    if (listed !== this.listed) {
      this.listed = listed;
      select.replaceChildren(...options.map(({ name, label }) => new Option(label, name)));
      select.disabled = options.length === 0;
    }
    select.value = choice.stream ?? "";
    this.show();
  }

  openHelp() {
    if (!el("help").open) el("help").showModal();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || el("help").open) return;
    const { tagName } = event.target;
    if (tagName === "SELECT" || (tagName === "BUTTON" && [" ", "Enter"].includes(event.key))) return;
    const actions = {
      " ": () => this.session.setPaused(!this.session.paused),
      ",": () => this.step(-1),
      ".": () => this.step(1),
      k: () => this.changeRank(0, 1),
      K: () => this.changeRank(0, -1),
      l: () => this.changeRank(1, 1),
      L: () => this.changeRank(1, -1),
      1: () => this.chooseKind("derived"),
      2: () => this.chooseKind("reduced"),
      3: () => this.chooseKind("full"),
      s: () => el("simplify").click(),
      f: () => this.actions.fit(),
      "]": () => this.actions.pickNext(1),
      "[": () => this.actions.pickNext(-1),
      Escape: () => this.actions.unpick(),
      "?": () => this.openHelp(),
    };
    if (!actions[event.key]) return;
    actions[event.key]();
    event.preventDefault();
  }

  /** Chooses a kind of view. */
  chooseKind(kind) {
    el(`view-${kind}`).checked = true;
    this.applyView();
  }
}
