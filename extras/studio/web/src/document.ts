// SPDX-License-Identifier: Apache-2.0
// The document: a project file's keys and values, host/haptogram/verbs/README.md. It is never changed, only replaced,
// so that undo is a step back. What is shown of it has steps in the same history.
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

/** Where the shapes are at a time, from where they were placed on. */
export interface KeyFrame {
  time_s: number;
  move_mm?: number[];
  rotate_deg?: number[];
  scale?: number;
  /** of the strength, 0 to 1 */
  amplitude?: number;
  /** how often the strength rises and falls */
  am_hz?: number;
  ease?: "linear" | "smooth" | "step";
  mark?: boolean;
  /** which of the shapes they have become, from 1; without it, those that no key frame names */
  shape?: number;
}

/** What starts a part of the pass. */
export interface TriggerTable {
  /** "pin", "region", "key:" and a character, or "line:" and a word */
  on: string;
  /** of a region, a ball */
  center_mm?: number[];
  size_mm?: number;
  from_s?: number;
  to_s?: number;
  /** passes, 0 until another trigger */
  loops?: number;
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
  /** the strongest side and the share of the amplitude at the other, such as "left:0.5" */
  fade?: string;
  place?: Place;
  shape?: ShapeEntry[];
  /** between which the shapes move */
  keyframe?: KeyFrame[];
  trigger?: TriggerTable[];
  /** a file in place of shapes, with places and times of its own */
  path?: string;
  /** in place of shapes */
  hand?: HandTable;
  [key: string]: unknown;
}

/** What is shown of a design: where the plane is, and which focal point is marked; null: none. */
export interface Sight {
  plane?: { orientation: "xy" | "xz" | "yz"; middle: [number, number, number]; turn: number[]; scale: number[] };
  at?: number | null;
}

/** A document and the design that it is a state of. */
export interface Step {
  document: ProjectDocument;
  /** of the design, without an ending */
  name: string;
  /** of what the browser keeps of the design */
  id: string;
  /** of a step that changed what is shown, and not the document */
  sight?: { before: Sight; after: Sight };
}
/** What can be undone and done again. */
export interface History {
  steps: Step[];
  at: number;
}

const mostSteps = 500;
export const history = signal<History>({ steps: [], at: -1 });

/** The step that is shown. */
export const present = computed(() => history.value.steps[history.value.at]);
export const project = computed(() => present.value?.document);
export const designName = computed(() => present.value?.name ?? "");
export const canUndo = computed(() => history.value.at > 0);
export const canRedo = computed(() => history.value.at < history.value.steps.length - 1);

/** What a file has of the design: what differs from it would be lost with the browser. */
const saved = signal("");
const asText = (step: Step | undefined): string => JSON.stringify([step?.name, step?.document]);
export const isSaved = computed(() => !present.value || saved.value === asText(present.value));
export const markSaved = (): void => void (saved.value = asText(present.peek()));

let underWay: string | undefined; // the gesture that made the last step
let lastLook = 0; // when what is shown was changed last, ms
const pause = 1000; // ms, between two looks that are two steps
let showSight: (sight: Sight) => void = () => undefined;
/** Who shows what undo brings back of the view. */
export const showSightBy = (shows: (sight: Sight) => void): void => void (showSight = shows);

/** Replaces the document; the old one is a step back. All edits of one gesture, until it has ended, are one step. */
export function edit(changed: ProjectDocument, gesture?: string): void {
  const now = present.peek();
  if (now && JSON.stringify(now.document) !== JSON.stringify(changed)) add({ document: changed, name: now.name, id: now.id }, gesture);
}

function add(step: Step, gesture?: string): void {
  const { steps, at } = history.peek();
  const kept = steps.slice(0, gesture !== undefined && gesture === underWay ? at : at + 1);
  underWay = gesture;
  const all = [...kept, step].slice(-mostSteps);
  history.value = { steps: all, at: all.length - 1 };
}

/** Another design takes the place of this one, which is a step back. It is as a file has it. */
export function open(document: ProjectDocument, name: string): void {
  add({ document, name, id: crypto.randomUUID() });
  markSaved();
}

export function rename(name: string): void {
  const now = present.peek();
  if (now && name !== "" && name !== now.name) add({ document: now.document, name, id: now.id });
}

/** Something else is shown of the same document, which is a step as an edit is one. What follows at once is the same movement. */
export function looked(before: Sight, after: Sight): void {
  const now = present.peek();
  if (!now || JSON.stringify(before) === JSON.stringify(after)) return;
  const gesture = `look ${Object.keys(after).join()}`;
  const time = performance.now();
  const goesOn = now.sight !== undefined && underWay === gesture && time - lastLook < pause;
  lastLook = time;
  if (!goesOn) underWay = undefined;
  add({ document: now.document, name: now.name, id: now.id, sight: { before: goesOn ? now.sight?.before ?? before : before, after } }, gesture);
}

export function endGesture(): void {
  underWay = undefined;
}

export function undo(): void {
  underWay = undefined;
  if (!canUndo.peek()) return;
  const taken = present.peek();
  history.value = { ...history.peek(), at: history.peek().at - 1 };
  if (taken?.sight) showSight(taken.sight.before);
}

/** The last step was none. */
export function takeBack(): void {
  underWay = undefined;
  const { steps, at } = history.peek();
  if (at > 0) history.value = { steps: steps.slice(0, at), at: at - 1 };
}

export function redo(): void {
  underWay = undefined;
  if (!canRedo.peek()) return;
  history.value = { ...history.peek(), at: history.peek().at + 1 };
  const made = present.peek();
  if (made?.sight) showSight(made.sight.after);
}

/** A document with other values of some keys; undefined takes a key out. */
export function having(document: ProjectDocument, changes: Partial<Record<keyof ProjectDocument, unknown>>): ProjectDocument {
  const all = Object.entries({ ...document, ...changes }).filter(([, value]) => value !== undefined);
  return Object.fromEntries(all) as ProjectDocument;
}
