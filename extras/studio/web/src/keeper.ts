// SPDX-License-Identifier: Apache-2.0
// What the browser keeps of designs, so that no work is lost: each with its steps and files, after every edit.
import { effect, signal } from "@preact/signals";
import { delMany, entries, get, set } from "idb-keyval";
import { canUndo, type History, history, isSaved } from "./document";

/** A design as the browser keeps it. */
export interface Design {
  id: string;
  name: string;
  when: number;
  history: History;
  /** whether a file has it, too */
  saved: boolean;
}

const mostDesigns = 12; // that files have, too
const mostUnsaved = 50;
const mostSteps = 100; // of each
const pause = 300; // ms after an edit
const tab = "design"; // what a tab was working on when it was loaded again
const left = "left"; // what this tab was offered and did not want

const designKey = (id: string): string => `design ${id}`;
const filesKey = (id: string): string => `files ${id}`; // apart, so that an edit need not write them again

/** Newest first. */
export const designs = signal<Design[]>([]);
/** One that no file has, from another time: it is offered. */
export const offered = signal<Design | undefined>(undefined);
/** When the design was kept last. */
export const keptAt = signal<number | undefined>(undefined);

/** The design that this tab had before it was loaded again; another one that was not saved is offered. */
export async function begin(files: () => File[], tell: (error: unknown) => void): Promise<Design | undefined> {
  const before = sessionStorage.getItem(tab);
  let found: Design | undefined;
  try {
    found = before ? await get<Design>(designKey(before)) : undefined;
    await list();
    offered.value = designs.peek().find(({ id, saved }) => !saved && id !== before && id !== sessionStorage.getItem(left));
  } catch (error) {
    tell(new Error(`The browser keeps nothing of this page, so save your work as files: ${String(error)}`));
    return undefined;
  }
  let timer: ReturnType<typeof setTimeout> | undefined;
  let waits: { id: string | undefined; keep: () => void } | undefined;
  const flush = (): void => {
    clearTimeout(timer);
    waits?.keep();
    waits = undefined;
  };
  effect(() => {
    const now = history.value, saved = isSaved.value;
    const id = now.steps[now.at]?.id;
    if (waits && waits.id !== id) flush(); // before another design takes its place
    clearTimeout(timer);
    waits = undefined;
    if (!canUndo.value) return;
    waits = { id, keep: () => void keep(now, saved, files()).catch((error: unknown) => tell(noRoom(error))) };
    timer = setTimeout(flush, pause);
  });
  addEventListener("pagehide", flush);
  return found;
}

const noRoom = (error: unknown): unknown =>
  error instanceof DOMException && error.name === "QuotaExceededError" ? new Error("The browser has no room left to keep this design: save it as a bundle, or it is lost with this page.") : error;

/** What was offered stays where it is, and is not offered to this tab again. */
export function leave(): void {
  sessionStorage.setItem(left, offered.peek()?.id ?? "");
  offered.value = undefined;
}

/** What a design has beside its steps. */
export const filesOf = async ({ id }: Design): Promise<File[]> => (await get<File[]>(filesKey(id))) ?? [];

let keptFiles: { id: string; files: File[] } = { id: "", files: [] };

async function keep({ steps, at }: History, saved: boolean, files: File[]): Promise<void> {
  const now = steps[at];
  if (!now) return;
  const from = Math.max(0, Math.min(at, steps.length - mostSteps));
  const design: Design = { id: now.id, name: now.name, when: Date.now(), history: { steps: steps.slice(from, from + mostSteps), at: at - from }, saved };
  if (keptFiles.id !== now.id || keptFiles.files.length !== files.length || keptFiles.files.some((file, i) => file !== files[i])) await set(filesKey(now.id), files);
  keptFiles = { id: now.id, files };
  await set(designKey(now.id), design);
  sessionStorage.setItem(tab, now.id);
  keptAt.value = design.when;
  await list();
}

async function list(): Promise<void> {
  const all = (await entries<string, Design>()).filter(([key]) => key.startsWith(designKey(""))).map(([, design]) => design).sort((a, b) => b.when - a.when);
  // What no file has outlives what was looked at behind it.
  const kept = new Set([...all.filter(({ saved }) => saved).slice(0, mostDesigns), ...all.filter(({ saved }) => !saved).slice(0, mostUnsaved)]);
  await delMany(all.filter((design) => !kept.has(design)).flatMap(({ id }) => [designKey(id), filesKey(id)]));
  designs.value = all.filter((design) => kept.has(design));
}
