// SPDX-License-Identifier: Apache-2.0
// The link to the engine, which computes: what is asked of it and what it answers. engine/messages.hpp has the table. The program is one
// engine (server.ts), the same libraries as WebAssembly in a Worker are the other (in_page.ts).
import type { ProjectDocument } from "./document";

export type Point = [number, number, number];

/** What `haptogram compile --json` prints. */
export interface Numbers {
  clipped: number;
  tour_mm: number;
  rate_hz: number;
  shortest_dwell_s: number;
  formation_s: number;
  formation_with_ring_up_s: number;
  most_points: number;
  most_points_with_ring_up: number;
  pressure_left_least: number;
  image_bytes: number;
}

export interface ArrayOf {
  name: string;
  radius_mm: number;
  elements: Point[];
}

export interface Scene {
  name: string;
  array: ArrayOf;
  foci: Point[];
  /** records in the order of play: which it is, its index on the board, where its focus is, and when it plays */
  tour: { record: number; index: number; at: Point; from_s: number; dwell_s: number; amplitude: number }[];
  pass_s: number;
  channels: number;
  numbers: Numbers;
  image_sha256: string;
  findings: Finding[];
  /** parts of the sequence that the design's triggers start */
  triggers: Trigger[];
}

export interface Trigger {
  first: number;
  length: number;
  loops: number;
  pin: boolean;
}

/** What is not as a user may expect, where, and which edits of the document mend it. */
export interface Finding {
  kind: string;
  message: string;
  records: number[];
  remedies: Remedy[];
}

/** How large a file's shape is along x, y and z in the file's own numbers; in millimetres, if it says its unit. */
export interface FileSize {
  name: string;
  extent: Point;
  own_unit: boolean;
}

/** An edit: keys of the document with other values, null to leave one out; of a table, the keys that change. */
export interface Remedy {
  label: string;
  changes: Record<string, unknown>;
}

export interface Analysis {
  level: { calibrated: boolean; source_pa_m: number; note: string };
  foci: { record: number; radiation_pa: number; width_mm: number; depth_mm: number; side_lobe: number; force_mn: number }[];
  /** those that the verdict is of: decibels over what a palm just feels, expected and with what is not known; null: nothing at all */
  places: { at: Point; over_db: number | null; least_db: number | null; most_db: number | null }[];
  at_300_mm_db: number;
  /** that is recommended for ears */
  most_at_300_mm_db: number;
  /** a sentence that begins with "felt:", "perhaps:" or "not felt:", as the program says it */
  verdict: string;
  findings: Finding[];
}

/** What each channel does while a record plays. */
export interface Drives {
  record: number;
  index: number;
  phases_deg: number[];
  amplitudes: number[];
}

/** What became of a frame of a hand, as `haptogram render --report --json` prints it. */
export interface FrameReport {
  frame: number;
  time_s: number;
  lines: number;
  foci: number;
  length_mm: number;
  draw_hz: number;
  focus_pa: number;
  width_mm: number;
  strength_pa: number;
  tilt: number;
  weak: number;
  out_of_reach: number;
  why?: string;
  lines_missed: number;
  compute_ms: number;
}

/** A frame of a hand in numbers. */
export interface HandFrame {
  /** what was drawn of the object: the page says it back, and is not sent the same again */
  drawn: string;
  array: ArrayOf;
  frame: number;
  frames: number;
  time_s: number;
  end_s: number;
  pass_s: number;
  lines: { kind: string; length_mm: number }[];
  report: FrameReport | null;
  warnings: string[];
  /** why there are no lines */
  nothing: Failure | null;
}

/** A frame of a hand for drawing, millimetres: corners of triangles, ends of line segments, focal points. */
export interface DrawnHand {
  n: number;
  skin: Float32Array<ArrayBuffer>;
  felt: Float32Array<ArrayBuffer>;
  weak: Float32Array<ArrayBuffer>;
  foci: Float32Array<ArrayBuffer>;
}

/** A hand, millimetres, its palm in the origin: ends of line segments, and corners of the skin's triangles, coordinates in a row. */
export interface Outline {
  segments: Point[];
  skin: number[];
}

/** A rendered path as a file, and what became of its frames. */
export interface RenderedPath {
  text: string;
  frames: FrameReport[];
  warnings: string[];
}

/** What `haptogram simulate` reports. */
export interface PinReport {
  pulses: number;
  pulses_equal_to_image: number;
  contract_violations: number;
  violations: string[];
  points_off: number;
  least_pressure_kept: number;
  worst_focus_error_mm: number;
}

/** Pulses at the pins, counted in clocks. */
export interface PulseWindow {
  index: number;
  clock_hz: number;
  from_clk: number;
  to_clk: number;
  /** channel, rise, fall, and which record played */
  pulses: [number, number, number, number][];
}

export interface Failure {
  where: string;
  message: string;
  /** settings that could mend it */
  remedies?: string[];
  /** of a design: edits that mend it, each of which was tried; they come later */
  ways?: Remedy[];
  /** It is not of the document shown, so it stays when the next scene has come. */
  lasts?: boolean;
}

export interface Device {
  t: "device";
  connection: "none" | "connecting" | "connected" | "lost" | "lent";
  /** What has a board of its own, or this one, meanwhile. */
  guest?: "live session" | "study";
  port?: string;
  baud?: number;
  intensity?: number;
  identity?: { name: string; channels: number; records: number };
  /** whoever has them on, `outputs` tells; the rest is of the connected board */
  status?: { outputs: "on" | "off" | "unknown"; mode?: string; index?: number };
  trouble?: string;
}

/** The studies there are: shipped ones by name, and the protocols in the project's folder by file. */
export interface Studies {
  folder: string;
  protocols: Record<string, { title: string; source: string; trials: number; participants: number; playable: boolean } | { error: string }>;
}

/** What the runner of a study wants to be shown; extras/studies/README.md has the table. */
export type StudyShown =
  | { show: "begun"; n: number }
  | { show: "tell"; text: string }
  | { show: "ready"; number: number; trial: number; of: number; presented: string }
  | StudyQuestion
  | { show: "wrong"; number: number; text: string }
  | { show: "late" }
  | { show: "rest"; seconds: number }
  | { show: "note"; text: string }
  | { show: "ended"; code: number | null };

export interface StudyQuestion {
  show: "ask";
  number: number;
  trial: number;
  of: number;
  text: string;
  kind: "choice" | "yes-no" | "scale" | "number" | "text";
  keys: [string, string][];
  from: number | null;
  to: number | null;
  whole: boolean;
  limit_s: number | null;
}

/** A hand as a tracker sees it: of thumb to pinkie four joints each, from the knuckle. */
export interface LiveHand {
  palm_mm: Point;
  fingers_mm: Point[][];
}

/** An object as it stands at the time of a scene. */
export interface LiveObject {
  name: string;
  /** its kind, or its mesh file */
  object: string;
  size_mm: number;
  height_mm?: number;
  center_mm: Point;
  /** axes of its own frame */
  x: Point;
  z: Point;
}

/** What a live session sees and plays; extras/live/README.md has the table. */
export interface LiveScene {
  scene: 2;
  shot: number;
  time_s: number;
  fingers: number;
  hands: LiveHand[];
  objects: LiveObject[];
  contacts_mm: Point[][];
  /** place and amplitude */
  foci: [number, number, number, number][];
  compute_ms: number;
  latency_ms: number | null;
}

export type LiveShown = { show: "begun"; n: number } | LiveScene | { show: "note"; text: string } | { show: "ended"; code: number | null };

export interface Hello {
  version: string;
  project: string;
  document: ProjectDocument;
  primitives: string[];
  /** objects that a hand can touch */
  touched: string[];
  algorithms: { letter: string; about: string }[];
  arrays: string[];
  /** shipped ones: the array of each, and what the file of its bitstream is called */
  boards: { name: string; array: string; bitstream: string }[];
  ports: { port: string; name: string }[];
  most_file_bytes: number;
}

/** A slice of the field as the server sent it. */
export interface SliceData {
  n: number;
  width: number;
  height: number;
  least: number;
  greatest: number;
  /** radiation pressure on skin over mean square pressure, 1/Pa */
  skinPerSquare: number;
  tookMs: number;
  /** the first characters of the name of the scene that it is of */
  scene: string;
  /** mean square pressure, Pa² */
  values: Float32Array<ArrayBuffer>;
}

/** An object for drawing, millimetres. */
export interface Drawn {
  n: number;
  vertices: Float32Array<ArrayBuffer>;
  /** Numbers of vertices, three each. */
  triangles: Uint32Array<ArrayBuffer>;
  segments: Float32Array<ArrayBuffer>;
  points: Float32Array<ArrayBuffer>;
  allTriangles: number;
  allPoints: number;
}

export type Event =
  | { t: "open" }
  | { t: "lost" }
  | { t: "refused" }
  /** It does not answer; it does again. */
  | { t: "silent" }
  | { t: "answers" }
  | { t: "beat" }
  | { t: "scene"; n: number; scene: Scene }
  | { t: "slice"; slice: SliceData }
  | ({ t: "drives"; n: number } & Drives)
  | ({ t: "analysis"; n: number } & Analysis)
  | { t: "pins"; n: number; report: PinReport }
  | ({ t: "pulses"; n: number } & PulseWindow)
  | { t: "object"; object: Drawn }
  | ({ t: "hand"; n: number } & HandFrame)
  | { t: "skin"; skin: DrawnHand }
  | ({ t: "path"; n: number } & RenderedPath)
  | Device
  | { t: "progress"; work: string; number: number; stage: string; fraction?: number; seconds?: number; /** that plays */ scene?: string; /** what is wrong with a line of the pipe */ line?: string }
  | { t: "done"; work: string; number: number; report?: { frames: number; frames_written: number } }
  | { t: "stopped"; work: string; number: number }
  | { t: "sizes"; n: number; sizes: FileSize[] }
  | { t: "ways"; n: number; ways: Remedy[] }
  | { t: "failed"; n?: number; work?: string; number?: number; error: Failure }
  | { t: "error"; error: Failure }
  | ({ t: "studies"; n: number } & Studies)
  | { t: "study"; shown: StudyShown }
  | { t: "live"; shown: LiveShown }
  | { t: "off"; n: number; confirmed: boolean }
  | { t: "notice"; message: string };

export function readSlice(bytes: ArrayBuffer): SliceData {
  const view = new DataView(bytes);
  const width = view.getUint32(8, true);
  const height = view.getUint32(12, true);
  return {
    n: view.getUint32(4, true),
    width,
    height,
    least: view.getFloat32(16, true),
    greatest: view.getFloat32(20, true),
    skinPerSquare: view.getFloat32(24, true),
    tookMs: view.getFloat32(28, true),
    scene: new TextDecoder().decode(new Uint8Array(bytes, 36, 28)),
    values: new Float32Array(bytes, 64, width * height),
  };
}

export function readObject(bytes: ArrayBuffer): Drawn {
  const view = new DataView(bytes);
  const [vertices, triangles, segments, points] = [8, 12, 16, 20].map((at) => view.getUint32(at, true)) as [number, number, number, number];
  const corners = 64 + 12 * vertices, ends = corners + 12 * triangles;
  return {
    n: view.getUint32(4, true),
    vertices: new Float32Array(bytes, 64, 3 * vertices),
    triangles: new Uint32Array(bytes, corners, 3 * triangles),
    segments: new Float32Array(bytes, ends, 6 * segments),
    points: new Float32Array(bytes, ends + 24 * segments, 3 * points),
    allTriangles: view.getUint32(24, true),
    allPoints: view.getUint32(28, true),
  };
}

export function readHand(bytes: ArrayBuffer): DrawnHand {
  const view = new DataView(bytes);
  let at = 64;
  const next = (count: number, each: number): Float32Array<ArrayBuffer> => {
    const found = new Float32Array(bytes, at, count * each);
    at += found.byteLength;
    return found;
  };
  const count = (place: number): number => view.getUint32(place, true);
  return { n: count(4), skin: next(count(8), 9), felt: next(count(12), 6), weak: next(count(16), 6), foci: next(count(20), 3) };
}

/** What a scene can be taken away as, and the files' names. */
export const filesOfScene = {
  hex: "image.hex",
  manifest: "image.json",
  project: "project.toml",
  primary: "image.primary.mem",
  sequence: "image.sequence.mem",
  report: "report.html",
};
export type FileOfScene = keyof typeof filesOfScene;

/** What is asked; engine/messages.hpp has the members of each. */
export interface Message {
  t: string;
  [member: string]: unknown;
}

export abstract class Link {
  private n = 0;
  protected readonly listeners: ((event: Event) => void)[] = [];

  /** By what it reaches boards: by a program, which also has all else that a page alone has not, by the browser's serial ports, or not at all. */
  abstract readonly boards: "program" | "serial" | "none";
  /** Whether the engine can be reached now. */
  abstract get open(): boolean;
  /** Outputs off. */
  abstract stop(): void;
  /** Hands a message to an engine that is open. */
  protected abstract post(message: Message & { n: number }): void;
  /** Asks for a document or a file. @throws Error with the engine's words */
  protected abstract request(method: "GET" | "POST", target: string, body?: Blob): Promise<Blob>;

  listen(listener: (event: Event) => void): void {
    this.listeners.push(listener);
  }

  /** Sends a message and returns its number, which the answer has, too. */
  send(message: Message): number {
    this.n += 1;
    if (this.open) this.post({ ...message, n: this.n });
    return this.n;
  }

  async hello(): Promise<Hello> {
    return await this.json<Hello>("GET", "/api/hello");
  }

  /** Sends a file; the engine reads it when a document names it. */
  async sendFile(file: File): Promise<void> {
    await this.request("POST", `/api/files?name=${encodeURIComponent(file.name)}`, file);
  }

  /** A file that was sent, or that the project has. */
  async file(name: string): Promise<Blob> {
    return await this.request("GET", `/api/files?name=${encodeURIComponent(name)}`);
  }

  async outline(): Promise<Outline> {
    return await this.json("GET", "/api/outline");
  }

  /** A project file's text as a document. */
  async readProject(text: string): Promise<{ document: ProjectDocument; files: string[] }> {
    return await this.json("POST", "/api/document", new Blob([text]));
  }

  /** A document as a project file's text, and the files that it names. */
  async writeProject(document: ProjectDocument): Promise<{ text: string; files: string[] }> {
    return await this.json("POST", "/api/project", new Blob([JSON.stringify(document)]));
  }

  /** @param name  of the design, for the report */
  async take(scene: string, as: FileOfScene | "methods", name = ""): Promise<Blob> {
    return await this.request("GET", as === "report" ? `/api/report?scene=${scene}&name=${encodeURIComponent(name)}` : `/api/take?scene=${scene}&as=${as}`);
  }

  /** The scene's image in its board's bitstream; with autostart it plays at power-up. */
  async bitstream(scene: string, autostart: boolean): Promise<Blob> {
    return await this.request("GET", `/api/bitstream?scene=${scene}&autostart=${autostart ? 1 : 0}`);
  }

  /** The field on a plane as a file; the query's members are those of ../../README.md. */
  async field(query: Record<string, string>): Promise<Blob> {
    return await this.request("GET", `/api/field?${new URLSearchParams(query)}`);
  }

  protected receive(data: string | ArrayBuffer): void {
    if (typeof data === "string") return this.tell(JSON.parse(data) as Event);
    const magic = new TextDecoder().decode(new Uint8Array(data, 0, 4));
    if (magic === "HSL1") this.tell({ t: "slice", slice: readSlice(data) });
    else if (magic === "HHA1") this.tell({ t: "skin", skin: readHand(data) });
    else this.tell({ t: "object", object: readObject(data) });
  }

  protected tell(event: Event): void {
    for (const listener of [...this.listeners]) listener(event);
  }

  private async json<Answer>(method: "GET" | "POST", target: string, body?: Blob): Promise<Answer> {
    return JSON.parse(await (await this.request(method, target, body)).text()) as Answer;
  }
}

/** What an engine says is wrong, as it stands in its answer. */
export const wrongIn = (answer: string): Error => new Error((JSON.parse(answer) as { error: { message: string } }).error.message);
