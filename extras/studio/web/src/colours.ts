// SPDX-License-Identifier: Apache-2.0
// Colour maps of even steps to the eye, also to those who do not see all colours: viridis, inferno and cividis (all CC0) at
// 33 places, between which colours are interpolated; and grey.
import { Color } from "three";

const places = {
  viridis:
    "440154 470d60 48186a 482374 472d7b 453781 424086 3e4989 3b528b 375b8d 33638d 2f6b8e 2c728e 297a8e 26828e 23898e 21918c " +
    "1f988b 1fa088 22a785 28ae80 32b67a 3fbc73 4ec36b 5ec962 70cf57 84d44b 98d83e addc30 c2df23 d8e219 ece51b fde725",
  inferno:
    "000004 040312 0b0724 150b37 210c4a 2f0a5b 3d0965 4a0c6b 57106e 64156e 71196e 7d1e6d 8a226a 972766 a32c61 b0315b bc3754 " +
    "c73e4c d24644 db503b e45a31 eb6628 f1731d f68013 f98e09 fb9d07 fcac11 fbbc21 f9cb35 f5db4c f2ea69 f3f68a fcffa4",
  cividis:
    "00224e 00285b 002e6a 053371 1a386f 273e6e 32436d 3b496c 434e6c 4b546c 535a6d 5a5f6e 61656f 686a71 6f7073 767676 7d7c78 " +
    "848279 8c8878 938e78 9b9476 a39a74 aba072 b4a76f bcae6c c4b468 cdbb63 d5c25e dec958 e7d150 f0d846 f9e03a fee838",
  grey: "000000 ffffff",
};

export type ColourMap = keyof typeof places;
export const colourMaps = Object.keys(places) as ColourMap[];

/** The colours of a map from low to high, for the bar beside the view. */
export const stops = (map: ColourMap): string[] => places[map].split(" ").map((hex) => `#${hex}`);

/** The colour of a phase: a way round the hues at one lightness and strength in CIELAB, so that none stands out. */
export function phaseColour(degrees: number): Color {
  const angle = (degrees * Math.PI) / 180;
  const [a, b] = [48 * Math.cos(angle), 48 * Math.sin(angle)];
  const y = (65 + 16) / 116;
  const inverse = (t: number): number => (t > 6 / 29 ? t ** 3 : 3 * (6 / 29) ** 2 * (t - 4 / 29));
  const [X, Y, Z] = [0.9505 * inverse(y + a / 500), inverse(y), 1.089 * inverse(y - b / 200)]; // of D65
  return new Color(3.2406 * X - 1.5372 * Y - 0.4986 * Z, -0.9689 * X + 1.8758 * Y + 0.0415 * Z, 0.0557 * X - 0.204 * Y + 1.057 * Z);
}

/** 256 colours, four bytes each. */
export function table(map: ColourMap): Uint8Array<ArrayBuffer> {
  const colours = places[map].split(" ").map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  const all = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (colours.length - 1);
    const below = Math.min(colours.length - 2, Math.floor(place));
    for (let c = 0; c < 3; c++) {
      const [from, to] = [colours[below]?.[c] ?? 0, colours[below + 1]?.[c] ?? 0];
      all[4 * i + c] = Math.round(from + (to - from) * (place - below));
    }
    all[4 * i + 3] = 255;
  }
  return all;
}
