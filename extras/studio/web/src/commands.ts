// SPDX-License-Identifier: Apache-2.0
// The commands that make the same files as the page, for the same plane.
import type { ProjectDocument } from "./document";
import type { Point } from "./link";
import { quantities, type Quantity } from "./quantity";
import type { Edges } from "./view";

/** What the server and the command line are asked for a field: the text of the plane, and ranges along its axes. */
export interface FieldQuery {
  plane: string;
  ranges: Record<string, string>;
}

const axes = ["x", "y", "z"];
const rounded = (value: number): number => Number(value.toFixed(4)); // mm
const isAlong = (edge: Point, axis: number): boolean => edge.every((each, i) => i === axis || Math.abs(each) < 1e-6);

/** The plane as the command line names it; none when it lies askew. Points at or below the array have no field, so that z begins one step above it. */
export function fieldQuery({ origin, u, v }: Edges, stepMm: number): FieldQuery | undefined {
  const along = [u, v].map((edge) => axes.findIndex((_, axis) => isAlong(edge, axis)));
  if (along.includes(-1) || along[0] === along[1]) return undefined;
  const across = [0, 1, 2].find((axis) => !along.includes(axis)) ?? 2;
  const ranges: Record<string, string> = {};
  for (const axis of [...along].sort()) {
    const ends = [origin[axis] ?? 0, (origin[axis] ?? 0) + (u[axis] ?? 0) + (v[axis] ?? 0)].sort((a, b) => a - b).map(rounded);
    if (axis === 2) ends[0] = Math.max(stepMm, ends[0] ?? 0);
    ranges[axes[axis] ?? ""] = ends.join(":");
  }
  return { plane: `${Object.keys(ranges).join("")}@${axes[across]}=${rounded(origin[across] ?? 0)}`, ranges };
}

/** Lines for a shell, of one record or, with 0, of all, and what they ask of the field; that is none when the plane lies askew. */
export function commands(edges: Edges, quantity: Quantity, stepMm: number, record: number, board?: { name: string; bitstream: string }): { text: string; field: FieldQuery | undefined } {
  const field = fieldQuery(edges, stepMm);
  const lines = ["haptogram compile project.toml -o image.hex"];
  if (field) {
    const ranges = Object.entries(field.ranges).map(([axis, range]) => `--${axis}=${range}`);
    const of = record === 0 ? "" : ` --record ${record}`;
    lines.push(`haptogram field image.hex${of} --plane ${field.plane} ${ranges.join(" ")} --step ${stepMm} --quantity ${quantities[quantity].command} -o field.png`);
  }
  if (board) lines.push(`haptogram bitstream --board ${board.name} --image image.hex -o ${board.bitstream}`);
  return { text: lines.join("\n"), field };
}

/** A word as a shell takes it. */
const word = (text: string): string => (/^[\w.,:=/+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

/** The command that renders a document's hand: its frame, or, when the document has none, all of them. */
export function renderCommand({ hand, points, seed, speed_m_s, frequency_hz, jump, am, am_law, amplitude, magnitude, array, board }: ProjectDocument): string {
  if (!hand) return "";
  const options: [string, unknown][] = [
    ["hand", hand.recording],
    ["hand-model", hand.model],
    ["hand-rate", hand.frames_hz],
    ["algorithm", hand.algorithm],
    ["size", hand.size_mm],
    ["height", hand.height_mm],
    ["center", hand.center_mm?.join(",")],
    ["rotate", hand.rotate_deg?.join(",")],
    ["unit", hand.unit],
    ["frame", hand.frame],
    ["points", hand.frame === undefined ? undefined : (points ?? 200)],
    ["speed", speed_m_s],
    ["frequency", frequency_hz],
    ["jump", jump],
    ["am", am],
    ["am-law", am_law],
    ["amplitude", amplitude],
    ["magnitude", magnitude],
    ["seed", seed],
    ["array", array],
    ["board", board],
  ];
  const given = options.filter(([, value]) => value !== undefined).map(([name, value]) => `--${name}=${word(String(value))}`);
  return `haptogram render ${word(hand.object ?? "sphere")} ${given.join(" ")} -o path.json`;
}
