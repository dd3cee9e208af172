// SPDX-License-Identifier: Apache-2.0
// The page: puts the parts together, and keeps scene, slice and board as the server told them.
import { effect } from "@preact/signals";
import { render } from "preact";
import { Board } from "./board";
import { commands } from "./commands";
import { Comparer } from "./comparer";
import { Compare } from "./compare";
import { edit, endGesture, project, type ProjectDocument, redo, undo } from "./document";
import { takeDrops, withFiles } from "./dropping";
import { Findings } from "./findings";
import { HandReport } from "./hand";
import { HandReader, ofAllFrames } from "./hand_reader";
import { Latest } from "./latest";
import { filesOfScene, type Link, type Point, type Scene } from "./link";
import { Bar, Failed, Numbers, SliceControls, Status, TakeAway, Tools } from "./panels";
import { moved, placed, placeOf } from "./placing";
import { PinReader } from "./pin_reader";
import { Pins } from "./pins";
import { ProfilePlot } from "./plot";
import { look, quantities } from "./quantity";
import { Shape } from "./shape";
import { Slicer } from "./slicer";
import { type Actions, boardOf, shownRecord, state } from "./state";
import { StudyPage } from "./study";
import { StudyReader } from "./study_reader";
import { Surfaces } from "./surface";
import { Runner, Timeline } from "./timeline";
import { View } from "./view";

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
    () => {
      const scene = state.showsKept.peek() ? state.kept.peek()?.scene : state.scene.peek();
      if (!scene) return undefined;
      return state.reach.peek() ? { t: "reach", scene: scene.name } : { t: "slice", scene: scene.name, record: shownRecord.peek() };
    },
    (busy) => (state.slicing.value = busy),
  );

  const drives = new Latest<true>(link);
  const comparer = new Comparer(link, () => slicer.ask(false));
  const pins = new PinReader(link);
  const study = new StudyReader(link);
  const hands = new HandReader(link, ({ hand, drawn, object }, newest) => {
    if (!project.peek()?.hand) return;
    state.hand.value = hand;
    if (!state.scene.peek()) view?.showArray(hand.array);
    if (object) {
      state.object.value = object;
      view?.showObject(object);
    }
    view?.showHand(drawn);
    if (!newest) return;
    if (hand.nothing) dropScene();
    else askScene();
  });
  const runner = new Runner((at) => mark(at));
  let analysed: { n: number; scene: string } | undefined; // that was asked for last

  /** Each focus is looked at once the view has all that it asked for. */
  function askAnalysis(): void {
    const scene = state.scene.peek();
    if (scene && state.current.peek() && analysed?.scene !== scene.name) analysed = { n: link.send({ t: "analyze", scene: scene.name }), scene: scene.name };
  }
  function mark(at: number): void {
    const scene = state.scene.peek();
    const entry = scene?.tour[at];
    if (!scene || !entry) return;
    state.at.value = at;
    view?.showFocus(entry.at);
    pins.show();
    drives.ask({ t: "drives", scene: scene.name, record: entry.record }, true);
    if (state.alone.peek()) slicer.ask(true);
    const work = state.work.value;
    if (work?.t === "progress" && work.work === "stream") actions.stream();
  }
  function unmark(): void {
    runner.stop();
    drives.lose();
    state.at.value = undefined;
    state.drives.value = undefined;
    view?.showFocus(undefined);
    view?.showDrives(undefined);
  }

  /** Nothing is played of the document. */
  function dropScene(): void {
    state.scene.value = state.slice.value = state.analysis.value = undefined;
    state.failure.value = undefined;
    unmark();
    slicer.stop();
    view?.clearScene();
    state.current.value = true;
  }
  function showScene(scene: Scene, of: ProjectDocument | undefined): void {
    view?.showScene(scene, of?.hand === undefined); // the hand has its own drawing of the focal points
  }
  /** Of a hand the frame is asked for first: it comes sooner, and may have nothing to play. */
  function ask(): void {
    const document = project.value;
    if (!document) return;
    if (document.hand) return hands.ask(document);
    if (state.hand.value) view?.showHand((state.hand.value = undefined));
    hands.forget();
    askScene();
  }
  /** One scene is under way at a time; the newest document is asked for when it has come. */
  function askScene(): void {
    const document = project.value;
    if (asked || !document || !link.open) return;
    // What is found out about the scene before would hold this one up.
    if (analysed && !state.analysis.peek()) {
      link.send({ t: "cancel", what: "analyze" });
      analysed = undefined;
    }
    const text = JSON.stringify(document);
    asked = { n: link.send({ t: "scene", document }), document: text };
  }
  function sceneCame(n: number | undefined): boolean {
    if (!asked || asked.n !== n) return false;
    const changed = asked.document !== JSON.stringify(project.value);
    asked = undefined;
    state.current.value = !changed;
    if (changed) ask();
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
    if (hands.take(event)) return;
    if (event.t === "open") {
      asked = undefined;
      analysed = undefined;
      slicer.lose();
      drives.lose();
      comparer.lose();
      pins.lose();
      study.lose();
      hands.lose();
      void begin().catch(wrong);
    } else if (event.t === "lost") {
      state.device.value = { t: "device", connection: "none" };
      state.work.value = undefined;
    } else if (event.t === "scene") {
      if (comparer.sceneCame(event.n) || !sceneCame(event.n)) return;
      state.failure.value = undefined;
      if (state.scene.peek()?.name !== event.scene.name) {
        state.analysis.value = undefined;
        analysed = undefined;
      }
      state.scene.value = event.scene;
      unmark();
      if (!state.showsKept.peek()) showScene(event.scene, project.peek());
      slicer.ask(false);
    } else if (event.t === "object") {
      if (comparer.isOfKept(event.object.n) || project.peek()?.hand) return;
      state.object.value = event.object;
      if (!state.showsKept.peek()) view?.showObject(event.object);
    } else if (event.t === "drives") {
      if (!drives.came(event.n) || state.scene.peek()?.tour[state.at.peek() ?? -1]?.record !== event.record) return;
      state.drives.value = event;
      if (!state.showsKept.peek()) view?.showDrives(event);
    } else if (event.t === "pins" || event.t === "pulses") {
      pins.take(event);
    } else if (event.t === "analysis") {
      if (event.n === analysed?.n) state.analysis.value = event;
    } else if (event.t === "slice") {
      if (comparer.take(event.slice) || !slicer.take(event.slice)) return;
      if (event.slice.width === 200) askAnalysis();
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
    } else if (event.t === "studies") {
      study.came(event.n, event);
    } else if (event.t === "study") {
      study.show(event.shown);
    } else if (event.t === "failed") {
      if (study.fail(event.n, event.error)) return;
      const frame = hands.fail(event.n, event.error);
      if (frame === "older" || frame === "path") return;
      if (frame) {
        dropScene();
        view?.showHand((state.hand.value = undefined));
      }
      if (comparer.failed(event.n)) return;
      pins.fail(event.n);
      if (!sceneCame(event.n) && !drives.came(event.n) && slicer.fail(event.n) && state.showsKept.peek()) return comparer.resend();
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
    ask();
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
        state.chosen.value = undefined;
        edit(withFiles(before, files.map((file) => file.name)));
        // A file of the same name may have new contents.
        ask();
      } catch (error) {
        wrong(error);
      }
    },
    send: (t, members = {}) => void link.send({ t, ...members }),
    async take(as) {
      try {
        const scene = state.scene.value;
        if (!scene) return;
        state.writing.value = true;
        save(await link.take(scene.name, as), filesOfScene[as]);
      } catch (error) {
        wrong(error);
      } finally {
        state.writing.value = false;
      }
    },
    async takeBitstream(autostart) {
      try {
        const scene = state.scene.value;
        const board = boardOf(project.value);
        if (!scene || !board) return;
        state.writing.value = true;
        save(await link.bitstream(scene.name, autostart), board.bitstream);
      } catch (error) {
        wrong(error);
      } finally {
        state.writing.value = false;
      }
    },
    async copyMethods() {
      try {
        const scene = state.scene.value;
        if (scene) await navigator.clipboard.writeText(await (await link.take(scene.name, "methods")).text());
      } catch (error) {
        wrong(error);
      }
    },
    async renderHand(what) {
      const document = project.value;
      if (!document?.hand || state.rendering.value) return;
      try {
        state.rendering.value = true;
        const of = what === "frame" ? document : ofAllFrames(document);
        const { text, frames } = await hands.render(of);
        if (what !== "frame") state.frames.value = { of: JSON.stringify(of), reports: frames };
        if (what !== "look") save(new Blob([text]), "path.json");
      } catch (error) {
        wrong(error);
      } finally {
        state.rendering.value = false;
      }
    },
    async takeField(as) {
      const scene = state.scene.value;
      const { field } = commands(state.edges.value, look.value.quantity, state.stepMm.value, shownRecord.value);
      if (!scene || !field) return;
      try {
        state.writing.value = true;
        const { command: quantity } = quantities[look.value.quantity];
        const of: Record<string, string> = shownRecord.value === 0 ? {} : { record: String(shownRecord.value) };
        save(await link.field({ scene: scene.name, ...of, plane: field.plane, ...field.ranges, step: String(state.stepMm.value), quantity, as }), `field.${as}`);
      } catch (error) {
        wrong(error);
      } finally {
        state.writing.value = false;
      }
    },
    copy: async (text) => await navigator.clipboard.writeText(text).catch(wrong),
    save: (text, name) => save(new Blob([text]), name),
    mark(at) {
      runner.stop();
      mark(at);
    },
    run: (on) => (on ? runner.start() : runner.stop()),
    showAlone(on) {
      state.alone.value = on;
      slicer.ask(false);
    },
    showReach(on) {
      state.reach.value = on;
      slicer.ask(false);
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
    choose: (object) => (state.chosen.value = object),
    simulate: (on) => (on ? pins.simulate() : pins.cancel()),
    showPulses: (periods) => pins.show(periods),
    keep(on) {
      const [scene, document] = [state.scene.value, project.value];
      if (!on) actions.showKept(false);
      state.kept.value = on && scene && document ? { document, scene, drawn: state.object.value } : undefined;
    },
    showKept(on) {
      state.showsKept.value = on;
      const shown = on ? state.kept.value?.scene : state.scene.value;
      const drawn = on ? state.kept.value?.drawn : state.object.value;
      if (shown) showScene(shown, on ? state.kept.value?.document : project.value);
      if (drawn) view?.showObject(drawn);
      if (!on && state.drives.value) view?.showDrives(state.drives.value);
      slicer.ask(false);
    },
    study(on) {
      state.studying.value = on;
      if (on) study.list();
    },
    beginStudy: (choice) => study.begin(choice),
    answer: (text) => study.answer(text),
    leaveStudy: () => study.leave(),
    anotherStudy() {
      state.session.value = undefined;
      study.list();
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
        <Timeline actions={actions} />
        <Failed />
      </main>
      <aside aria-label="Results and board">
        <Board actions={actions} />
        <HandReport />
        <Findings actions={actions} />
        <SliceControls actions={actions} />
        <ProfilePlot actions={actions} />
        <Compare actions={actions} />
        <Pins actions={actions} />
        <Numbers />
      </aside>
      <Status />
      <StudyPage actions={actions} />
    </>,
    host,
  );

  effect(() => void host.classList.toggle("studying", state.studying.value));

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
          edit(moved(now, placed(now, state.chosen.peek()), moving ? { center_mm: rounded(centre, 0.1) } : { rotate_deg: rounded(turn, 0.5) }), "handles");
        }
        if (done) endGesture();
      };
    } catch (error) {
      place.append(Object.assign(document.createElement("p"), { className: "failed", textContent: `There is no 3-D view: ${String(error)}. All else works.` }));
    }
  }
  takeDrops(host, (files) => void actions.drop(files));
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
    ask();
  });
  effect(() => {
    if (!view || !project.value) return;
    const object = placed(project.value, state.chosen.value);
    const place = placeOf(project.value, object);
    view.turn = (place.rotate_deg ?? [0, 0, 0]) as Point;
    view.centre = object === undefined ? undefined : (place.center_mm as Point | undefined);
  });
  effect(() => view?.showLook(look.value));
  const surfaces = new Surfaces(
    link,
    (geometry) => {
      view?.showSurface(geometry);
      host.dataset["surface"] = String(geometry?.getAttribute("position").count ?? 0);
    },
    wrong,
    (busy) => (state.surfacing.value = busy),
  );
  effect(() => {
    const scene = state.showsKept.value ? state.kept.value?.scene : state.scene.value;
    const belowDb = state.surface.value;
    surfaces.ask(view && scene && belowDb !== undefined ? { scene, record: shownRecord.value, belowDb } : undefined);
  });
  if (link.open) void begin().catch(wrong);
}
