// SPDX-License-Identifier: Apache-2.0
// The page: puts the parts together, and keeps scene, slice and board as the server told them.
import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { edit, project, redo, undo } from "./document";
import type { Device, Drawn, Event, Failure, Hello, Link, Point, Scene, SliceData } from "./link";
import { Bar, Board, Failed, Numbers, Shape, SliceControls, Status, TakeAway, Tools } from "./panels";
import { quantity } from "./quantity";
import { Slicer } from "./slicer";
import { type Orientation, View } from "./view";

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
  turning: signal(false),
};

export interface Actions {
  place(orientation: Orientation, middle: Point): void;
  drop(files: File[]): Promise<void>;
  send(t: string, members?: Record<string, unknown>): void;
  take(as: "hex" | "manifest" | "project"): Promise<void>;
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
    () => view?.edges() ?? { origin: [-80, -80, 130], u: [160, 0, 0], v: [0, 160, 0] },
    () => state.scene.value?.name,
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
      slicer.ask(false);
    } else if (event.t === "object") {
      state.object.value = event.object;
      view?.showObject(event.object);
    } else if (event.t === "slice") {
      if (!slicer.take(event.slice)) return;
      view?.showSlice(event.slice, quantity.value);
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
      slicer.ask(true);
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
        const anchor = document.createElement("a");
        anchor.href = URL.createObjectURL(await link.take(scene.name, as));
        anchor.download = names[as];
        anchor.click();
        setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000); // when it has surely been read
      } catch (error) {
        wrong(error);
      }
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
        <Failed />
      </main>
      <aside aria-label="Results and board">
        <Board actions={actions} />
        <SliceControls actions={actions} turn={(on) => view && (view.turning = on)} />
        <Numbers />
      </aside>
      <Status />
    </>,
    host,
  );

  const place = document.getElementById("view");
  if (place) {
    try {
      view = new View(place);
      view.moved = () => {
        if (view) state.middle.value = view.middle;
        slicer.ask(true);
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
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    event.preventDefault();
    if (event.shiftKey) redo();
    else undo();
  });
  effect(() => {
    if (project.value === undefined) return;
    state.current.value = false;
    askScene();
  });
  effect(() => view?.showQuantity(quantity.value));
  if (link.open) void begin().catch(wrong);
}
