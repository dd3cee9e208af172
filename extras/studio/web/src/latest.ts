// SPDX-License-Identifier: Apache-2.0
// Asks for the newest of what is wanted: one message is under way at a time, and of those that wait only the last is kept.
import type { Link } from "./link";

type Message = { t: string; [member: string]: unknown };

/** @template About  what the answer needs to be understood */
export class Latest<About> {
  private underWay: { n: number; about: About } | undefined;
  private wanted: { message: Message; about: About } | undefined;

  constructor(private readonly link: Link) {}

  ask(message: Message, about: About): void {
    this.wanted = { message, about };
    this.next();
  }

  isUnderWay(n: number): boolean {
    return this.underWay?.n === n;
  }

  /** What the answer, or the failure, of this number is about, if it is the one that is waited for. */
  came(n: number | undefined): About | undefined {
    const { underWay } = this;
    if (n === undefined || underWay?.n !== n) return undefined;
    this.underWay = undefined;
    this.next();
    return underWay.about;
  }

  /** What is under way will never come, and nothing more is wanted. */
  lose(): void {
    this.underWay = this.wanted = undefined;
  }

  private next(): void {
    const { wanted } = this;
    if (this.underWay !== undefined || wanted === undefined || !this.link.open) return;
    this.wanted = undefined;
    this.underWay = { n: this.link.send(wanted.message), about: wanted.about };
  }
}
