//! What one sets: stream, view, pause and steps; by pointer, finger or keys.
//!
//! In: the page's elements, the session. Out: choices, for the session and in the address, so that a reload keeps
//! them. Invariants: every control is a plain form element with a label; keys never take what an element needs for
//! itself. Must not know: messages' bytes, drawing.

import { short } from "./canvas.js";

/** Where the slider stands, from 0 to 1000; small scales have more room. */
const SLIDER = 1000;
const LARGEST_RANK = 1000;

const el = (id) => document.getElementById(id);

/** The choice that an address asks for. */
export function choiceFrom(hash) {
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const rank = (name) => Math.min(LARGEST_RANK, Math.max(1, Math.trunc(Number(asked.get(name))) || 1));
  const alpha = Number(asked.get("alpha"));
  const cuts = {
    full: "Full",
    reduced: { Reduced: alpha > 0 && Number.isFinite(alpha) ? alpha : 1 },
    derived: { Derived: [rank("k"), rank("l")] },
  };
  const cut = cuts[asked.get("view")] ?? cuts.derived;
  const simplify = asked.get("simplify") === "yes" && cut !== "Full" ? "AtScale" : "No";
  return { stream: asked.get("stream"), view: { cut, simplify } };
}

/** The address of a choice. */
export function hashOf({ stream, view: { cut, simplify } }) {
  const asked = new URLSearchParams();
  if (stream !== null) asked.set("stream", stream);
  asked.set("view", kindOf(cut));
  if (cut.Derived) ["k", "l"].forEach((name, i) => asked.set(name, cut.Derived[i]));
  if (cut.Reduced !== undefined) asked.set("alpha", cut.Reduced);
  if (simplify !== "No") asked.set("simplify", "yes");
  return `#${asked}`;
}

const kindOf = (cut) => (cut === "Full" ? "full" : cut.Derived ? "derived" : "reduced");

export class Controls {
  /**
   * @param {import("./session.js").Session} session
   * @param {{fit: () => void, next: (by: number) => void, drop: () => void}} does
   */
  constructor(session, does) {
    this.session = session;
    this.does = does;
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
      el(`view-${kind}`).addEventListener("change", () => this.choose());
    el("simplify").addEventListener("change", () => this.choose());
    ["k", "l"].forEach((name, i) => {
      el(`${name}-less`).addEventListener("click", () => this.rank(i, -1));
      el(`${name}-more`).addEventListener("click", () => this.rank(i, 1));
    });
    el("alpha").addEventListener("input", () => {
      this.alpha = Math.max(Number.MIN_VALUE, this.largest * (el("alpha").value / SLIDER) ** 2);
      this.choose();
    });
    el("pause").addEventListener("click", () => this.session.pause(!this.session.paused));
    el("back").addEventListener("click", () => this.step(-1));
    el("forth").addEventListener("click", () => this.step(1));
    el("fit").addEventListener("click", () => this.does.fit());
    addEventListener("keydown", (event) => this.key(event));
  }

  /** The kind of view that is chosen. */
  get kind() {
    return ["full", "reduced", "derived"].find((kind) => el(`view-${kind}`).checked);
  }

  /** Takes a rank up or down. */
  rank(which, by) {
    el("view-derived").checked = true;
    this.ranks = this.ranks.map((rank, i) => (i === which ? Math.min(LARGEST_RANK, Math.max(1, rank + by)) : rank));
    this.choose();
  }

  /** Lets the session look at what is chosen. */
  choose() {
    this.alpha ??= this.largest / 4;
    const cut = { full: "Full", reduced: { Reduced: this.alpha }, derived: { Derived: this.ranks } }[this.kind];
    const simplify = el("simplify").checked && cut !== "Full" ? "AtScale" : "No";
    this.session.pause(false);
    this.session.chooseView({ cut, simplify });
    this.show();
  }

  /** Stops, and shows the frame so many later. */
  step(by) {
    this.session.pause(true);
    this.session.step(by);
    this.show();
  }

  /** Takes the largest scale that means anything here: the slider's end. */
  takeLargest(largest) {
    if (largest === this.largest) return;
    this.largest = largest;
    this.show();
  }

  /** Shows what is chosen. */
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
    el("alpha-value").textContent = short(alpha);
    const { paused, history } = this.session;
    el("pause").setAttribute("aria-pressed", paused);
    el("pause-word").textContent = paused ? "Go on" : "Pause";
    el("back").disabled = history.before === 0;
    el("forth").disabled = !paused || history.after === 0;
    const hash = hashOf(this.session.choice);
    if (location.hash !== hash) window.history.replaceState(null, "", hash);
  }

  /** Lists the streams to choose from. */
  showStreams() {
    const { streams, choice } = this.session;
    const names = streams.map((stream) => stream.name);
    if (choice.stream !== null && !names.includes(choice.stream)) names.push(choice.stream);
    const select = el("stream");
    if (names.join("\n") !== this.listed) {
      this.listed = names.join("\n");
      select.replaceChildren(...names.map((name) => new Option(name, name)));
      select.disabled = names.length === 0;
    }
    select.value = choice.stream ?? "";
    this.show();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { tagName } = event.target;
    if (tagName === "SELECT" || (tagName === "BUTTON" && [" ", "Enter"].includes(event.key))) return;
    const actions = {
      " ": () => this.session.pause(!this.session.paused),
      ",": () => this.step(-1),
      ".": () => this.step(1),
      k: () => this.rank(0, 1),
      K: () => this.rank(0, -1),
      l: () => this.rank(1, 1),
      L: () => this.rank(1, -1),
      1: () => this.pick("derived"),
      2: () => this.pick("reduced"),
      3: () => this.pick("full"),
      s: () => el("simplify").click(),
      f: () => this.does.fit(),
      "]": () => this.does.next(1),
      "[": () => this.does.next(-1),
      Escape: () => this.does.drop(),
    };
    if (!actions[event.key]) return;
    actions[event.key]();
    event.preventDefault();
  }

  pick(kind) {
    el(`view-${kind}`).checked = true;
    this.choose();
  }
}
