// SPDX-License-Identifier: Apache-2.0
// Where a pass is at a time.
import type { Scene } from "./link";

/** The entry of the tour that plays at a time; in silence, the one before. */
export function entryAt(scene: Scene, seconds: number): number {
  let [low, high] = [0, scene.tour.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if ((scene.tour[middle]?.from_s ?? 0) <= seconds) low = middle;
    else high = middle - 1;
  }
  return low;
}
