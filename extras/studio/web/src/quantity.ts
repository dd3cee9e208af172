// SPDX-License-Identifier: Apache-2.0
// How a slice is shown. The slice itself is the mean square pressure, Pa²: units, ranges and colours cost no new calculation.
import { signal } from "@preact/signals";
import type { ColourMap } from "./colours";

export type Quantity = "skin" | "rms" | "level" | "below";

/** `command` is the quantity's name on the command line. */
export const quantities: Record<Quantity, { name: string; unit: string; decibels: boolean; command: string }> = {
  skin: { name: "Pressure on the skin", unit: "Pa", decibels: false, command: "radiation" },
  rms: { name: "Sound pressure, rms", unit: "Pa", decibels: false, command: "rms" },
  level: { name: "Sound pressure level", unit: "dB", decibels: true, command: "spl" },
  below: { name: "Level below the peak", unit: "dB", decibels: true, command: "spl" },
};

export interface Look {
  quantity: Quantity;
  colours: ColourMap;
  /** of the colour bar, for levels */
  rangeDb: number;
  /** the upper end of the colour bar, Pa²; without it, the greatest value of the slice */
  top: number | undefined;
}

export const look = signal<Look>({ quantity: "skin", colours: "viridis", rangeDb: 40, top: undefined });

const reference = 20e-6 ** 2; // of levels, Pa²

/** The value of a mean square pressure in the unit of a quantity. @param greatest  that levels below the peak count from, Pa² */
export function valueOf(square: number, shown: Quantity, greatest: number, skinPerSquare: number): number {
  if (shown === "skin") return square * skinPerSquare;
  if (shown === "rms") return Math.sqrt(square);
  return 10 * Math.log10(square / (shown === "level" ? reference : greatest));
}

/** The inverse: the mean square pressure of a value. */
export function squareOf(value: number, shown: Quantity, greatest: number, skinPerSquare: number): number {
  if (shown === "skin") return value / skinPerSquare;
  if (shown === "rms") return value ** 2;
  return 10 ** (value / 10) * (shown === "level" ? reference : greatest);
}

/** The value at a fraction of the colour bar, 0 at its lower end. @param top  its upper end, Pa² */
export function valueOnScale(fraction: number, { quantity, rangeDb }: Look, top: number, skinPerSquare: number): number {
  const upper = valueOf(top, quantity, top, skinPerSquare);
  return quantities[quantity].decibels ? upper + (fraction - 1) * rangeDb : fraction * upper;
}

/** Three significant digits. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  return Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : String(Number(value.toPrecision(3)));
}
