// SPDX-License-Identifier: Apache-2.0
// A line drawn by hand, in places and times, and the path file that it becomes.
import type { Point } from "./link";

/** Where the pen was, and when. */
export interface Sample {
  ms: number;
  at: Point;
}

const distance = (a: Point, b: Point): number => Math.hypot(...a.map((each, i) => each - (b[i] ?? 0)));
/** How long the way through places is. */
export const lengthOf = (places: Point[]): number => places.reduce((sum, at, i) => sum + distance(at, places[i - 1] ?? at), 0);
/** How far the farthest of the places was moved. */
export const farthest = (before: Sample[], after: Sample[]): number => Math.max(0, ...before.map(({ at }, i) => distance(at, after[i]?.at ?? at)));

/** Each place becomes the mean of those around it, as long as the pen was there; both ends stay. @param width  standard deviation of the weights, ms */
export function smoothed(samples: Sample[], width: number): Sample[] {
  if (width === 0) return samples;
  const last = samples.length - 1;
  const time = (i: number): number => samples[Math.max(0, Math.min(last, i))]?.ms ?? 0;
  return samples.map(({ ms, at }, i) => {
    if (i === 0 || i === last) return { ms, at };
    let whole = 0;
    const sum = [0, 0, 0];
    samples.forEach((other, k) => {
      const far = (other.ms - ms) / width;
      if (Math.abs(far) > 4) return;
      const weight = Math.exp((-far * far) / 2) * (time(k + 1) - time(k - 1));
      whole += weight;
      other.at.forEach((value, axis) => (sum[axis] = (sum[axis] ?? 0) + weight * value));
    });
    return whole > 0 ? { ms, at: sum.map((each) => each / whole) as Point } : { ms, at };
  });
}

/** So many places at equal times, the first and the last among them: where the hand was fast they are far from each other. */
export function evenly(samples: Sample[], count: number): Point[] {
  const [first, last] = [samples[0], samples.at(-1)];
  if (!first || !last) return [];
  let k = 0;
  return Array.from({ length: count }, (_, i) => {
    const ms = first.ms + ((last.ms - first.ms) * i) / Math.max(1, count - 1);
    while (k < samples.length - 2 && (samples[k + 1]?.ms ?? 0) <= ms) k++;
    const [from, to] = [samples[k] ?? first, samples[k + 1] ?? last];
    const part = to.ms > from.ms ? Math.min(1, (ms - from.ms) / (to.ms - from.ms)) : 1;
    return from.at.map((each, axis) => each + part * ((to.at[axis] ?? 0) - each)) as Point;
  });
}

/** The path file of places that are passed at equal times. */
export function pathFile(places: Point[], seconds: number): string {
  const short = (value: number): string => String(Number(value.toFixed(4)));
  const rows = places.map((at, i) => [short((1000 * seconds * i) / places.length), ...at.map(short)].join(","));
  return `time_ms,x_mm,y_mm,z_mm\n${rows.join("\n")}\n`;
}

/** What pathFile() wrote; nothing for other files. */
export function readPathFile(text: string): { places: Point[]; seconds: number } | undefined {
  const [head, ...rows] = text.trim().split("\n");
  if (head !== "time_ms,x_mm,y_mm,z_mm" || rows.length < 2) return undefined;
  const values = rows.map((row) => row.split(",").map(Number));
  const places = values.map(([, x = 0, y = 0, z = 0]): Point => [x, y, z]);
  return { places, seconds: ((values[1]?.[0] ?? 0) * rows.length) / 1000 };
}
