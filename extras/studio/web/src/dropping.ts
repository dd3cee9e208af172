// SPDX-License-Identifier: Apache-2.0
// Files that are dropped: which settings of the document they become, by their endings and, where these leave it open, by what is in them.
// What is wrong with them is for the engine to say.
import { having, type ProjectDocument } from "./document";

/** A model is any JSON that is no path, until one knows that there are poses. */
type Kind = "path" | "array" | "calibration" | "sound" | "curve" | "recording" | "poses" | "model" | "mesh" | "cloud";
export interface Dropped {
  name: string;
  kind: Kind;
}

const plain: Record<string, Kind> = { adaptics: "path", wav: "sound", lz: "recording", pose: "poses", ply: "mesh", obj: "mesh", stl: "mesh" };

/** A CSV file says in its first row what it is: places at times, a strength at times, or places alone. */
function kindOfRows(text: string): Kind {
  const first = text.replace(/^\ufeff/, "").split(/\r?\n/).find((line) => line.trim() !== "" && !line.trim().startsWith("#")) ?? "";
  const fields = first.toLowerCase().split(/[,;\t]/).map((field) => field.trim());
  if (!fields.some((field) => field.startsWith("time"))) return "cloud";
  return fields.length === 2 && fields[1] === "amplitude" ? "curve" : "path";
}

function kindOfJson(text: string): Kind {
  try {
    return (JSON.parse(text) as { format?: unknown } | null)?.format === "haptogram-path-1" ? "path" : "model";
  } catch {
    return "model"; // the reader of recordings says what is wrong
  }
}

export async function kindOf(file: File): Promise<Dropped> {
  const { name } = file;
  const ending = name.slice(name.lastIndexOf(".") + 1).toLowerCase();
  if (ending === "csv") return { name, kind: kindOfRows(await file.slice(0, 10_000).text()) };
  if (ending === "json") return { name, kind: kindOfJson(await file.text()) };
  if (ending === "toml") return { name, kind: /^\s*format\s*=\s*"haptogram-calibration-/m.test(await file.text()) ? "calibration" : "array" };
  return { name, kind: plain[ending] ?? "cloud" };
}

/** The document with the files in their places: what plays, the array that plays it, and what it is modulated by. */
export function withFiles(document: ProjectDocument, files: Dropped[]): ProjectDocument {
  const first = (...kinds: Kind[]): string | undefined => files.find(({ kind }) => kinds.includes(kind))?.name;
  const array = first("calibration") ?? first("array"); // a calibration names its array
  const [sound, curve] = [first("sound"), first("curve")];
  const am = sound === undefined ? (curve === undefined ? undefined : `csv:${curve}`) : `wav:${sound}`;
  return having(withPlayed(document, files, first), { ...(array === undefined ? {} : { array, board: undefined }), ...(am === undefined ? {} : { am }) });
}

function withPlayed(document: ProjectDocument, files: Dropped[], first: (...kinds: Kind[]) => string | undefined): ProjectDocument {
  const { array, board, am, am_law, points } = document;
  const path = first("path");
  if (path !== undefined) return having({ format: document.format }, { array, board, am, am_law, ...(path.endsWith(".adaptics") ? { points } : {}), path });
  const poses = first("poses");
  const recording = poses ?? first("recording", "model");
  const mesh = first("mesh");
  if (recording !== undefined) {
    const model = poses === undefined ? undefined : first("model");
    const { frames_hz: _, model: __, ...kept } = document.hand ?? { object: "sphere", algorithm: "A" };
    const hand = { ...kept, recording, frame: 1, ...(model === undefined ? {} : { model }), ...(mesh === undefined ? {} : { object: mesh }) };
    return having({ format: document.format }, { array, board, am, am_law, points, hand });
  }
  if (document.hand && mesh !== undefined) {
    const { height_mm: _, unit: __, ...kept } = document.hand;
    return having(document, { hand: { ...kept, object: mesh, size_mm: kept.size_mm ?? 100 } });
  }
  const shapes = files.filter(({ kind }) => kind === "mesh" || kind === "cloud");
  if (shapes.length === 0) return document;
  const place = { size_mm: 60, center_mm: [0, 0, 130], ...document.place };
  const { hand: _, path: __, keyframe, ...rest } = document;
  const moved = keyframe && { keyframe: keyframe.map(({ shape: _, ...frame }) => frame) }; // they become none of the old shapes
  return { ...rest, ...moved, place, shape: shapes.map(({ name }) => ({ file: name })) };
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
