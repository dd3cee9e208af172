// SPDX-License-Identifier: Apache-2.0
// A live session, as `haptogram live` tells it: what it sees, what it plays, and how late.
import { project } from "./document";
import type { Failure, Link, LiveScene, LiveShown } from "./link";
import { type LiveSession, state } from "./state";
import type { View } from "./view";

const [firstNotes, lastNotes] = [10, 20]; // what is said at the beginning stays, whatever comes behind it
const mostLatencies = 100; // that the median is of

export class LiveReader {
  private begun: number | undefined; // message that begins a session

  constructor(
    private readonly link: Link,
    private readonly view: () => View | undefined,
  ) {}

  /** @param from  a tracker's named pipe; "": the document's recording */
  begin(from: string): void {
    const document = project.peek();
    if (!document) return;
    state.live.value = { now: "starting", code: null, notes: [], shots: 0, latencies: [] };
    this.begun = this.link.send({ t: "live", document, from });
  }

  show(shown: LiveShown): void {
    const live = state.live.peek();
    if (!live) return;
    const change = (changed: Partial<LiveSession>): void => void (state.live.value = { ...live, ...changed });
    if ("scene" in shown) {
      const latencies = shown.latency_ms === null ? live.latencies : [...live.latencies, shown.latency_ms].slice(-mostLatencies);
      change({ now: "running", last: shown, shots: live.shots + 1, latencies });
      this.view()?.showLive(shown);
    } else if (shown.show === "begun") {
      this.begun = undefined;
    } else if (shown.show === "note") {
      change({ notes: [...live.notes.slice(0, firstNotes), ...[...live.notes.slice(firstNotes), shown.text].slice(-lastNotes)] });
    } else {
      this.ended(shown.code);
    }
  }

  fail(n: number | undefined, error: Failure): boolean {
    if (n === undefined || n !== this.begun) return false;
    this.begun = undefined;
    state.live.value = undefined;
    state.failure.value = error;
    return true;
  }

  /** The server ended the session with the page's connection. */
  lose(): void {
    if (state.live.peek()) this.ended(null);
  }

  private ended(code: number | null): void {
    const live = state.live.peek();
    if (!live || live.now === "ended") return;
    state.live.value = { ...live, now: "ended", code };
    this.view()?.showLive(undefined);
  }
}

/** The median of the last ones, ms. */
export const medianOf = (latencies: number[]): number | undefined => [...latencies].sort((a, b) => a - b)[latencies.length >> 1];

/** What stands in a scene, in words for who does not see it. */
export function wordsOf({ hands, fingers, foci, contacts_mm, objects }: LiveScene): string {
  const things = objects.map(({ object, size_mm: size, center_mm: at }) => `${object} of ${Math.round(size)} mm at (${at.map(Math.round).join(", ")})`);
  const seen = `${hands.length === 0 ? "no hand" : hands.length === 1 ? "a hand" : `${hands.length} hands`}, ${things.join(", ") || "no object"}`;
  return fingers === 0 && foci.length === 0 ? `${seen}, and no touch` : `${seen}; ${fingers} parts touch, on ${contacts_mm.length} lines`;
}
