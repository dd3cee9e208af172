// SPDX-License-Identifier: Apache-2.0
// Designs to compile, many and of many kinds.

/** Numbers that are the same for the same seed. */
export function randomOf(seed) {
  let state = seed >>> 0 || 1;
  return (least, most) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return least + (state / 2 ** 32) * (most - least);
  };
}

/** A design of some points, as the page has it. */
export function randomDesign(random) {
  const pick = (...choices) => choices[Math.floor(random(0, choices.length))];
  const tenth = (least, most) => Math.round(10 * random(least, most)) / 10;
  const design = { format: "haptogram-project-1", points: Math.round(random(3, 60)) };
  design[pick("rate_hz", "rate_hz", "frequency_hz")] = tenth(5, 20);
  if (random(0, 1) < 0.3) design.amplitude = Math.max(0.1, tenth(0.1, 1));
  if (random(0, 1) < 0.2) design.loops = Math.round(random(1, 9));
  if (random(0, 1) < 0.3) design.board = pick("ice40-hx8k-breakout", "ulx3s-85f");
  if (design.board === undefined && random(0, 1) < 0.2) design.seed = Math.round(random(0, 1000));
  design.place = { size_mm: tenth(20, 60), center_mm: [tenth(-15, 15), tenth(-15, 15), tenth(110, 180)], rotate_deg: [tenth(-90, 90), 0, tenth(-90, 90)] };
  design.shape = [{ kind: pick("circle", "triangle", "square", "plus", "line", "helix") }];
  if (design.frequency_hz === undefined) design.shape[0].kind = pick("circle", "sphere", "hemisphere", "cube", "cone", "cylinder", "plus");
  return design;
}
