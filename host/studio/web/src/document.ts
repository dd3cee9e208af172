// SPDX-License-Identifier: Apache-2.0
// The document: a project file's keys and values, host/haptogram/verbs/README.md. It is never changed, only replaced,
// so that undo is a step back.
import { computed, signal } from "@preact/signals";

/** Lengths in millimetres, turns in degrees about x, y and z. */
export interface Place {
  scale?: number;
  size_mm?: number;
  rotate_deg?: number[];
  center_mm?: number[];
}

export interface ShapeEntry extends Place {
  kind?: string;
  file?: string;
  unit?: string;
  [key: string]: unknown;
}

/** A hand that feels an object by an algorithm. */
export interface HandTable {
  /** a file, or synthetic:SCRIPT:HEIGHT */
  recording: string;
  model?: string;
  frames_hz?: number;
  /** a built-in object, or a mesh file */
  object?: string;
  size_mm?: number;
  height_mm?: number;
  center_mm?: number[];
  rotate_deg?: number[];
  unit?: string;
  algorithm?: string;
  /** from 1; without it, the whole recording */
  frame?: number;
}

export interface ProjectDocument {
  format: string;
  array?: string;
  board?: string;
  points?: number;
  /** At most one of these three is there. */
  rate_hz?: number;
  speed_m_s?: number;
  frequency_hz?: number;
  even?: boolean;
  am?: string;
  /** passes, 0 for ever */
  loops?: number;
  /** of the most, above 0 and at most 1 */
  amplitude?: number;
  place?: Place;
  shape?: ShapeEntry[];
  /** in place of shapes */
  hand?: HandTable;
  [key: string]: unknown;
}

const mostSteps = 500;
const steps = signal<{ documents: ProjectDocument[]; at: number }>({ documents: [], at: -1 });

export const project = computed(() => steps.value.documents[steps.value.at]);
export const canUndo = computed(() => steps.value.at > 0);
export const canRedo = computed(() => steps.value.at < steps.value.documents.length - 1);

let underWay: string | undefined; // the gesture that made the last step

/** Replaces the document; the old one is a step back. All edits of one gesture, until it has ended, are one step. */
export function edit(changed: ProjectDocument, gesture?: string): void {
  const { documents, at } = steps.peek();
  if (JSON.stringify(documents[at]) === JSON.stringify(changed)) return;
  const kept = documents.slice(0, gesture !== undefined && gesture === underWay ? at : at + 1);
  underWay = gesture;
  const all = [...kept, changed].slice(-mostSteps);
  steps.value = { documents: all, at: all.length - 1 };
}

export function endGesture(): void {
  underWay = undefined;
}

export function undo(): void {
  underWay = undefined;
  if (canUndo.peek()) steps.value = { ...steps.peek(), at: steps.peek().at - 1 };
}

export function redo(): void {
  underWay = undefined;
  if (canRedo.peek()) steps.value = { ...steps.peek(), at: steps.peek().at + 1 };
}

/** A document with other values of some keys; undefined takes a key out. */
export function having(document: ProjectDocument, changes: Partial<Record<keyof ProjectDocument, unknown>>): ProjectDocument {
  const all = Object.entries({ ...document, ...changes }).filter(([, value]) => value !== undefined);
  return Object.fromEntries(all) as ProjectDocument;
}
