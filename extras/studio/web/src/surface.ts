// SPDX-License-Identifier: Apache-2.0
// Asks for the surface on which the field is so many decibels below its greatest value around the focal points. One is under way at
// a time; what was asked for meanwhile follows it.
import { STLLoader } from "three/addons/loaders/STLLoader.js";
import type { BufferGeometry } from "three";
import type { Link, Scene } from "./link";

/** What a surface is of: a scene, one of its records or, as 0, all of them, and how far it lies below the greatest value. */
export interface SurfaceOf {
  scene: Scene;
  record: number;
  belowDb: number;
}

const most = 150_000; // points of the volume
const mostTerms = 9e9; // points × elements × records, which the server must compute
const aside = 25; // mm around the focal points, and more along the axis, in which a focus is long
const ahead = 45;

/** The volume around the focal points, as ranges along the axes, and the step between its points, mm. */
export function volumeOf({ foci, array }: Scene, record: number): Record<string, string> {
  const ends = [0, 1, 2].map((axis) => {
    const along = foci.map((focus) => focus[axis] ?? 0);
    const margin = axis === 2 ? ahead : aside;
    return [Math.min(...along) - margin, Math.max(...along) + margin] as const;
  });
  const [x, y, z] = ends as [readonly [number, number], readonly [number, number], readonly [number, number]];
  const points = Math.min(most, mostTerms / (array.elements.length * (record === 0 ? foci.length : 1)));
  const low = Math.max(5, z[0]);
  const step = Math.max(0.5, Math.cbrt(((x[1] - x[0]) * (y[1] - y[0]) * (z[1] - low)) / points));
  const range = (from: number, to: number): string => `${from.toFixed(3)}:${to.toFixed(3)}`;
  return { x: range(...x), y: range(...y), z: range(low, z[1]), step: step.toFixed(4) };
}

export class Surfaces {
  private wanted: SurfaceOf | undefined;
  private underWay = false;

  constructor(
    private readonly link: Link,
    private readonly show: (surface: BufferGeometry | undefined) => void,
    private readonly wrong: (error: unknown) => void,
    /** Told whether one is still to come. */
    private readonly busy: (busy: boolean) => void,
  ) {}

  /** @param of  none: no surface */
  ask(of: SurfaceOf | undefined): void {
    this.wanted = of;
    if (!of) this.show(undefined);
    if (!this.underWay) void this.next();
  }

  private async next(): Promise<void> {
    this.underWay = true;
    this.busy(true);
    for (let of = this.wanted; of; of = this.wanted === of ? undefined : this.wanted) {
      try {
        const { scene, record, belowDb } = of;
        const query = { scene: scene.name, ...(record === 0 ? {} : { record: String(record) }), ...volumeOf(scene, record), quantity: "rms", as: "stl", below: String(belowDb) };
        const file = await (await this.link.field(query)).arrayBuffer();
        if (this.wanted === of) this.show(new STLLoader().parse(file));
      } catch (error) {
        if (this.wanted === of) this.wrong(error);
      }
    }
    this.underWay = false;
    this.busy(false);
  }
}
