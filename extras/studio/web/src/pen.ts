// SPDX-License-Identifier: Apache-2.0
// Draws on the plane: with a pointer, a finger or a pen while it is down, or with the arrow keys between two presses of Enter.
import type { Point } from "./link";
import { lengthOf, type Sample } from "./stroke";
import type { View } from "./view";

const step = 2; // mm of an arrow key
const longest = 60; // s

export interface PenTold {
  /** The line so far, of which the last place is the pen's; without a line, only where it is. */
  moved(samples: Sample[], at: Point): void;
  /** The line is whole. */
  ended(samples: Sample[]): void;
  /** The line cannot be taken, and why. */
  failed(why: string): void;
}

export class Pen {
  private samples: Sample[] = [];
  private draws: "no" | "pointer" | "keys" = "no";
  private at: Point;
  private readonly off = new AbortController();

  constructor(private readonly view: View, private readonly told: PenTold) {
    this.at = view.middle;
    view.drawing = true;
    const { canvas } = view;
    const on = <Kind extends keyof HTMLElementEventMap>(kind: Kind, does: (event: HTMLElementEventMap[Kind]) => void): void => canvas.addEventListener(kind, does, { signal: this.off.signal });
    on("pointerdown", (event) => {
      if (event.button !== 0 || this.draws !== "no") return;
      canvas.setPointerCapture(event.pointerId);
      this.begin("pointer");
      this.follow(event);
    });
    on("pointermove", (event) => {
      if (this.draws === "pointer") for (const each of event.getCoalescedEvents?.() ?? [event]) this.follow(each);
    });
    on("pointerup", (event) => {
      if (this.draws !== "pointer") return;
      this.follow(event);
      this.end();
    });
    on("pointercancel", () => this.draws === "pointer" && this.fail("The browser took the pointer away, as for a gesture of its own."));
    on("keydown", (event) => this.key(event));
    canvas.focus();
    this.show();
  }

  /** No more drawing. What is not whole is gone. */
  leave(): void {
    this.off.abort();
    this.view.drawing = false;
    this.view.showStroke([]);
    this.view.showFocus(undefined);
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "Enter") {
      event.preventDefault();
      if (event.repeat) return; // of the press that began the drawing
      if (this.draws === "keys") {
        this.add(event.timeStamp, this.at);
        this.end();
      } else if (this.draws === "no") {
        this.begin("keys");
        this.add(event.timeStamp, this.at);
      }
      return;
    }
    const along = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!along || this.draws === "pointer") return;
    event.preventDefault();
    const size = step * (event.shiftKey ? 5 : event.altKey ? 0.25 : 1);
    this.at = this.view.besideOnPlane(this.at, size * (along[0] ?? 0), size * (along[1] ?? 0));
    if (this.draws === "keys") this.add(event.timeStamp, this.at);
    this.show();
  }

  private follow(event: PointerEvent): void {
    if (this.draws !== "pointer") return;
    const at = this.view.onPlane(event.clientX, event.clientY);
    if (!at) return this.fail("The pointer left the plane: from where you look, it lies behind the horizon.");
    this.at = at;
    this.add(event.timeStamp, at);
    this.show();
  }

  private begin(by: "pointer" | "keys"): void {
    this.samples = [];
    this.draws = by;
  }

  private add(ms: number, at: Point): void {
    const before = this.samples.at(-1);
    if (before && ms <= before.ms) before.at = at; // two places at a time: the later one
    else this.samples.push({ ms, at });
    const begun = this.samples[0]?.ms ?? ms;
    if (ms - begun > 1000 * longest) this.fail(`The line took longer than ${longest} s.`);
  }

  private end(): void {
    this.draws = "no";
    if (lengthOf(this.samples.map(({ at }) => at)) === 0) return this.fail("The pen did not move.");
    this.told.ended(this.samples);
  }

  private fail(why: string): void {
    this.draws = "no";
    this.samples = [];
    this.show();
    this.told.failed(`${why} Nothing of the line was kept; draw it again.`);
  }

  private show(): void {
    this.view.showStroke(this.samples.map(({ at }) => at));
    this.view.showFocus(this.at);
    this.told.moved(this.samples, this.at);
  }
}
