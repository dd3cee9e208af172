// SPDX-License-Identifier: Apache-2.0
// Asks for frames of a hand, of which the newest is waited for, and for rendered paths.
import { having, type ProjectDocument } from "./document";
import { Latest } from "./latest";
import type { Drawn, DrawnHand, Event, Failure, HandFrame, Link, RenderedPath } from "./link";

/** What is rendered when the whole recording is: the document without its frame, and without what only a frame has. */
export function ofAllFrames(document: ProjectDocument): ProjectDocument {
  const { frame: _, ...hand } = document.hand ?? { recording: "" };
  return having(document, { hand, points: undefined });
}

export interface HandShown {
  hand: HandFrame;
  drawn: DrawnHand | undefined;
  /** anew, unless it is as it was */
  object: Drawn | undefined;
}

export class HandReader {
  private readonly frames: Latest<string>; // the document that a frame is of
  private readonly objects = new Map<number, Drawn>();
  private readonly skins = new Map<number, DrawnHand>();
  private object = ""; // that the page has drawn
  private rendering: { n: number; done: (path: RenderedPath) => void; failed: (failure: Failure) => void } | undefined;

  constructor(
    private readonly link: Link,
    /** Told of each frame that came, and whether it is of the document that was asked for last. */
    private readonly show: (shown: HandShown, newest: boolean) => void,
  ) {
    this.frames = new Latest(link);
  }

  private asked = "";

  ask(document: ProjectDocument): void {
    this.asked = JSON.stringify(document);
    this.frames.ask({ t: "hand", document, drawn: this.object }, this.asked);
  }

  /** @return whether the message was for this reader */
  take(event: Event): boolean {
    if (event.t === "object") {
      if (!this.frames.isUnderWay(event.object.n)) return false;
      this.objects.set(event.object.n, event.object);
      return true;
    }
    if (event.t === "skin") {
      if (this.frames.isUnderWay(event.skin.n)) this.skins.set(event.skin.n, event.skin);
      return true;
    }
    if (event.t === "path") {
      if (event.n === this.rendering?.n) this.rendering.done(event);
      return true;
    }
    if (event.t !== "hand") return false;
    const shown = { hand: event, drawn: this.skins.get(event.n), object: this.objects.get(event.n) };
    this.objects.clear();
    this.skins.clear();
    this.object = event.drawn;
    const of = this.frames.came(event.n);
    if (of !== undefined) this.show(shown, of === this.asked);
    return true;
  }

  /** @return whether it was a frame that failed, and of which document it was: the one that was asked for last, or an older one */
  fail(n: number | undefined, failure: Failure): "newest" | "older" | "path" | undefined {
    if (n !== undefined && n === this.rendering?.n) {
      this.rendering.failed(failure);
      return "path";
    }
    const of = this.frames.came(n);
    return of === undefined ? undefined : of === this.asked ? "newest" : "older";
  }

  /** Renders a document's hand: its frame, or, without one, all of them. A newer call takes the place of an older one. */
  async render(document: ProjectDocument): Promise<RenderedPath> {
    this.rendering?.failed({ where: "", message: "another rendering was asked for" });
    try {
      return await new Promise((done, failed) => {
        const n = this.link.send({ t: "path", document });
        this.rendering = { n, done, failed: ({ where, message }) => failed(new Error(where ? `${where}: ${message}` : message)) };
      });
    } finally {
      this.rendering = undefined;
    }
  }

  /** Another object is drawn. */
  forget(): void {
    this.object = "";
  }

  /** What is under way will never come. */
  lose(): void {
    this.forget();
    this.frames.lose();
    this.rendering?.failed({ where: "", message: "the server was lost; try again" });
  }
}
