// SPDX-License-Identifier: Apache-2.0
// Files that are dropped: which settings of the document they become. What is in them is for the server to say.
import { having, type ProjectDocument } from "./document";

const isHand = (name: string): boolean => /\.(json|lz|pose)$/.test(name);
const isMesh = (name: string): boolean => /\.(ply|obj|stl)$/.test(name);

/** The document with the files in their places: recordings and objects of a hand, or the shapes of an object. */
export function withFiles(document: ProjectDocument, names: string[]): ProjectDocument {
  const path = names.find((name) => name.endsWith(".adaptics"));
  const array = names.find((name) => name.endsWith(".toml"));
  if (path !== undefined) return having({ format: document.format }, { array: document.array, board: document.board, points: document.points, path });
  if (array !== undefined && names.length === 1) return having(document, { array, board: undefined });
  const poses = names.find((name) => name.endsWith(".pose"));
  // Beside poses, a .json is the model of their bones.
  const model = poses === undefined ? undefined : names.find((name) => name.endsWith(".json"));
  const recording = poses ?? names.find(isHand);
  const mesh = names.find(isMesh);
  if (recording !== undefined) {
    const { frames_hz: _, model: __, ...kept } = document.hand ?? { object: "sphere", algorithm: "A" };
    const hand = { ...kept, recording, frame: 1, ...(model === undefined ? {} : { model }), ...(mesh === undefined ? {} : { object: mesh }) };
    const { array, board, am, am_law: law, points } = document;
    return having({ format: document.format }, { array, board, am, am_law: law, points, hand });
  }
  if (document.hand && mesh !== undefined) {
    const { height_mm: _, unit: __, ...kept } = document.hand;
    return having(document, { hand: { ...kept, object: mesh, size_mm: kept.size_mm ?? 100 } });
  }
  const place = { size_mm: 60, center_mm: [0, 0, 130], ...document.place };
  const { hand: _, path: __, ...rest } = document;
  return { ...rest, place, shape: names.map((file) => ({ file })) };
}

/** Lets files be dropped anywhere on the page. */
export function takeDrops(host: HTMLElement, drop: (files: File[]) => void): void {
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    host.classList.add("dropping");
  });
  document.addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) host.classList.remove("dropping");
  });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    host.classList.remove("dropping");
    drop([...(event.dataTransfer?.files ?? [])]);
  });
}
