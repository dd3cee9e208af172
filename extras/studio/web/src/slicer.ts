// SPDX-License-Identifier: Apache-2.0
// Asks for slices: one under way at a time, of which the answer says how many points the next may have, so that a plane
// follows the hand whatever the array and the number of foci. At rest it is asked for once more, at full size.
import type { Link, SliceData } from "./link";
import type { Edges } from "./view";

const full = 200; // points along an edge, at rest
const least = 48; // and at least, moving
const budgetMs = 12; // of computing, moving
const restMs = 120; // until it counts as rest

export class Slicer {
  /** Slices that were shown, and how long the last took from being asked for to its arrival. */
  shown = 0;
  latencyMs = 0;
  private underWay: { n: number; asked: number } | undefined;
  private wanted: { moving: boolean } | undefined;
  private costMs: number | undefined; // of a point, by the last answers
  private rest: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly link: Link,
    private readonly edges: () => Edges,
    /** What the slice is of, as the server is asked for it. */
    private readonly of: () => { t: string; scene: string; record?: number } | undefined,
    /** Told whether a slice is still to come. */
    private readonly busy: (busy: boolean) => void,
  ) {}

  ask(moving: boolean): void {
    clearTimeout(this.rest);
    this.rest = moving ? setTimeout(() => this.ask(false), restMs) : undefined;
    this.wanted = { moving };
    this.next();
  }

  /** @return whether the slice is the one that was asked for */
  take(slice: SliceData): boolean {
    const { underWay } = this;
    if (underWay?.n !== slice.n) return false;
    this.latencyMs = performance.now() - underWay.asked;
    const cost = slice.tookMs / slice.values.length;
    this.costMs = this.costMs === undefined ? cost : 0.7 * this.costMs + 0.3 * cost;
    this.shown += 1;
    this.underWay = undefined;
    this.next();
    return true;
  }

  /** @return whether it was a slice that failed */
  fail(n: number | undefined): boolean {
    if (this.underWay === undefined || this.underWay.n !== n) return false;
    this.underWay = undefined;
    this.next();
    return true;
  }

  /** What was under way will never come. */
  lose(): void {
    this.underWay = undefined;
  }

  /** There is nothing to slice any more. */
  stop(): void {
    clearTimeout(this.rest);
    this.rest = this.wanted = this.underWay = undefined;
    this.busy(false);
  }

  private next(): void {
    const of = this.of();
    this.busy(this.underWay !== undefined || this.wanted !== undefined || this.rest !== undefined);
    if (this.underWay !== undefined || this.wanted === undefined || of === undefined || !this.link.open) return;
    // The first of all says what a point costs, and is there soon.
    const first = this.costMs === undefined;
    let points = first ? least : full;
    if (this.wanted.moving && this.costMs !== undefined) points = Math.max(least, Math.min(full, Math.floor(Math.sqrt(budgetMs / this.costMs))));
    this.wanted = first ? { moving: false } : undefined;
    const n = this.link.send({ ...of, ...this.edges(), width: points, height: points, view: 0 });
    this.underWay = { n, asked: performance.now() };
  }
}
