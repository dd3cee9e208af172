// SPDX-License-Identifier: Apache-2.0
// What is shown of a slice. The slice itself is the mean square pressure, Pa²; units and ranges cost no new calculation.
import { signal } from "@preact/signals";

export type Quantity = "skin" | "rms" | "level" | "below";

export const quantities: Record<Quantity, { name: string; unit: string; range: number }> = {
  skin: { name: "Radiation pressure on skin", unit: "Pa", range: 0 },
  rms: { name: "Sound pressure, rms", unit: "Pa", range: 0 },
  level: { name: "Sound pressure level", unit: "dB", range: 40 },
  below: { name: "Level below the peak", unit: "dB", range: 40 },
};

export const quantity = signal<Quantity>("skin");

/** The value of a mean square pressure in the unit of a quantity. @param greatest  of the slice, Pa² */
export function valueOf(square: number, shown: Quantity, greatest: number, skinPerSquare: number): number {
  if (shown === "skin") return square * skinPerSquare;
  if (shown === "rms") return Math.sqrt(square);
  return 10 * Math.log10(square / (shown === "level" ? 20e-6 ** 2 : greatest));
}

/** The inverse for a scale: the value at a fraction of the colour bar, 0 at its lower end. */
export function valueOnScale(fraction: number, shown: Quantity, greatest: number, skinPerSquare: number): number {
  const { range } = quantities[shown];
  if (range > 0) return valueOf(greatest, shown, greatest, skinPerSquare) + (fraction - 1) * range;
  return fraction * valueOf(greatest, shown, greatest, skinPerSquare);
}

/** Three significant digits. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  return Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : String(Number(value.toPrecision(3)));
}
