// SPDX-License-Identifier: Apache-2.0
// What the page's buttons, fields and handles do.
import type { Signal } from "@preact/signals";
import { commands } from "./commands";
import { designName, project } from "./document";
import { Files } from "./files";
import { ofAllFrames } from "./hand_reader";
import { filesOfScene, type Link, type Point } from "./link";
import { Pen } from "./pen";
import { look, quantities } from "./quantity";
import type { Session } from "./session";
import type { Orientation } from "./view";
import { evenly, farthest, type Sample, smoothed } from "./stroke";
import { readsLines } from "./triggers";
import { type Actions, boardOf, made, noProgram, shownRecord, state, tell } from "./state";

const linePlaces = 200; // that a drawn line is passed at

function save(blob: Blob, name: string): void {
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(blob);
  anchor.download = name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000); // when it has surely been read
}

/** Does the work with the signal set, and tells what went wrong. */
async function during(busy: Signal<boolean>, work: () => Promise<void>): Promise<void> {
  busy.value = true;
  await work().catch(tell);
  busy.value = false;
}

export function actionsOf(session: Session, link: Link): Actions {
  const designs = new Files(session, link);
  session.openShown = async () => await designs.openShipped("dome", "Dome").then(() => true, () => false);
  session.restore = async (design) => await designs.restore(design);
  let pen: Pen | undefined;
  /** A drawn line becomes the design's path. */
  const drawn = async (samples: Sample[]): Promise<void> => {
    const ms = state.smoothing.peek();
    const line = smoothed(samples, ms);
    const file = await designs.takePath(evenly(line, linePlaces), ((samples.at(-1)?.ms ?? 0) - (samples[0]?.ms ?? 0)) / 1000);
    state.smoothed.value = { file, ms, mm: farthest(samples, line) };
  };
  const place = (orientation: Orientation, middle: Point): void => {
    state.orientation.value = orientation;
    state.middle.value = middle;
    session.view?.place(orientation, middle);
    session.planeMoved();
  };
  const actions: Actions = {
    place: (orientation, middle) => session.look(["plane"], () => place(orientation, middle)),
    point(at) {
      const entry = state.scene.peek()?.tour[at];
      if (!entry) return;
      session.look(["plane", "at"], () => {
        actions.mark(at, false);
        place(state.orientation.peek(), entry.at);
      });
    },
    drop: async (files) => await designs.take(files).catch(tell),
    openShipped: async (name, title) => await designs.openShipped(name, title).catch(tell),
    restore: async (design) => await designs.restore(design).catch(tell),
    async saveBundle() {
      await designs.saved().then(({ blob, name }) => save(blob, name)).catch(tell);
    },
    play() {
      const scene = made.value;
      if (!scene) return;
      if (state.device.value.connection === "none") {
        state.playsNext.value = true;
        link.send({ t: "connect", port: noProgram.value ? "" : "virtual", scene: scene.name });
      } else {
        const lines = readsLines(project.value) && !noProgram.value ? state.lines.value : "";
        state.wrongLine.value = undefined;
        link.send({ t: "play", scene: scene.name, triggers: scene.triggers, ...(lines && { lines }) });
      }
    },
    frame: () => session.view?.frameAll(),
    ontoObject() {
      const middle = session.view?.middleOfObject ?? project.peek()?.place?.center_mm;
      if (middle) actions.place(state.orientation.peek(), middle as Point);
    },
    async picture() {
      await session.view?.picture().then((blob) => save(blob, `${designName.peek()}.png`)).catch(tell);
    },
    send: (t, members = {}) => void link.send({ t, ...members }),
    async take(as) {
      const scene = made.value;
      if (scene) await during(state.writing, async () => save(await link.take(scene.name, as, designName.peek()), filesOfScene[as]));
    },
    async takeBitstream(autostart) {
      const [scene, board] = [made.value, boardOf(project.value)];
      if (scene && board) await during(state.writing, async () => save(await link.bitstream(scene.name, autostart), board.bitstream));
    },
    async copyMethods() {
      const scene = made.value;
      if (scene) await link.take(scene.name, "methods").then(async (file) => navigator.clipboard.writeText(await file.text())).catch(tell);
    },
    async renderHand(what) {
      const document = project.value;
      if (!document?.hand || state.rendering.value) return;
      const of = what === "frame" ? document : ofAllFrames(document);
      await during(state.rendering, async () => {
        const { text, frames } = await session.hands.render(of);
        if (what !== "frame") state.frames.value = { of: JSON.stringify(of), reports: frames };
        if (what !== "look") save(new Blob([text]), "path.json");
      });
    },
    async takeField(as) {
      const scene = made.value;
      const { field } = commands(state.edges.value, look.value.quantity, state.stepMm.value, shownRecord.value);
      if (!scene || !field) return;
      const { command: quantity } = quantities[look.value.quantity];
      const of: Record<string, string> = shownRecord.value === 0 ? {} : { record: String(shownRecord.value) };
      const asked = { scene: scene.name, ...of, plane: field.plane, ...field.ranges, step: String(state.stepMm.value), quantity, as };
      await during(state.writing, async () => save(await link.field(asked), `field.${as}`));
    },
    copy: async (text) => await navigator.clipboard.writeText(text).catch(tell),
    save: (text, name) => save(new Blob([text]), name),
    mark(at, isStep = true) {
      session.runner.stop();
      if (isStep) session.look(["at"], () => session.mark(at));
      else session.mark(at);
    },
    run: (on) => (on ? session.runner.start() : session.runner.stop()),
    showAlone(on) {
      state.alone.value = on;
      session.slicer.ask(false);
    },
    showReach(on) {
      state.reach.value = on;
      session.slicer.ask(false);
    },
    showSkin(on) {
      // Where no hand touches, that for scale is there for it.
      if (on && !project.peek()?.hand) state.outline.value = true;
      state.skin.value = on;
    },
    stream: () => session.stream(),
    handle(handles) {
      state.handles.value = handles;
      const { view } = session;
      if (!view) return;
      view.handles = handles.startsWith("object") ? "object" : "plane";
      view.turning = handles.endsWith("turn");
    },
    draw(on) {
      pen?.leave();
      pen = state.pen.value = undefined;
      if (!on) return;
      if (!session.view) return tell(new Error("Without its 3-D view the page has no plane to draw on."));
      actions.showAlone(false);
      pen = new Pen(session.view, {
        moved: (samples, at) => (state.pen.value = { at, places: samples.length }),
        failed: (why) => tell(new Error(why)),
        ended(samples) {
          actions.draw(false);
          void drawn(samples).catch(tell);
        },
      });
    },
    async last(seconds) {
      const line = state.line.value;
      if (line) await designs.takePath(line.places, seconds).catch(tell);
    },
    choose: (object) => (state.chosen.value = object),
    simulate: (on) => (on ? session.pins.simulate() : session.pins.cancel()),
    showPulses: (periods) => session.pins.show(periods),
    keep(on) {
      const [scene, document] = [made.value, project.value];
      if (!on) actions.showKept(false);
      state.kept.value = on && scene && document ? { document, scene, drawn: state.object.value } : undefined;
    },
    showKept(on) {
      state.showsKept.value = on;
      const shown = on ? state.kept.value?.scene : state.scene.value;
      const drawn = on ? state.kept.value?.drawn : state.object.value;
      if (shown) session.showScene(shown, on ? state.kept.value?.document : project.value);
      if (drawn) session.view?.showObject(drawn);
      if (!on && state.drives.value) session.view?.showDrives(state.drives.value);
      session.slicer.ask(false);
    },
    study(on) {
      state.studying.value = on;
      if (on) session.study.list();
    },
    live(from) {
      if (state.device.value.connection === "connected") return session.live.begin(from);
      state.livesNext.value = from;
      link.send({ t: "connect", port: "virtual", scene: made.value?.name ?? "" });
    },
    stop: () => link.stop(),
    beginStudy: (choice) => session.study.begin(choice),
    answer: (text) => session.study.answer(text),
    leaveStudy: () => session.study.leave(),
    anotherStudy() {
      state.session.value = undefined;
      session.study.list();
    },
    paint: () => session.view?.paint(),
  };
  return actions;
}
