// SPDX-License-Identifier: Apache-2.0
// What the page calls the keys of a design, on its fields and where a failure is about one.
import type { Failure } from "./link";

export const labels = {
  points: "Focal points", rate_hz: "Passes a second", speed_m_s: "Speed", frequency_hz: "Drawings a second", even: "All points feel alike",
  am: "Modulation", amplitude: "Amplitude", fade: "Strongest", loops: "Passes in all", array: "Array", board: "For board",
  shape: "Object", place: "Place", size: "Size", center: "Centre", rotate: "Turn about", keyframe: "Movement", trigger: "Triggers", path: "Path", hand: "Hand",
};

/** Options and keys whose setting has the field of another. */
const others: Record<string, keyof typeof labels> = { rate: "rate_hz", speed: "speed_m_s", frequency: "frequency_hz", am_law: "am", magnitude: "amplitude" };

/** The label of a key or an option that a failure names. */
export function labelOf(name: string): string | undefined {
  if (name === "project" || name.startsWith("generic-")) return "The design"; // no board was chosen
  const key = others[name] ?? name;
  return Object.hasOwn(labels, key) ? labels[key as keyof typeof labels] : undefined;
}

/** Where a failure is, in the page's words: a label, or a file's name, without the folders of this machine. */
export function placeOf(where: string): string {
  const [, place = "", line] = where.match(/^(.*?)(?::(\d+))?$/) ?? [];
  const known = labelOf(place.replace(/^-+/, ""));
  if (known !== undefined) return known;
  const name = place.startsWith("/dev/") ? place : place.slice(place.lastIndexOf("/") + 1);
  return line === undefined ? name : `${name}, line ${line}`;
}

/** What stands before a failure's words: what is wrong where it is known, and else where. */
export const headOf = ({ where, message }: Failure): string => (/out of reach|cannot reach/.test(message) ? "Out of reach" : placeOf(where));

/** The same folder may stand in the words, too. */
export function wordsOf({ where, message }: Failure): string {
  const folder = where.startsWith("/") && !where.startsWith("/dev/") ? where.slice(0, where.lastIndexOf("/") + 1) : "";
  return folder.length > 1 ? message.replaceAll(folder, "") : message;
}
