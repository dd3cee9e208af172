// SPDX-License-Identifier: Apache-2.0
// The page: puts the parts together, and keeps scene, slice and board as the server told them.
import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { commands } from "./commands";
import { edit, endGesture, having, project, type ProjectDocument, redo, undo } from "./document";
import type { Device, Drawn, Event, Failure, Hello, Link, Point, Scene, SliceData } from "./link";
import { Bar, Board, Failed, Numbers, Scrubber, Shape, SliceControls, Status, TakeAway, Tools } from "./panels";
import { look, quantities } from "./quantity";
import { Slicer } from "./slicer";
import { type Edges, type Orientation, View } from "./view";

/** What the handles in the view do. */
export type Handles = `${"plane" | "object"} ${"move" | "turn"}`;

/** What the panels show and call. */
export const state = {
  hello: signal<Hello | undefined>(undefined),
  scene: signal<Scene | undefined>(undefined),
  /** Whether the scene shown is that of the document shown. */
  current: signal(false),
  object: signal<Drawn | undefined>(undefined),
  slice: signal<SliceData | undefined>(undefined),
  latencyMs: signal(0),
  failure: signal<Failure | undefined>(undefined),
  device: signal<Device>({ t: "device", connection: "none" }),
  work: signal<Event | undefined>(undefined),
  middle: signal<Point>([0, 0, 130]),
  orientation: signal<Orientation>("xy"),
  handles: signal<Handles>("plane move"),
  edges: signal<Edges>({ origin: [-80, -80, 130], u: [160, 0, 0], v: [0, 160, 0] }),
  /** Whether a slice is still to come. */
  slicing: signal(false),
  /** Of files of the field. */
  stepMm: signal(1),
  writing: signal(false),
  /** Place in the tour that the scrubber marks. */
  at: signal<number | undefined>(undefined),
  probe: signal<{ at: Point; square: number } | undefined>(undefined),
};

export interface Actions {
  place(orientation: Orientation, middle: Point): void;
  drop(files: File[]): Promise<void>;
  send(t: string, members?: Record<string, unknown>): void;
  take(as: "hex" | "manifest" | "project"): Promise<void>;
  takeField(as: "png" | "csv" | "npy" | "vti"): Promise<void>;
  copy(text: string): Promise<void>;
  /** Marks a focal point, and plays it when the marked point is being played. */
  mark(at: number): void;
  stream(): void;
  handle(handles: Handles): void;
  paint(): void;
}

export function start(link: Link): void {
  const host = document.getElementById("app");
  const tools = document.getElementById("tools");
  if (!host || !tools) throw new Error("the page has no place for the view");
  const sent = new Map<string, File>(); // so that a server that was started again gets them again
  let asked: { n: number; document: string } | undefined; // scene under way
  let view: View | undefined;
  const slicer = new Slicer(
    link,
    () => state.edges.peek(),
    () => state.scene.value?.name,
    (busy) => (state.slicing.value = busy),
  );

  /** One scene is under way at a time; the newest document is asked for when it has come. */
  function askScene(): void {
    const document = project.value;
    if (asked || !document || !link.open) return;
    const text = JSON.stringify(document);
    asked = { n: link.send({ t: "scene", document }), document: text };
  }
  function sceneCame(n: number | undefined): boolean {
    if (!asked || asked.n !== n) return false;
    const changed = asked.document !== JSON.stringify(project.value);
    asked = undefined;
    state.current.value = !changed;
    if (changed) askScene();
    return true;
  }
  const planeMoved = (): void => {
    if (view) {
      state.edges.value = view.edges();
      state.middle.value = view.middle;
    }
    slicer.ask(true);
  };
  function save(blob: Blob, name: string): void {
    const anchor = document.createElement("a");
    anchor.href = URL.createObjectURL(blob);
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000); // when it has surely been read
  }
  const wrong = (error: unknown): void => {
    state.failure.value = { where: "", message: error instanceof Error ? error.message : String(error) };
  };

  let told = 0;
  link.listen((event) => {
    if (event.t === "open") {
      asked = undefined;
      slicer.lose();
      void begin().catch(wrong);
    } else if (event.t === "lost") {
      state.device.value = { t: "device", connection: "none" };
      state.work.value = undefined;
    } else if (event.t === "scene") {
      if (!sceneCame(event.n)) return;
      state.failure.value = undefined;
      state.scene.value = event.scene;
      view?.showScene(event.scene);
      state.at.value = undefined;
      view?.showFocus(undefined);
      slicer.ask(false);
    } else if (event.t === "object") {
      state.object.value = event.object;
      view?.showObject(event.object);
    } else if (event.t === "slice") {
      if (!slicer.take(event.slice)) return;
      view?.showSlice(event.slice, look.value);
      // Numbers are for reading: ten times a second is enough.
      const now = performance.now();
      if (now - told > 100 || event.slice.width === 200) {
        told = now;
        state.slice.value = event.slice;
        state.latencyMs.value = slicer.latencyMs;
      }
      if (slicer.shown === 1) performance.mark("first slice");
      host.dataset["slices"] = String(slicer.shown);
    } else if (event.t === "device") {
      state.device.value = event;
    } else if (event.t === "failed") {
      if (!sceneCame(event.n)) slicer.fail(event.n);
      if (event.work) state.work.value = event;
      state.failure.value = event.error;
    } else if (event.t === "error") {
      state.failure.value = event.error;
    } else if (event.t === "progress" || event.t === "done" || event.t === "stopped") {
      state.work.value = event;
    }
  });

  /** The server has just been reached, perhaps again. */
  async function begin(): Promise<void> {
    const hello = await link.hello();
    state.hello.value = hello;
    for (const file of sent.values()) await link.sendFile(file);
    if (project.value === undefined) edit(hello.document);
    askScene();
  }

  const actions: Actions = {
    place(orientation, middle) {
      state.orientation.value = orientation;
      state.middle.value = middle;
      view?.place(orientation, middle);
      planeMoved();
    },
    async drop(files) {
      try {
        state.failure.value = undefined;
        for (const file of files) {
          const most = state.hello.value?.most_file_bytes ?? 0;
          if (file.size > most) throw new Error(`${file.name}: ${file.size} bytes are more than the ${most} that the studio takes; “haptogram compile” takes files of any size`);
          await link.sendFile(file);
          sent.set(file.name, file);
        }
        const before = project.value;
        if (!before || files.length === 0) return;
        const place = { size_mm: 60, center_mm: [0, 0, 130], ...before.place };
        edit({ ...before, place, shape: files.map((file) => ({ file: file.name })) });
        // A file of the same name may have new contents.
        askScene();
      } catch (error) {
        wrong(error);
      }
    },
    send: (t, members = {}) => void link.send({ t, ...members }),
    async take(as) {
      try {
        const scene = state.scene.value;
        if (!scene) return;
        const names = { hex: "image.hex", manifest: "image.json", project: "project.toml" };
        save(await link.take(scene.name, as), names[as]);
      } catch (error) {
        wrong(error);
      }
    },
    async takeField(as) {
      const scene = state.scene.value;
      const { field } = commands(state.edges.value, look.value.quantity, state.stepMm.value);
      if (!scene || !field) return;
      try {
        state.writing.value = true;
        const { command: quantity } = quantities[look.value.quantity];
        save(await link.field({ scene: scene.name, plane: field.plane, ...field.ranges, step: String(state.stepMm.value), quantity, as }), `field.${as}`);
      } catch (error) {
        wrong(error);
      } finally {
        state.writing.value = false;
      }
    },
    copy: async (text) => await navigator.clipboard.writeText(text).catch(wrong),
    mark(at) {
      const entry = state.scene.value?.tour[at];
      state.at.value = at;
      view?.showFocus(entry?.at);
      const work = state.work.value;
      if (work?.t === "progress" && work.work === "stream") actions.stream();
    },
    stream() {
      const scene = state.scene.value;
      const entry = scene?.tour[state.at.value ?? -1];
      if (scene && entry) link.send({ t: "stream", scene: scene.name, index: entry.index });
    },
    handle(handles) {
      state.handles.value = handles;
      if (!view) return;
      view.handles = handles.startsWith("object") ? "object" : "plane";
      view.turning = handles.endsWith("turn");
    },
    paint: () => view?.paint(),
  };

  render(<Tools actions={actions} />, tools);
  host.replaceChildren();
  render(
    <>
      <aside aria-label="Object">
        <Shape actions={actions} />
        <TakeAway actions={actions} />
      </aside>
      <main id="view">
        <Bar />
        <Scrubber actions={actions} />
        <Failed />
      </main>
      <aside aria-label="Results and board">
        <Board actions={actions} />
        <SliceControls actions={actions} />
        <Numbers />
      </aside>
      <Status />
    </>,
    host,
  );

  const place = document.getElementById("view");
  if (place) {
    effect(() => place.setAttribute("aria-busy", String(!state.current.value || state.slicing.value)));
    try {
      view = new View(place);
      state.edges.value = view.edges();
      view.moved = planeMoved;
      view.probed = (found) => {
        if (found !== state.probe.peek()) state.probe.value = found;
      };
      view.objectMoved = (centre, turn, done) => {
        const now = project.peek();
        if (now) {
          const rounded = (point: Point, part: number): number[] => point.map((each) => Number((Math.round(each / part) * part).toFixed(3)));
          const moving = state.handles.peek().endsWith("move");
          const change = moving ? { center_mm: rounded(centre, 0.1) } : { rotate_deg: rounded(turn, 0.5) };
          edit(having(now, { place: having((now.place ?? {}) as ProjectDocument, change) }), "handles");
        }
        if (done) endGesture();
      };
    } catch (error) {
      place.append(Object.assign(document.createElement("p"), { className: "failed", textContent: `There is no 3-D view: ${String(error)}. All else works.` }));
    }
  }
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
    void actions.drop([...(event.dataTransfer?.files ?? [])]);
  });
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    if (!(event.ctrlKey || event.metaKey) || (key !== "z" && key !== "y")) return;
    event.preventDefault();
    if (event.shiftKey || key === "y") redo();
    else undo();
  });
  effect(() => {
    if (project.value === undefined) return;
    state.current.value = false;
    askScene();
    if (view) view.turn = (project.value.place?.rotate_deg ?? [0, 0, 0]) as Point;
  });
  effect(() => view?.showLook(look.value));
  if (link.open) void begin().catch(wrong);
}
