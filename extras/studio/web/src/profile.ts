// SPDX-License-Identifier: Apache-2.0
// Values along a line through the field, which are a slice of two equal rows, and what is read off them.
import type { Point, SliceData } from "./link";

export type Line = "x" | "y" | "z";
export const lines: Line[] = ["x", "y", "z"];

export const profilePoints = 401;
const half = 80; // mm to either side
const lowest = 5; // mm above the array, where there is a field everywhere

/** The ends of a line of 160 mm along an axis through a point, above the array. */
export function endsOf(line: Line, through: Point): { from: Point; to: Point } {
  const axis = lines.indexOf(line);
  const from = [...through] as Point, to = [...through] as Point;
  from[axis] = (through[axis] ?? 0) - half;
  to[axis] = (through[axis] ?? 0) + half;
  if (line === "z") from[2] = Math.max(lowest, from[2]);
  return { from, to };
}

/** What the server is asked for a profile, in a view of its own. */
export function profileMessage(scene: string, record: number, { from, to }: { from: Point; to: Point }, view: number): { t: string; [member: string]: unknown } {
  return { t: "slice", scene, origin: from, u: to.map((each, i) => each - (from[i] ?? 0)), v: [0, 0, 0], width: profilePoints, height: 2, record, view };
}

export const valuesOf = (slice: SliceData): Float32Array => slice.values.slice(0, slice.width);

export interface Width {
  /** Places, from 0 to 1 along the line, where the field has half of its greatest radiation pressure. */
  low: number;
  high: number;
}

/** Full width at half of the greatest value; none when the field does not fall to half on both sides. */
export function widthOf(values: Float32Array): Width | undefined {
  let peak = 0;
  values.forEach((value, i) => value > (values[peak] ?? 0) && (peak = i));
  const limit = (values[peak] ?? 0) / 2;
  const crossing = (step: 1 | -1): number | undefined => {
    for (let i = peak; i + step >= 0 && i + step < values.length; i += step) {
      const [inside, outside] = [values[i] ?? 0, values[i + step] ?? 0];
      if (outside < limit) return (i + (step * (inside - limit)) / (inside - outside)) / (values.length - 1);
    }
    return undefined;
  };
  const [low, high] = [crossing(-1), crossing(1)];
  return low === undefined || high === undefined ? undefined : { low, high };
}

/** Even steps of 1, 2 or 5 times a power of ten, about so many between two values. */
export function ticks(least: number, most: number, about: number): number[] {
  const rough = (most - least) / about;
  if (!(rough > 0) || !Number.isFinite(rough)) return [least];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= rough) ?? rough;
  const found: number[] = [];
  for (let i = Math.ceil(least / step - 1e-9); i * step <= most + 1e-9 * step; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}
