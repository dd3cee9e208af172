// SPDX-License-Identifier: Apache-2.0
// Objects to begin with, as documents.
import type { ProjectDocument } from "./document";

const format = "haptogram-project-1";

export const library: Record<string, ProjectDocument> = {
  "Dome of 200 points": { format, rate_hz: 7, shape: [{ kind: "hemisphere" }] },
  "Ring drawn at 7 m/s": { format, points: 60, speed_m_s: 7, shape: [{ kind: "circle", diameter_mm: 40 }] },
  "Triangle that feels even": { format, points: 40, rate_hz: 20, even: true, shape: [{ kind: "triangle", length_mm: 60 }] },
  "Point that vibrates at 200 Hz": { format, am: "sine:200", shape: [{ kind: "point" }] },
  "Plus of 40 points": { format, points: 40, rate_hz: 40, shape: [{ kind: "plus", length_mm: 50 }] },
  "Cube of 150 points": { format, points: 150, rate_hz: 10, shape: [{ kind: "cube", length_mm: 40 }] },
  "Hand that slides over a sphere": { format, points: 100, hand: { recording: "synthetic:slide", object: "sphere", algorithm: "A", frame: 60 } },
  "Helix drawn 5 times a second": { format, points: 200, frequency_hz: 5, shape: [{ kind: "helix" }] },
};
