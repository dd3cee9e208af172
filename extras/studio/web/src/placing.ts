// SPDX-License-Identifier: Apache-2.0
// Where objects are: a document places the whole, and each of its shapes before that.
import { having, type KeyFrame, type Place, type ProjectDocument, type ShapeEntry } from "./document";
import type { FileSize, Point } from "./link";
import { short } from "./quantity";

const standard: Point = [0, 0, 130]; // of built-in shapes, none of which has a centre
export const touchedAt: Point = [0, 0, 200]; // of an object that a hand feels
const keys = ["scale", "size_mm", "rotate_deg", "center_mm"] as const;

/** What a 1 in a file may be, and how many millimetres that is. */
const unitsMm = { mm: 1, cm: 10, inch: 25.4, m: 1000 };
export const fileUnits = Object.keys(unitsMm);
const fittedMm = 60;

/** Without the keys that are undefined. */
function clean<T extends object>(given: T): T {
  return Object.fromEntries(Object.entries(given).filter(([, value]) => value !== undefined)) as T;
}

/** Which shape of a document has the place that is edited; undefined: the whole. @param chosen  of several */
export function placed({ shape = [], place }: ProjectDocument, chosen: number | undefined): number | undefined {
  if (shape.length > 1) return chosen !== undefined && chosen < shape.length ? chosen : undefined;
  return place === undefined && keys.some((key) => shape[0]?.[key] !== undefined) ? 0 : undefined;
}

/** Where one of several objects is, or, with undefined, all together. */
export function placeOf(document: ProjectDocument, object: number | undefined): Place {
  if (document.hand) return { center_mm: document.hand.center_mm ?? touchedAt, rotate_deg: document.hand.rotate_deg ?? [0, 0, 0] };
  return object === undefined ? document.place ?? {} : document.shape?.[object] ?? {};
}

/** A document in which one object, or all together, is somewhere else. */
export function moved(document: ProjectDocument, object: number | undefined, change: { [Key in keyof Place]: Place[Key] | undefined }): ProjectDocument {
  if (document.hand) return having(document, { hand: clean({ ...document.hand, ...change }) });
  if (object === undefined) {
    const place = clean({ ...document.place, ...change });
    return having(document, { place: Object.keys(place).length > 0 ? place : undefined });
  }
  const shape = (document.shape ?? []).map((each, i) => (i === object ? clean({ ...each, ...change }) : each)) as ShapeEntry[];
  return having(document, { shape });
}

/** One more object. What was the place of a single one becomes its own, so that it stays where it is. */
export function withAnother(document: ProjectDocument, another: ShapeEntry): ProjectDocument {
  const shapes = document.shape ?? [];
  const only = shapes.length === 1 ? shapes[0] : undefined;
  if (!only) return having(document, { shape: [...shapes, another] });
  const own = keys.some((key) => only[key] !== undefined);
  if (own && document.place) return having(document, { shape: [only, another] });
  const place = { ...(only.kind !== undefined && !own ? { center_mm: standard } : {}), ...document.place };
  return having(document, { shape: [{ ...only, ...place }, another], place: undefined });
}

/** Without one of several objects. Key frames keep the shapes that they name. */
export function without(document: ProjectDocument, object: number): ProjectDocument {
  const keyframe = document.keyframe?.map(({ shape, ...frame }) => {
    if (shape === undefined || shape === object + 1) return frame;
    return { ...frame, shape: shape > object + 1 ? shape - 1 : shape };
  });
  return having(document, { shape: (document.shape ?? []).filter((_, i) => i !== object), keyframe });
}

/**
 * How large a file's shape may be: fitted to a size, or as large as its numbers say in a unit, which most files leave open.
 * @param size  of the file, in its own numbers @return what is chosen by, and what it is called
 */
export function sizesOf(size: FileSize | undefined): [string, string][] {
  const widest = size ? Math.max(...size.extent) : undefined;
  const units = size?.own_unit ? ["mm"] : fileUnits;
  const as = (unit: string): string => (widest === undefined ? unit : `${size?.own_unit ? "as it says itself" : unit}: ${short(widest * (unitsMm[unit as keyof typeof unitsMm] ?? 1))} mm`);
  return [["", `not known: fitted to ${fittedMm} mm`], ...units.map((unit): [string, string] => [unit, as(unit)])];
}

/** The unit that a file's shape is as large as, "" when it is fitted. */
export function unitOf(document: ProjectDocument, shape: number): string {
  const entry = document.shape?.[shape];
  return entry?.size_mm !== undefined || document.place?.size_mm !== undefined ? "" : entry?.unit ?? "mm";
}

/** The file's shape as large as in a unit, or fitted. */
export function inUnit(document: ProjectDocument, shape: number, unit: string): ProjectDocument {
  const ofFile = having(document, { shape: (document.shape ?? []).map((each, i) => (i === shape ? clean({ ...each, unit: unit === "" || unit === "mm" ? undefined : unit, ...(document.place?.size_mm === undefined || unit === "" ? {} : { size_mm: undefined }) }) : each)) });
  const where = placed(document, shape);
  return moved(unit === "" || document.place?.size_mm === undefined ? ofFile : moved(ofFile, undefined, { size_mm: undefined }), where, { size_mm: unit === "" ? fittedMm : undefined });
}

/** One more object, after the others in place of beside them: they stay for a second, and so does it. */
export function withNext(document: ProjectDocument, kind: string, fewPoints: number): ProjectDocument {
  const more = withForm(document, kind);
  const shape = more.shape?.length ?? 1;
  const before = document.keyframe ?? [{ time_s: 0, ease: "step" }, { time_s: 1 }];
  const last = before.at(-1) ?? { time_s: 0 };
  const { shape: _, ...rest } = last;
  const keyframe: KeyFrame[] = [...before.slice(0, -1), { ...rest, shape, ease: "step" }, { ...rest, shape, time_s: Number((last.time_s + 1).toFixed(3)) }];
  return having(more, { keyframe, points: Math.min(document.points ?? 200, fewPoints) });
}

/** What several objects are called. */
export const nameOf = (shape: ShapeEntry, i: number): string => `${i + 1}: ${shape.kind ?? shape.file ?? "?"}`;

const isNamed = (i: number, frames: KeyFrame[] = []): boolean => frames.some(({ shape }) => shape === i + 1);

/** What a key frame may say that the object has become: itself, one of the objects, or a new one of a kind. */
export function formsFor({ shape = [], keyframe }: ProjectDocument, kinds: string[]): [string, string][] {
  const own = shape.map(nameOf).filter((_, i) => !isNamed(i, keyframe));
  const others = shape.flatMap((each, i): [string, string][] => (isNamed(i, keyframe) || own.length > 1 ? [[String(i + 1), nameOf(each, i)]] : []));
  return [["", `itself${shape.length > 1 ? ` (${own.join(", ")})` : ""}`], ...others, ...kinds.map((kind): [string, string] => [kind, `a new ${kind}`])];
}

/** One more object, which stands where the first one does, for a key frame to become. */
export function withForm(document: ProjectDocument, kind: string): ProjectDocument {
  const center_mm = document.place?.center_mm ?? document.shape?.[0]?.center_mm ?? standard;
  return withAnother(document, { kind, center_mm });
}

/** Without the objects that only key frames had, and none has any more: else they would join those that are there from the first on. */
export function withoutOldForms(document: ProjectDocument, before: KeyFrame[]): ProjectDocument {
  const old = (document.shape ?? []).map((_, i) => i).filter((i) => isNamed(i, before) && !isNamed(i, document.keyframe));
  return old.reduceRight(without, document);
}
