// SPDX-License-Identifier: Apache-2.0
// Asks for a simulation of the present scene, and for the pulses of the marked record.
import { Latest } from "./latest";
import type { Event, Link } from "./link";
import { state } from "./state";

export class PinReader {
  private readonly pulses: Latest<true>;
  private asked: { n: number; scene: string } | undefined; // simulation under way
  private periods = 2;

  constructor(private readonly link: Link) {
    this.pulses = new Latest(link);
  }

  simulate(): void {
    const scene = state.scene.peek();
    if (!scene) return;
    this.asked = { n: this.link.send({ t: "simulate", scene: scene.name }), scene: scene.name };
    state.pins.value = { underWay: true };
  }

  cancel(): void {
    this.asked = undefined;
    this.link.send({ t: "cancel", what: "simulate" });
    state.pins.value = { underWay: false };
  }

  /** Of the marked record, once its scene has been simulated. */
  show(periods = this.periods): void {
    this.periods = periods;
    const scene = state.scene.peek();
    const entry = scene?.tour[state.at.peek() ?? -1];
    const pins = state.pins.peek();
    if (scene && entry && pins.report && pins.scene === scene.name) this.pulses.ask({ t: "pulses", index: entry.index, periods }, true);
  }

  take(event: Extract<Event, { t: "pins" | "pulses" }>): void {
    if (event.t === "pulses") {
      if (this.pulses.came(event.n)) state.pins.value = { ...state.pins.peek(), window: event };
    } else if (event.n === this.asked?.n) {
      state.pins.value = { underWay: false, scene: this.asked.scene, report: event.report };
      this.asked = undefined;
      this.show();
    }
  }

  fail(n: number | undefined): void {
    this.pulses.came(n);
    if (this.asked === undefined || this.asked.n !== n) return;
    this.asked = undefined;
    state.pins.value = { underWay: false };
  }

  /** The server forgets what it simulated when the page's connection ends. */
  lose(): void {
    this.asked = undefined;
    this.pulses.lose();
    state.pins.value = { underWay: false };
  }
}
