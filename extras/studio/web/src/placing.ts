// SPDX-License-Identifier: Apache-2.0
// Where objects are: a document places the whole, and each of its shapes before that.
import { having, type KeyFrame, type Place, type ProjectDocument, type ShapeEntry } from "./document";
import type { Point } from "./link";

const standard: Point = [0, 0, 130]; // of built-in shapes, none of which has a centre
export const touchedAt: Point = [0, 0, 200]; // of an object that a hand feels
const keys = ["scale", "size_mm", "rotate_deg", "center_mm"] as const;

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
