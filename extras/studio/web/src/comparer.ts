// SPDX-License-Identifier: Apache-2.0
// Keeps the profiles of the present scene and of the kept one up to date. The server keeps few scenes, so the kept one is
// sent again when it has been dropped.
import { effect } from "@preact/signals";
import { Latest } from "./latest";
import type { Link, Point, SliceData } from "./link";
import { line } from "./plot";
import { endsOf, profileMessage, valuesOf } from "./profile";
import { type Profile, shownRecord, state } from "./state";

type Ends = { from: Point; to: Point };

export class Comparer {
  private readonly now: Latest<Ends>;
  private readonly kept: Latest<Ends>;
  private resent: number | undefined; // the kept document, sent again

  /** @param again  called when the kept scene can be asked for again */
  constructor(
    private readonly link: Link,
    private readonly again: () => void,
  ) {
    this.now = new Latest(link);
    this.kept = new Latest(link);
    effect(() => this.ask());
  }

  /** @return whether the slice was one of the profiles */
  take(slice: SliceData): boolean {
    const now = this.now.came(slice.n);
    const kept = now ? undefined : this.kept.came(slice.n);
    const ends = now ?? kept;
    if (!ends) return false;
    const profile: Profile = { ...ends, skinPerSquare: slice.skinPerSquare, values: valuesOf(slice) };
    const both = state.profiles.peek();
    state.profiles.value = now ? { ...both, now: profile } : { ...both, kept: state.kept.peek() && profile };
    return true;
  }

  /** @return whether it was one of ours that failed */
  failed(n: number | undefined): boolean {
    if (this.now.came(n)) return true; // its scene has been replaced; the next one asks again
    if (!this.kept.came(n)) return false;
    this.resend();
    return true;
  }

  resend(): void {
    const kept = state.kept.peek();
    if (kept) this.resent = this.link.send({ t: "scene", document: kept.document });
  }

  /** @return whether the scene, or its object, is the kept one that was sent again */
  isOfKept(n: number): boolean {
    return n === this.resent;
  }

  sceneCame(n: number): boolean {
    if (!this.isOfKept(n)) return false;
    this.ask();
    this.again();
    return true;
  }

  lose(): void {
    this.now.lose();
    this.kept.lose();
    this.resent = undefined;
  }

  private ask(): void {
    const scene = state.scene.value;
    const kept = state.kept.value;
    const marked = scene?.tour[state.at.value ?? -1];
    const ends = endsOf(line.value, marked?.at ?? state.middle.value);
    if (scene && state.current.value) this.now.ask(profileMessage(scene.name, shownRecord.value, ends, 1), ends);
    if (kept) this.kept.ask(profileMessage(kept.scene.name, 0, ends, 2), ends);
    else if (state.profiles.peek().kept) state.profiles.value = { ...state.profiles.peek(), kept: undefined };
  }
}
