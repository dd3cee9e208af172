// SPDX-License-Identifier: Apache-2.0
// The page: puts the parts together. The view is the page; panels stand around it, and each step shows those that it needs.
import { computed, effect } from "@preact/signals";
import { Camera, Hand, Maximize, PanelLeft, PanelRight } from "lucide-preact";
import { render } from "preact";
import { actionsOf } from "./actions";
import { Board, LeftOut, tellBoard } from "./board";
import { Compare } from "./compare";
import { edit, endGesture, isSaved, looked, project, redo, showSightBy, undo } from "./document";
import { takeDrops } from "./dropping";
import { Feel } from "./feel";
import { Gallery } from "./gallery";
import { HandReport } from "./hand";
import { leave, offered } from "./keeper";
import type { Link, Outline, Point } from "./link";
import { Live } from "./live";
import { Bar, Failed, Numbers, ScaleBar, SliceControls, Status, TakeAway } from "./panels";
import { moved, placed, placeOf } from "./placing";
import { Pins } from "./pins";
import { ProfilePlot } from "./plot";
import { look } from "./quantity";
import { Session } from "./session";
import { Drawing } from "./path";
import { Begin, Properties, Subject } from "./shape";
import { Splitter } from "./splitter";
import { type Actions, boards, made, shownRecord, state, tell } from "./state";
import { readPathFile } from "./stroke";
import { StudyPage } from "./study";
import { Surfaces } from "./surface";
import { theme } from "./theme";
import { Timeline } from "./timeline";
import { PlayButton, Tools } from "./top";
import { firedBy } from "./triggers";
import { View } from "./view";

export function start(link: Link): void {
  const host = document.getElementById("app");
  const tools = document.getElementById("tools");
  const playing = document.getElementById("playing");
  if (!host || !tools || !playing) throw new Error("the page has no place for the view");
  boards.value = link.boards;
  const session = new Session(link, (shown) => {
    if (shown === 1) performance.mark("first slice");
    host.dataset["slices"] = String(shown);
  });
  const actions = actionsOf(session, link);
  render(<Tools actions={actions} />, tools);
  render(<PlayButton actions={actions} />, playing);
  host.replaceChildren();
  render(<Page actions={actions} />, host);
  effect(() => {
    const { left, right } = state.folded.value;
    host.classList.toggle("studying", state.studying.value);
    host.classList.toggle("no-left", left);
    host.classList.toggle("no-right", right);
    host.classList.toggle("old", state.refused.value !== undefined || state.engine.value !== "here");
  });
  const place = document.getElementById("view");
  if (place) {
    effect(() => place.setAttribute("aria-busy", String(!(state.current.value || state.refused.value) || state.slicing.value)));
    try {
      session.view = viewIn(place, session);
    } catch (error) {
      place.append(Object.assign(document.createElement("p"), { className: "failed", textContent: `There is no 3-D view: ${String(error)}. All else works.` }));
    }
  }
  takeDrops(host, (files) => void actions.drop(files));
  takeKeys(actions);
  addEventListener("beforeunload", (event) => {
    if (!isSaved.peek()) event.preventDefault();
  });
  effect(() => {
    if (project.value === undefined) return;
    state.current.value = false;
    state.refused.value = undefined;
    session.ask();
  });
  effect(() => {
    const { connection } = state.device.value;
    const from = state.livesNext.value;
    if (from === undefined || (connection !== "connected" && connection !== "lost")) return;
    state.livesNext.value = undefined;
    if (connection === "connected") actions.live(from);
  });
  effect(() => {
    const { connection } = state.device.value;
    if (!state.playsNext.value) return;
    if (connection === "lost" || state.refused.value || state.showsKept.value) state.playsNext.value = false;
    if (connection !== "connected" || !made.value) return;
    state.playsNext.value = false;
    actions.play();
  });
  const makes = computed(() => state.step.value === "Make" && project.value?.shape !== undefined);
  effect(() => {
    // What one makes is what the handles move; else it is the plane on which one looks.
    const of = makes.value ? "object" : "plane";
    if (!state.handles.peek().startsWith(of)) actions.handle(`${of} move`);
  });
  effect(tellBoard);
  showSightBy((sight) => session.showSight(sight));
  follow(session, link, host);
  if (link.open) session.begin();
}

function takeKeys(actions: Actions): void {
  const noPlay = (): void => {
    state.stopping.value = boards.value !== "none";
    state.playsNext.value = false; // whatever was to come, STOP comes first
    state.livesNext.value = undefined;
  };
  document.getElementById("stop")?.addEventListener("click", noPlay);
  addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      noPlay();
      actions.draw(false);
    }
    if (!(event.ctrlKey || event.metaKey)) return fire(event, actions);
    const key = event.key.toLowerCase();
    const does = key === "s" ? () => void actions.saveBundle() : key === "y" || (key === "z" && event.shiftKey) ? redo : key === "z" ? undo : undefined;
    if (!does) return;
    event.preventDefault();
    does();
  });
}

/** A key that is a trigger of what plays starts its part, unless it is typed into a field. */
function fire(event: KeyboardEvent, actions: Actions): void {
  const [scene, work] = [state.scene.peek(), state.work.peek()];
  const plays = work?.t === "progress" && work.work === "play" && scene !== undefined && scene.name === state.played.peek();
  const typed = (event.target as Element | null)?.closest("input, textarea, select");
  const number = plays && !event.repeat && !event.altKey && !typed ? firedBy(event.key, project.peek()) : -1;
  if (number >= 0) actions.send("trigger", { number });
}

/** All of the page but the bar at the top and the view's canvas. */
function Page({ actions }: { actions: Actions }) {
  const step = state.step.value;
  const fold = (which: "left" | "right"): void => void (state.folded.value = { ...state.folded.value, [which]: !state.folded.value[which] });
  const { left, right } = state.folded.value;
  return (
    <>
      <aside id="left" aria-label="Objects" hidden={left} tabIndex={0}>
        {step === "Make" && <><Begin actions={actions} /><Gallery actions={actions} /><Subject actions={actions} /></>}
        {step === "See" && <><Compare actions={actions} /><Pins actions={actions} /></>}
        {step === "Play" && <TakeAway actions={actions} />}
        {!left && <Splitter side="left" />}
      </aside>
      <main id="view">
        <div class="float at-left">
          <button type="button" class="ghost" aria-expanded={!left} aria-controls="left" onClick={() => fold("left")} title="Objects" aria-label="Panel at the left"><PanelLeft size={16} /></button>
          <button type="button" class="ghost" onClick={actions.frame} title="Show all" aria-label="Show all"><Maximize size={16} /></button>
          <button type="button" class="ghost" aria-pressed={state.outline.value} onClick={() => (state.outline.value = !state.outline.value)} title="The outline of a hand, as a scale" aria-label="Hand for scale"><Hand size={16} /></button>
          {step !== "Make" && <button type="button" class="ghost" onClick={() => void actions.picture()} title="Save a picture of the view" aria-label="Save a picture of the view"><Camera size={16} /></button>}
        </div>
        <div class="float at-right">
          <button type="button" class="ghost" aria-expanded={!right} aria-controls="right" onClick={() => fold("right")} title="Properties" aria-label="Panel at the right"><PanelRight size={16} /></button>
        </div>
        <Restore actions={actions} />
        <Drawing actions={actions} />
        <ScaleBar />
        <Bar />
        <Failed />
      </main>
      <aside id="right" aria-label="Properties" hidden={right} tabIndex={0}>
        {step === "Make" && <>{project.value?.hand ? <HandReport /> : <Properties actions={actions} />}</>}
        {step === "See" && <><SliceControls actions={actions} /><ProfilePlot actions={actions} /><Numbers /></>}
        {step === "Play" && <><Board actions={actions} /><Live actions={actions} /><LeftOut /></>}
        {!right && <Splitter side="right" />}
      </aside>
      <Feel actions={actions} />
      <Timeline actions={actions} />
      <Status />
      <StudyPage actions={actions} />
    </>
  );
}

/** Over the view: what was not saved the last time, and what a first visitor should know. */
function Restore({ actions }: { actions: Actions }) {
  const design = offered.value;
  const hinted = (): void => {
    localStorage.setItem("hinted", "");
    state.hints.value = false;
  };
  return (
    <div class="cards">
      {design && (
        <p class="card" role="status">
          “{design.name}” of {new Date(design.when).toLocaleString([], { dateStyle: "medium", timeStyle: "short" })} was not saved as a file.{" "}
          <button type="button" class="primary" onClick={() => void actions.restore(design)}>Restore it</button> <button type="button" onClick={leave}>Leave it</button>
        </p>
      )}
      {state.outside.value && <p class="card" role="status">The object lies outside the view. <button type="button" onClick={actions.frame}>Show it</button></p>}
      {state.hints.value && (
        <div class="card hints">
          <p><b>This shape is made of air:</b> points of ultrasound, drawn in turn. Take another from the gallery, or drop a file.</p>
          {boards.value === "program" && <p><b>Play</b> starts a virtual board when there is no other. STOP or Esc turns all outputs off.</p>}
          <p><b>What it will feel like:</b> felt, perhaps, or not, by models. Ways to mend it stand below.</p>
          {boards.value === "serial" && <p><b>Play</b> asks for a board at a USB port of yours. STOP or Esc turns its outputs off.</p>}
          <button type="button" onClick={hinted}>Got it</button>
        </div>
      )}
    </div>
  );
}

function viewIn(place: HTMLElement, session: Session): View {
  const view = new View(place);
  state.edges.value = view.edges();
  view.scaled = (mmPerPixel) => (state.mmPerPixel.value = mmPerPixel);
  view.moved = () => session.planeMoved();
  view.letGo = (before) => looked({ plane: { orientation: state.orientation.peek(), ...before } }, { plane: session.sight.plane });
  view.outside = (outside) => (state.outside.value = outside);
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
  return view;
}

/** The view follows the state. */
function follow(session: Session, link: Link, host: HTMLElement): void {
  const { view } = session;
  let centreBefore: Point | undefined;
  effect(() => {
    if (!view || !project.value) return;
    const object = placed(project.value, state.chosen.value);
    const place = placeOf(project.value, object);
    view.turn = (place.rotate_deg ?? [0, 0, 0]) as Point;
    view.centre = object === undefined ? undefined : (place.center_mm as Point | undefined);
    // A plane through the object's centre goes with it.
    const centre = (place.center_mm ?? [0, 0, 130]) as Point;
    const before = centreBefore;
    centreBefore = centre;
    if (before && before.some((each, i) => each !== centre[i]) && view.middle.every((each, i) => Math.abs(each - (before[i] ?? 0)) < 0.01)) {
      view.middle = centre;
      session.planeMoved();
    }
  });
  effect(() => {
    if (theme.value) view?.paint();
  });
  effect(() => view?.showLook(look.value));
  effect(() => {
    const file = project.value?.path;
    if (state.line.peek()?.file === file) return;
    state.line.value = undefined;
    void (file === undefined ? undefined : session.sent.get(file))?.text().then((text) => {
      const read = readPathFile(text);
      if (read && project.peek()?.path === file) state.line.value = { file: file ?? "", ...read };
    }).catch(tell);
  });
  let outline: Promise<Outline> | undefined;
  effect(() => {
    const on = state.outline.value;
    localStorage.setItem("outline", on ? "on" : "off");
    if (!on) {
      view?.showOutline(undefined);
      return session.askSkin();
    }
    if (!state.hello.value) return; // the engine is not there yet
    outline ??= link.outline();
    void outline.then((hand) => {
      if (!state.outline.peek()) return;
      view?.showOutline(hand);
      session.askSkin();
    }).catch(tell);
  });
  effect(() => {
    void [state.skin.value, state.reach.value, shownRecord.value, state.showsKept.value];
    session.askSkin();
  });
  const surfaces = new Surfaces(
    link,
    (geometry) => {
      view?.showSurface(geometry);
      host.dataset["surface"] = String(geometry?.getAttribute("position").count ?? 0);
    },
    tell,
    (busy) => (state.surfacing.value = busy),
  );
  effect(() => {
    const scene = state.showsKept.value ? state.kept.value?.scene : state.scene.value;
    const belowDb = state.surface.value;
    surfaces.ask(view && scene && belowDb !== undefined ? { scene, record: shownRecord.value, belowDb } : undefined);
  });
}
