// SPDX-License-Identifier: Apache-2.0
// What the page knows, as the server told it, and what its panels can ask for.
import { computed, signal } from "@preact/signals";
import type { ProjectDocument } from "./document";
import type { Design } from "./keeper";
import { headOf, wordsOf } from "./labels";
import type { Analysis, Device, Drawn, Drives, Event, Failure, FileOfScene, FileSize, FrameReport, HandFrame, Hello, Link, LiveScene, PinReport, Point, PulseWindow, Scene, SliceData, Studies, StudyQuestion } from "./link";
import type { Edges, Orientation } from "./view";

/** What a user is at: each step shows what it needs. */
export const stepNames = ["Make", "See", "Play"] as const;
export type StepName = (typeof stepNames)[number];

/** What the handles in the view do. */
export type Handles = `${"plane" | "object"} ${"move" | "turn"}`;

/** A scene that was put aside to be compared with others. */
export interface Kept {
  document: ProjectDocument;
  scene: Scene;
  drawn: Drawn | undefined;
}

/** Values along a line, mean square pressure in Pa²: between two points, or of two scenes. */
export interface Profile {
  from: Point;
  to: Point;
  skinPerSquare: number;
  values: Float32Array;
}

/** What is chosen of a session before it begins. */
export interface StudyChoice {
  protocol: string;
  participant: number;
  seed: number;
  results: string;
  /** "": nothing is played; "studio": the board that the studio is connected to */
  port: string;
}

/** A participant's session: what its runner has shown last. */
export interface StudySession {
  of: StudyChoice;
  now:
    | { show: "starting" | "working" }
    | { show: "ready"; number: number; presented: string }
    | StudyQuestion
    | { show: "rest"; until: number }
    | { show: "ended"; code: number | null };
  /** what was told since the last answer */
  texts: string[];
  /** what the runner says beside, as in a terminal */
  notes: string[];
  wrong: string;
  trial: number;
  trials: number;
}

/** A live session that runs or has ended. */
export interface LiveSession {
  now: "starting" | "running" | "ended";
  /** with which it ended; null: it was cut off */
  code: number | null;
  /** what it says beside, as in a terminal */
  notes: string[];
  /** scenes that were shown, and the last of them */
  shots: number;
  last?: LiveScene;
  /** of the last paths, ms */
  latencies: number[];
}

export const state = {
  hello: signal<Hello | undefined>(undefined),
  scene: signal<Scene | undefined>(undefined),
  step: signal<StepName>("Make"),
  /** Which panels are folded away. In a narrow window those at the sides lie over the view. */
  folded: signal({ left: innerWidth < 1100, right: innerWidth < 641, time: innerHeight < 640, feel: innerWidth < 1100 || innerHeight < 800 }),
  /** Whether the three hints of a first visit are shown. */
  hints: signal(localStorage.getItem("hinted") === null),
  /** Whether the outputs are to go on as soon as the board that was asked for is there. */
  playsNext: signal(false),
  /** Where the hand is to come from once the board that was asked for is there, as Actions.live() has it. */
  livesNext: signal<string | undefined>(undefined),
  live: signal<LiveSession | undefined>(undefined),
  /** The entry of the tour that the board plays. */
  playsPoint: signal<number | undefined>(undefined),
  /** The scene that the board plays, whichever page began it, as the engine tells; "": none. */
  played: signal(""),
  /** Whether nothing of the object is in the view. */
  outside: signal(false),
  /** Millimetres of one pixel in the middle of the view. */
  mmPerPixel: signal(0),
  /** Whether the engine is there, answers nothing, or has gone. */
  engine: signal<"here" | "silent" | "gone">("here"),
  /** Whether STOP was pressed and has not been answered. */
  stopping: signal(false),
  /** Whether the scene shown is that of the document shown. */
  current: signal(false),
  /** How large the shapes are that files have, by the files' names. */
  sizes: signal<Record<string, FileSize>>({}),
  /** Why the document shown has no scene. */
  refused: signal<Failure | undefined>(undefined),
  object: signal<Drawn | undefined>(undefined),
  slice: signal<SliceData | undefined>(undefined),
  latencyMs: signal(0),
  failure: signal<Failure | undefined>(undefined),
  device: signal<Device>({ t: "device", connection: "none" }),
  work: signal<Event | undefined>(undefined),
  /** A named pipe whose lines fire triggers while it plays; "": none. */
  lines: signal(""),
  /** What is wrong with the last of them that said nothing. */
  wrongLine: signal<string | undefined>(undefined),
  middle: signal<Point>([0, 0, 130]),
  orientation: signal<Orientation>("xy"),
  handles: signal<Handles>("plane move"),
  edges: signal<Edges>({ origin: [-80, -80, 130], u: [160, 0, 0], v: [0, 160, 0] }),
  /** Whether a slice is still to come. */
  slicing: signal(false),
  /** Of files of the field. */
  stepMm: signal(1),
  writing: signal(false),
  /** Place in the tour that the timeline marks. */
  at: signal<number | undefined>(undefined),
  /** Drives of the marked record. */
  drives: signal<Drives | undefined>(undefined),
  /** Whether the timeline runs, and how much slower than the board it does. */
  running: signal(false),
  slower: signal(100),
  /** Whether the field is that of the marked focal point alone. */
  alone: signal(false),
  /** Whether the field is what one focus could have at each point. */
  reach: signal(false),
  /** Of the scene shown; none until it has come. */
  analysis: signal<Analysis | undefined>(undefined),
  probe: signal<{ at: Point; square: number } | undefined>(undefined),
  /** Which of several objects is placed; none: all together. */
  chosen: signal<number | undefined>(undefined),
  /** Whether the outline of a hand is in the view, as a scale. */
  outline: signal(localStorage.getItem("outline") === "on"),
  /** Whether the field is shown on a hand's skin, too. */
  skin: signal(false),
  /** Where the pen is, and in how many places it was, while a line is drawn by hand. */
  pen: signal<{ at: Point; places: number } | undefined>(undefined),
  /** Over how long a drawn line is smoothed, ms, and how far that has moved it, of the file that it became. */
  smoothing: signal(30),
  smoothed: signal<{ file: string; ms: number; mm: number } | undefined>(undefined),
  /** The document's path, if it was drawn by hand. */
  line: signal<{ file: string; places: Point[]; seconds: number } | undefined>(undefined),
  /** Why a pattern that was opened is a path, and no shape with key frames. */
  whyPath: signal<{ file: string; why: string } | undefined>(undefined),
  /** Which key frame is edited. */
  keyFrame: signal(0),
  kept: signal<Kept | undefined>(undefined),
  /** Whether the kept scene is shown in place of the present one. */
  showsKept: signal(false),
  /** What was simulated last, of which scene, and the pulses of the marked record. */
  pins: signal<{ underWay: boolean; scene?: string; report?: PinReport; window?: PulseWindow | undefined }>({ underWay: false }),
  /** Whether the page of studies is shown, which studies there are, and the session that runs or has ended. */
  studying: signal(false),
  studies: signal<Studies | undefined>(undefined),
  session: signal<StudySession | undefined>(undefined),
  /** Why studies cannot be run, or the last session could not begin. */
  studyFailure: signal<Failure | undefined>(undefined),
  /** How many decibels the surface in the view lies below the greatest value around the focal points; none: there is no surface. */
  surface: signal<number | undefined>(undefined),
  /** Whether a surface is being computed. */
  surfacing: signal(false),
  /** The frame of the hand that the document has. */
  hand: signal<HandFrame | undefined>(undefined),
  /** Whether a path is being rendered, and what became of all frames of the document without its frame, as text. */
  rendering: signal(false),
  frames: signal<{ of: string; reports: FrameReport[] } | undefined>(undefined),
  /** Of the present scene and of the kept one. */
  profiles: signal<{ now: Profile | undefined; kept: Profile | undefined }>({ now: undefined, kept: undefined }),
};

/** By what boards are reached. */
export const boards = signal<Link["boards"]>("program");
/** Whether no program is behind the page: then there are no virtual boards, no simulated Verilog, no bitstreams, pictures and studies. */
export const noProgram = computed(() => boards.value !== "program");

/** The shipped board that a document is for, if it names one. */
export const boardOf = (document: ProjectDocument | undefined): Hello["boards"][number] | undefined => state.hello.value?.boards.find(({ name }) => name === document?.board);

/** Tells what went wrong, as the server's own failures are told. */
export function tell(error: unknown): void {
  state.failure.value = { where: "", message: error instanceof Error ? error.message || error.name : String(error), lasts: true };
}

/** The record that the field is of; 0 is the mean over the sequence. */
export const shownRecord = computed(() => {
  const entry = state.scene.value?.tour[state.at.value ?? -1];
  return state.alone.value && !state.showsKept.value && entry ? entry.record : 0;
});

/** The scene that is shown, if it is the document's and its engine is there: what can be played and taken away. */
export const made = computed(() => (state.current.value && state.engine.value === "here" && !state.showsKept.value ? state.scene.value : undefined));
/** Why there is none; nothing while it is being computed. */
export const whyNotMade = computed(() => {
  const { engine, refused, current } = state;
  if (made.value) return "";
  if (engine.value !== "here") return engine.value === "silent" ? "The server does not answer." : noProgram.value ? "What computes in this page has ended." : "The server is gone.";
  if (refused.value) return `This design cannot be made: ${[headOf(refused.value), wordsOf(refused.value)].filter(Boolean).join(": ").split(":\n")[0]}`;
  if (state.showsKept.value) return "The view shows the kept design. In the step See, “Show the kept one” ends that, and “Go back to it” takes it.";
  return current.value ? "There is nothing to play." : "";
});

/** Whether a participant's session is under way. */
export const inSession = computed(() => state.session.value !== undefined && state.session.value.now.show !== "ended");

/** Whether outputs are on, as far as it is known; undefined: it is not. */
export const outputsOn = computed(() => {
  const outputs = state.device.value.status?.outputs;
  return state.engine.value === "silent" || outputs === "unknown" ? undefined : outputs === "on";
});

/** Whether the board plays something else than the view shows. */
export const playsOther = computed(() => {
  const { played, refused, scene, showsKept, kept } = state;
  return outputsOn.value === true && played.value !== "" && (refused.value !== undefined || (showsKept.value ? kept.value?.scene : scene.value)?.name !== played.value);
});

export interface Actions {
  place(orientation: Orientation, middle: Point): void;
  drop(files: File[]): Promise<void>;
  /** Opens a design that came with the page. */
  openShipped(name: string, title: string): Promise<void>;
  /** Opens what the browser kept. */
  restore(design: Design): Promise<void>;
  /** Saves the design as a bundle. */
  saveBundle(): Promise<void>;
  /** Plays on the board, on a virtual one if there is none. */
  play(): void;
  /** The view shows all that there is. */
  frame(): void;
  /** Puts the plane back through the middle of the object. */
  ontoObject(): void;
  /** Saves what the view shows as a picture. */
  picture(): Promise<void>;
  send(t: string, members?: Record<string, unknown>): void;
  take(as: FileOfScene): Promise<void>;
  /** The image in its board's bitstream as a file; with autostart it plays at power-up. */
  takeBitstream(autostart: boolean): Promise<void>;
  /** Copies the paragraph for a paper's section on methods. */
  copyMethods(): Promise<void>;
  /** Renders the hand's frame, or all of them, and saves the path; or only looks through them. */
  renderHand(what: "frame" | "all" | "look"): Promise<void>;
  takeField(as: "png" | "csv" | "npy" | "vti"): Promise<void>;
  copy(text: string): Promise<void>;
  /** Hands text to the user as a file. */
  save(text: string, name: string): void;
  /** Marks a focal point, and plays it when the marked point is being played. @param isStep  that undo takes back */
  mark(at: number, isStep?: boolean): void;
  /** Marks a focal point and puts the plane through it. */
  point(at: number): void;
  stream(): void;
  /** Lets the timeline run from the marked point on, or stops it. */
  run(on: boolean): void;
  /** Whether the field is that of the marked focal point alone. */
  showAlone(on: boolean): void;
  /** Whether the field is what one focus could have at each point. */
  showReach(on: boolean): void;
  /** Whether the field is shown on a hand's skin, too. */
  showSkin(on: boolean): void;
  handle(handles: Handles): void;
  /** Lets the user draw a path on the plane by hand, or ends that. */
  draw(on: boolean): void;
  /** The drawn path lasts so long. */
  last(seconds: number): Promise<void>;
  /** Which of several objects is placed. */
  choose(object: number | undefined): void;
  /** Puts the present scene aside, or forgets the one that was. */
  keep(on: boolean): void;
  /** Plays the scene on the Verilated core, or ends that. */
  simulate(on: boolean): void;
  /** Asks for the pulses of the marked record, for so many carrier periods. */
  showPulses(periods: number): void;
  showKept(on: boolean): void;
  /** Shows the page of studies in place of the object, or the object again. */
  study(on: boolean): void;
  /** Lets a hand feel the object as it comes. @param from  a tracker's named pipe; "": the document's recording */
  live(from: string): void;
  /** Outputs off. */
  stop(): void;
  beginStudy(choice: StudyChoice): void;
  /** Answers what the session waits for. */
  answer(text: string): void;
  /** Stops the session where it is; it goes on later. */
  leaveStudy(): void;
  /** Back to the choice of a session. */
  anotherStudy(): void;
  paint(): void;
}
