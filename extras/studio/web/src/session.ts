// SPDX-License-Identifier: Apache-2.0
// What the page has under way with the server: asks for the scene of the newest document and for what is shown of it, and
// puts the answers into the state and into the view.
import { Comparer } from "./comparer";
import { history, looked, present, project, type ProjectDocument, type Sight, type Step, takeBack } from "./document";
import { openFirst } from "./files";
import { begin as keep, type Design } from "./keeper";
import { HandReader, type HandShown } from "./hand_reader";
import { Latest } from "./latest";
import { LiveReader } from "./live_reader";
import { placeOf } from "./labels";
import type { Device, Event, Failure, Link, Remedy, Scene } from "./link";
import { PinReader } from "./pin_reader";
import { look } from "./quantity";
import type { Skin } from "./skin";
import { Slicer } from "./slicer";
import { made, shownRecord, state, tell } from "./state";
import { StudyReader } from "./study_reader";
import { Runner } from "./timeline";
import type { View } from "./view";

export class Session {
  /** None before it is made, and where the browser has no WebGL. */
  view: View | undefined;
  /** Files that were dropped, so that a server that was started again gets them again. */
  readonly sent = new Map<string, File>();
  readonly slicer: Slicer;
  readonly pins: PinReader;
  readonly study: StudyReader;
  readonly live: LiveReader;
  readonly hands: HandReader;
  readonly runner = new Runner((at) => this.mark(at));
  private readonly drives: Latest<true>;
  private readonly skins: Latest<Skin>;
  private readonly comparer: Comparer;
  private asked: { n: number; document: string } | undefined; // scene under way
  private dropped: { step: Step | undefined; made: boolean; before: Map<string, File | undefined> } | undefined; // files of the last step
  private analysed: { n: number; scene: string } | undefined; // that was asked for last
  private refused: number | undefined; // the question for the scene that is refused
  private told = 0; // when the numbers of a slice were shown last

  constructor(
    private readonly link: Link,
    /** Told of each slice that is shown. */
    private readonly sliced: (shown: number) => void,
  ) {
    this.slicer = new Slicer(
      link,
      () => state.edges.peek(),
      () => {
        const scene = state.showsKept.peek() ? state.kept.peek()?.scene : state.scene.peek();
        if (!scene) return undefined;
        return state.reach.peek() ? { t: "reach", scene: scene.name } : { t: "slice", scene: scene.name, record: shownRecord.peek() };
      },
      (busy) => (state.slicing.value = busy),
    );
    this.drives = new Latest<true>(link);
    this.skins = new Latest(link);
    this.comparer = new Comparer(link, () => this.slicer.ask(false));
    this.pins = new PinReader(link);
    this.study = new StudyReader(link);
    this.live = new LiveReader(link, () => this.view);
    this.hands = new HandReader(link, (shown, newest) => this.handCame(shown, newest));
    link.listen((event) => this.take(event));
  }

  /** The server has just been reached, perhaps again. */
  begin(): void {
    const greet = async (): Promise<void> => {
      const hello = await this.link.hello();
      state.hello.value = hello;
      const kept = project.peek() ? undefined : await keep(() => this.namedFiles(), tell);
      for (const file of this.sent.values()) await this.link.sendFile(file);
      if (kept) await this.restore(kept);
      else if (!(state.hints.peek() && hello.project === "example" && (await this.openShown()))) openFirst(hello.document, hello.project);
      this.ask();
    };
    void greet().catch(tell);
  }

  /** Opens what a first visitor sees, a design that is felt. @return whether it could */
  openShown: () => Promise<boolean> = () => Promise.resolve(false);

  /** Opens what the browser kept. */
  restore: (design: Design) => Promise<void> = () => Promise.resolve();

  /** Of the files that were sent, those that a step of the design may name. */
  private namedFiles(): File[] {
    const text = JSON.stringify(this.sent.size > 0 ? history.peek().steps : []);
    return [...this.sent.values()].filter(({ name }) => text.includes(JSON.stringify(name).slice(1, -1)));
  }

  /** Asks for what the document gives. Of a hand the frame is asked for first: it comes sooner, and may have nothing to play. */
  ask(): void {
    const document = project.value;
    if (!document) return;
    if (document.hand) return this.hands.ask(document);
    if (state.hand.value) this.view?.showHand((state.hand.value = undefined));
    this.hands.forget();
    this.askScene();
  }

  /** Marks an entry of the tour. */
  mark(at: number): void {
    const scene = state.scene.peek();
    const entry = scene?.tour[at];
    if (!scene || !entry) return;
    state.at.value = at;
    this.showFocus();
    this.pins.show();
    this.drives.ask({ t: "drives", scene: scene.name, record: entry.record }, true);
    if (state.alone.peek()) this.slicer.ask(true);
    const work = state.work.value;
    if (work?.t === "progress" && work.work === "stream") this.stream();
  }

  /** The plane, and the marked focal point, as a step of the history has them. */
  get sight(): Required<Sight> {
    const place = this.view?.planePlace ?? { middle: state.middle.peek(), turn: [], scale: [] };
    return { plane: { orientation: state.orientation.peek(), ...place }, at: state.at.peek() ?? null };
  }

  /** Does what a person does to the view, so that undo takes it back. @param which  of the view's parts it changes */
  look(which: (keyof Sight)[], does: () => void): void {
    const parts = (): Sight => Object.fromEntries(Object.entries(this.sight).filter(([part]) => which.includes(part as keyof Sight)));
    const before = parts();
    does();
    looked(before, parts());
  }

  showSight({ plane, at }: Sight): void {
    if (plane) {
      state.orientation.value = plane.orientation;
      state.middle.value = plane.middle;
      if (this.view) this.view.planePlace = plane;
      this.planeMoved();
    }
    if (at === undefined) return;
    this.runner.stop();
    if (at === null) {
      this.unmark();
      if (state.alone.peek()) this.slicer.ask(false);
    } else {
      this.mark(at);
    }
  }

  /** Plays the marked entry on the board. */
  stream(): void {
    const scene = made.value;
    const entry = scene?.tour[state.at.value ?? -1];
    if (scene && entry) this.link.send({ t: "stream", scene: scene.name, index: entry.index });
  }

  planeMoved(): void {
    if (this.view) {
      state.edges.value = this.view.edges();
      state.middle.value = this.view.middle;
    }
    this.slicer.ask(true);
  }

  /** Asks for the field on the skin that the view has, if it is to be shown. */
  askSkin(): void {
    const scene = state.showsKept.peek() ? state.kept.peek()?.scene : state.scene.peek();
    const skin = scene && state.skin.peek() && !state.reach.peek() ? this.view?.skinThere() : undefined;
    if (scene && skin) this.skins.ask({ t: "skin", scene: scene.name, points: skin.points, record: shownRecord.peek(), view: 3 }, skin);
    else this.view?.showSkin(undefined);
  }

  private skinCame(skin: Skin, squares: Float32Array<ArrayBuffer>): void {
    const there = state.skin.peek() && !state.reach.peek() ? this.view?.skinThere() : undefined;
    if (there && there.points.join() === skin.points.join()) this.view?.showSkin({ skin, squares });
    else this.view?.showSkin(undefined);
  }

  showScene(scene: Scene, of: ProjectDocument | undefined): void {
    this.view?.showScene(scene, of?.hand === undefined); // the hand has its own drawing of the focal points
  }

  /** While the board plays a sequence, the view shows where it is; else the marked point. */
  private followBoard({ status }: Device): void {
    const scene = state.scene.peek();
    if (!scene) return;
    const plays = status?.outputs === "on" && status.mode === "sequence" && state.played.peek() === scene.name;
    const at = plays ? scene.tour.findIndex(({ index }) => index === status.index) : -1;
    state.playsPoint.value = at < 0 ? undefined : at;
    this.showFocus();
  }

  private showFocus(): void {
    this.view?.showFocus(state.scene.peek()?.tour[state.playsPoint.peek() ?? state.at.peek() ?? -1]?.at);
  }

  private unmark(): void {
    this.runner.stop();
    this.drives.lose();
    state.at.value = undefined;
    state.drives.value = undefined;
    state.playsPoint.value = undefined;
    this.showFocus();
    this.view?.showDrives(undefined);
  }

  /** Nothing is played of the document. */
  private dropScene(): void {
    state.scene.value = state.slice.value = state.analysis.value = undefined;
    state.failure.value = undefined;
    this.unmark();
    this.slicer.stop();
    this.view?.clearScene();
    state.current.value = true;
  }

  /** One scene is under way at a time; the newest document is asked for when it has come. */
  private askScene(): void {
    const document = project.value;
    if (this.asked || !document || !this.link.open) return;
    // What is found out about the scene before would hold this one up.
    if (this.analysed && !state.analysis.peek()) {
      this.link.send({ t: "cancel", what: "analyze" });
      this.analysed = undefined;
    }
    const text = JSON.stringify(document);
    this.asked = { n: this.link.send({ t: "scene", document }), document: text };
  }

  /** @return whether it was the scene, or the failure, that is waited for */
  private sceneEnded(n: number | undefined, failure?: Failure): boolean {
    if (!this.asked || this.asked.n !== n) return false;
    const changed = this.asked.document !== JSON.stringify(project.value);
    this.asked = undefined;
    state.current.value = !changed && !failure;
    state.refused.value = changed ? undefined : failure;
    this.refused = n;
    if (changed) this.ask();
    return true;
  }

  /** Each focus is looked at once the view has all that it asked for. */
  private askAnalysis(): void {
    const scene = state.scene.peek();
    if (scene && state.current.peek() && this.analysed?.scene !== scene.name)
      this.analysed = { n: this.link.send({ t: "analyze", scene: scene.name }), scene: scene.name };
  }

  private handCame({ hand, drawn, object }: HandShown, newest: boolean): void {
    if (!project.peek()?.hand) return;
    state.hand.value = hand;
    if (!state.scene.peek()) this.view?.showArray(hand.array);
    if (object) {
      state.object.value = object;
      this.view?.showObject(object);
    }
    this.view?.showHand(drawn);
    if (!newest) return;
    if (hand.nothing) this.dropScene();
    else this.askScene();
  }

  private take(event: Event): void {
    if (this.hands.take(event)) return;
    if (event.t === "open") {
      state.engine.value = "here";
      this.asked = undefined;
      this.analysed = undefined;
      for (const reader of [this.slicer, this.skins, this.drives, this.comparer, this.pins, this.study, this.live, this.hands]) reader.lose();
      this.begin();
    } else if (event.t === "silent" || event.t === "answers") {
      state.engine.value = event.t === "silent" ? "silent" : "here";
    } else if (event.t === "lost") {
      state.engine.value = "gone";
      state.device.value = { t: "device", connection: "none" };
      state.work.value = undefined;
      state.played.value = "";
      state.stopping.value = state.playsNext.value = false;
      state.livesNext.value = undefined;
    } else if (event.t === "scene") {
      if (!this.comparer.sceneCame(event.n) && this.sceneEnded(event.n)) this.sceneCame(event.scene);
    } else if (event.t === "object") {
      if (this.comparer.isOfKept(event.object.n) || project.peek()?.hand) return;
      state.object.value = event.object;
      if (!state.showsKept.peek()) this.view?.showObject(event.object);
    } else if (event.t === "drives") {
      if (!this.drives.came(event.n) || state.scene.peek()?.tour[state.at.peek() ?? -1]?.record !== event.record) return;
      state.drives.value = event;
      if (!state.showsKept.peek()) this.view?.showDrives(event);
    } else if (event.t === "pins" || event.t === "pulses") {
      this.pins.take(event);
    } else if (event.t === "analysis") {
      if (event.n === this.analysed?.n) state.analysis.value = event;
    } else if (event.t === "slice") {
      const skin = this.skins.came(event.slice.n);
      if (skin) this.skinCame(skin, event.slice.values);
      else if (!this.comparer.take(event.slice) && this.slicer.take(event.slice)) this.sliceCame(event.slice);
    } else if (event.t === "off") {
      state.stopping.value = state.playsNext.value = false;
      state.livesNext.value = undefined;
    } else if (event.t === "device") {
      state.device.value = event;
      this.followBoard(event);
    } else if (event.t === "studies") {
      this.study.came(event.n, event);
    } else if (event.t === "study") {
      this.study.show(event.shown);
    } else if (event.t === "live") {
      this.live.show(event.shown);
    } else if (event.t === "sizes") {
      state.sizes.value = { ...state.sizes.peek(), ...Object.fromEntries(event.sizes.map((each) => [each.name, each])) };
    } else if (event.t === "ways") {
      this.waysCame(event.n, event.ways);
    } else if (event.t === "failed") {
      this.failed(event);
    } else if (event.t === "error") {
      state.failure.value = event.error;
    } else if (event.t === "progress" || event.t === "done" || event.t === "stopped") {
      if (event.t === "progress" && event.line !== undefined) state.wrongLine.value = event.line;
      else this.worked(event);
    }
  }

  /** What mends the design that is refused stands wherever that is said. */
  private waysCame(n: number, ways: Remedy[]): void {
    const refused = state.refused.peek();
    if (n !== this.refused || !refused) return;
    const mended = { ...refused, ways };
    if (state.failure.peek() === refused) state.failure.value = mended;
    state.refused.value = mended;
  }

  private sceneCame(scene: Scene): void {
    this.dropped = undefined;
    if (!state.failure.peek()?.lasts) state.failure.value = undefined;
    if (state.scene.peek()?.name !== scene.name) {
      state.analysis.value = undefined;
      this.analysed = undefined;
    }
    state.scene.value = scene;
    this.unmark();
    if (!state.showsKept.peek()) this.showScene(scene, project.peek());
    this.slicer.ask(false);
  }

  private sliceCame(slice: Extract<Event, { t: "slice" }>["slice"]): void {
    const whole = slice.width === 200;
    if (whole) {
      this.askAnalysis();
      if (state.skin.peek()) this.askSkin();
    }
    this.view?.showSlice(slice, look.value);
    // Numbers are for reading: ten times a second is enough.
    const now = performance.now();
    if (now - this.told > 100 || whole) {
      this.told = now;
      state.slice.value = slice;
      state.latencyMs.value = this.slicer.latencyMs;
    }
    this.sliced(this.slicer.shown);
  }

  /** The present step has files that were just dropped. @param before  what their names stood for @param made  whether the step is new */
  hasDropped(before: Map<string, File | undefined>, made: boolean): void {
    this.dropped = { step: present.peek(), made, before };
    this.ask(); // a file of the same name may have new contents
  }

  /** What was there before a dropped file that cannot be read comes back; why stays to be read. @return whether it was one */
  private undrop(why: Failure): boolean {
    const { dropped } = this;
    const name = placeOf(why.where).replace(/, line \d+$/, "");
    const ofFile = dropped?.before.has(name) || (name.includes(".") && !why.remedies?.length); // or of one that it needs
    if (!dropped || dropped.step !== present.peek() || !ofFile) return false;
    this.dropped = undefined;
    for (const [name, file] of dropped.before) {
      this.sent.delete(name);
      if (!file) continue;
      this.sent.set(name, file);
      void this.link.sendFile(file).then(() => this.ask(), tell);
    }
    state.failure.value = { ...why, lasts: true };
    if (dropped.made) takeBack();
    this.ask();
    return true;
  }

  private worked(event: Extract<Event, { t: "progress" | "done" | "stopped" | "failed" }>): void {
    state.work.value = event;
    state.played.value = (event.t === "progress" && event.scene) || "";
  }

  private failed(event: Extract<Event, { t: "failed" }>): void {
    const { n, error } = event;
    if (this.study.fail(n, error) || this.live.fail(n, error)) return;
    const frame = this.hands.fail(n, error);
    if (frame === "older" || frame === "path") return;
    if (frame) {
      this.dropScene();
      state.refused.value = error;
      this.view?.showHand((state.hand.value = undefined));
      if (this.undrop(error)) return;
    }
    if (this.comparer.failed(n)) return;
    this.pins.fail(n);
    const ofScene = this.sceneEnded(n, error);
    if (ofScene && this.undrop(error)) return;
    if (!ofScene && !this.drives.came(n) && !this.skins.came(n) && this.slicer.fail(n) && state.showsKept.peek()) return this.comparer.resend();
    if (event.work) this.worked(event);
    state.playsNext.value = false;
    state.livesNext.value = undefined;
    state.failure.value = error;
  }
}
