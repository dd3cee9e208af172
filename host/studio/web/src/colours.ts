// SPDX-License-Identifier: Apache-2.0
/** The colour map viridis (CC0) at 33 places, between which colours are interpolated. */
const places =
  "440154 470d60 48186a 482374 472d7b 453781 424086 3e4989 3b528b 375b8d 33638d 2f6b8e 2c728e 297a8e 26828e 23898e 21918c " +
  "1f988b 1fa088 22a785 28ae80 32b67a 3fbc73 4ec36b 5ec962 70cf57 84d44b 98d83e addc30 c2df23 d8e219 ece51b fde725";

export const stops = places.split(" ").map((hex) => `#${hex}`);

/** 256 colours, four bytes each. */
export function viridis(): Uint8Array<ArrayBuffer> {
  const colours = places.split(" ").map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  const table = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (colours.length - 1);
    const below = Math.min(colours.length - 2, Math.floor(place));
    for (let c = 0; c < 3; c++) {
      const [from, to] = [colours[below]?.[c] ?? 0, colours[below + 1]?.[c] ?? 0];
      table[4 * i + c] = Math.round(from + (to - from) * (place - below));
    }
    table[4 * i + 3] = 255;
  }
  return table;
}
