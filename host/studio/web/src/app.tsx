// SPDX-License-Identifier: Apache-2.0
// The page: puts the parts together.
import { effect } from "@preact/signals";
import { render } from "preact";
import { actionsOf } from "./actions";
import { Board } from "./board";
import { Compare } from "./compare";
import { edit, endGesture, project, redo, undo } from "./document";
import { takeDrops } from "./dropping";
import { Findings } from "./findings";
import { HandReport } from "./hand";
import type { Link, Point } from "./link";
import { Bar, Failed, Numbers, SliceControls, Status, TakeAway, Tools } from "./panels";
import { moved, placed, placeOf } from "./placing";
import { Pins } from "./pins";
import { ProfilePlot } from "./plot";
import { look } from "./quantity";
import { Session } from "./session";
import { Shape } from "./shape";
import { type Actions, shownRecord, state, tell } from "./state";
import { StudyPage } from "./study";
import { Surfaces } from "./surface";
import { Timeline } from "./timeline";
import { View } from "./view";

export function start(link: Link): void {
  const host = document.getElementById("app");
  const tools = document.getElementById("tools");
  if (!host || !tools) throw new Error("the page has no place for the view");
  const session = new Session(link, (shown) => {
    if (shown === 1) performance.mark("first slice");
    host.dataset["slices"] = String(shown);
  });
  const actions = actionsOf(session, link);
  draw(actions, host, tools);
  effect(() => void host.classList.toggle("studying", state.studying.value));
  const place = document.getElementById("view");
  if (place) {
    effect(() => place.setAttribute("aria-busy", String(!state.current.value || state.slicing.value)));
    try {
      session.view = viewIn(place, session);
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
    session.ask();
  });
  follow(session, link, host);
  if (link.open) session.begin();
}

/** All of the page but the view. */
function draw(actions: Actions, host: HTMLElement, tools: HTMLElement): void {
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
}

function viewIn(place: HTMLElement, session: Session): View {
  const view = new View(place);
  state.edges.value = view.edges();
  view.moved = () => session.planeMoved();
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
    tell,
    (busy) => (state.surfacing.value = busy),
  );
  effect(() => {
    const scene = state.showsKept.value ? state.kept.value?.scene : state.scene.value;
    const belowDb = state.surface.value;
    surfaces.ask(view && scene && belowDb !== undefined ? { scene, record: shownRecord.value, belowDb } : undefined);
  });
}
