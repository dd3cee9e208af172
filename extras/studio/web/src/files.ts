// SPDX-License-Identifier: Apache-2.0
// Opens and saves designs: bundles, projects with their files, shapes, and what the browser kept.
import { isProject, pack, type Parts, projectName, unpack } from "./bundle";
import { designName, edit, having, history, markSaved, open, project } from "./document";
import { kindOf, withFiles } from "./dropping";
import { type Design, filesOf, offered } from "./keeper";
import type { Session } from "./session";
import type { Link, Point } from "./link";
import { state } from "./state";
import { pathFile } from "./stroke";

const bundle = ".haptogram";
/** Another for every line: the server may have files of other pages, and of the folder that it was started in. */
const pathName = (): string => `drawn-${[...crypto.getRandomValues(new Uint8Array(4))].map((byte) => byte.toString(16).padStart(2, "0")).join("")}.csv`;
const stem = (name: string): string => name.replace(/^.*\//, "").replace(/\.[^.]*$/, "");

export class Files {
  constructor(
    private readonly session: Session,
    private readonly link: Link,
  ) {}

  /** Files that were dropped or chosen: a design, or what goes into the one that is open. */
  async take(files: File[]): Promise<void> {
    state.failure.value = undefined;
    const most = state.hello.value?.most_file_bytes ?? 0;
    for (const { name, size } of files) if (size > most) throw new Error(`${name}: ${size} bytes are more than the ${most} that the studio takes; “haptogram compile” takes files of any size`);
    const packed = files.find(({ name }) => name.endsWith(bundle));
    if (packed) return await this.openParts(unpack(packed.name, new Uint8Array(await packed.arrayBuffer()), most), stem(packed.name));
    for (const file of files) {
      if (!file.name.endsWith(".toml")) continue;
      const text = await file.text();
      if (isProject(text)) return await this.openParts({ text, files: files.filter((each) => each !== file) }, file.name === projectName ? "project" : stem(file.name));
    }
    const [first] = files;
    if (files.length === 1 && first?.name.endsWith(".adaptics") && (await this.takeFrames(first))) return;
    const named = JSON.stringify(project.peek() ?? {});
    const replaced = new Map(await Promise.all(files.map(async ({ name }) => [name, named.includes(JSON.stringify(name)) ? await this.fileOf(name).catch(() => undefined) : this.session.sent.get(name)] as const)));
    await this.send(files);
    const before = project.value;
    if (!before || files.length === 0) return;
    state.chosen.value = undefined;
    const kinds = await Promise.all(files.map(kindOf));
    const steps = history.peek();
    edit(withFiles(project.peek() ?? before, kinds));
    this.session.hasDropped(replaced, steps !== history.peek());
  }

  /** A pattern's key frames become the design's, where they are what a shape's can say; else the page tells why not. @return whether they are */
  private async takeFrames(pattern: File): Promise<boolean> {
    const { array, board } = project.peek() ?? {};
    state.whyPath.value = undefined;
    try {
      const { document } = await this.link.readProject(await pattern.text());
      state.chosen.value = undefined;
      state.keyFrame.value = 0;
      edit(having(document, { array, board }));
      return true;
    } catch (error) {
      state.whyPath.value = { file: pattern.name, why: (error instanceof Error ? error.message : String(error)).replace(/^pattern: /, "") };
      return false;
    }
  }

  /** Places that are passed at equal times become the design's path. @return the file's name */
  async takePath(places: Point[], seconds: number): Promise<string> {
    const name = pathName();
    await this.send([new File([pathFile(places, seconds)], name)]);
    const { format, array, board, am, am_law, amplitude, loops, live } = project.peek() ?? { format: "" };
    edit(having({ format }, { array, board, am, am_law, amplitude, loops, live, path: name }));
    return name;
  }

  /** A bundle that came with the page. */
  async openShipped(name: string, title: string): Promise<void> {
    const response = await fetch(`${name}${bundle}`);
    if (!response.ok) throw new Error(`${name}${bundle}: it did not come with this page`);
    const bytes = new Uint8Array(await response.arrayBuffer());
    const { array, board } = project.peek() ?? {};
    await this.openParts(unpack(name, bytes, bytes.length * 100), title, { array, board });
  }

  /** @param instrument  what the design is for, if it does not say so itself */
  private async openParts({ text, files }: Parts, name: string, instrument: { array?: string | undefined; board?: string | undefined } = {}): Promise<void> {
    const { document } = await this.link.readProject(text);
    await this.send(files);
    state.chosen.value = undefined;
    const kept = Object.fromEntries(Object.entries(instrument).filter(([, value]) => value !== undefined));
    open({ ...kept, ...document }, name);
    this.session.ask();
  }

  /** One that the browser kept, with all its steps. */
  async restore(design: Design): Promise<void> {
    if (offered.peek()?.id === design.id) offered.value = undefined;
    await this.send(await filesOf(design));
    state.chosen.value = undefined;
    history.value = design.history;
    if (design.saved) markSaved();
    this.session.ask();
  }

  /** The design as a bundle. */
  async saved(): Promise<{ blob: Blob; name: string }> {
    const document = project.peek();
    if (!document) throw new Error("There is nothing to save yet.");
    const { text, files } = await this.link.writeProject(document);
    const all = await Promise.all(files.map(async (name) => await this.fileOf(name)));
    const blob = await pack({ text, files: all });
    markSaved();
    return { blob, name: `${designName.peek()}${bundle}` };
  }

  /** One that was sent, or that the project has. */
  private async fileOf(name: string): Promise<File> {
    return this.session.sent.get(name) ?? new File([await this.link.file(name)], name);
  }

  private async send(files: File[]): Promise<void> {
    for (const file of files) {
      await this.link.sendFile(file);
      this.session.sent.set(file.name, file);
    }
  }
}

/** The design that the server began with, before anything else is. */
export function openFirst(document: Parameters<typeof open>[0], name: string): void {
  if (project.peek() === undefined) open(document, stem(name));
}

