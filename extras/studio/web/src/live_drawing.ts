// SPDX-License-Identifier: Apache-2.0
// A live session in the view: hands and object as clouds of particles, the lines on the skin, and the foci that play.
import { LineBasicMaterial, LineSegments, Matrix4, Points, PointsMaterial, Vector3 } from "three";
import { Drawing, geometryOf } from "./drawing";
import type { Drawn, LiveHand, LiveObject, LiveScene, Point } from "./link";

const fingerRadius = 7; // mm
const mostParticles = 4000; // of the object
const golden = 0.6180339887; // places that never repeat, and are the same in each frame

/** Particles on the surface of an object, the more the larger its triangles are. */
function onSurface({ vertices, triangles }: Drawn): number[] {
  const corner = (at: number): Vector3 => new Vector3().fromArray(vertices, 3 * (triangles[at] ?? 0));
  const faces = Array.from({ length: triangles.length / 3 }, (_, i) => {
    const origin = corner(3 * i);
    const [u, v] = [corner(3 * i + 1).sub(origin), corner(3 * i + 2).sub(origin)];
    return { origin, u, v, area: u.clone().cross(v).length() / 2 };
  });
  const each = faces.reduce((sum, { area }) => sum + area, 0) / mostParticles;
  const found: number[] = [];
  let owed = 0, n = 0;
  for (const { origin, u, v, area } of faces)
    for (owed += area; owed > each; owed -= each) {
      let [a, b] = [(++n * golden) % 1, (n * golden * golden) % 1];
      if (a + b > 1) [a, b] = [1 - a, 1 - b];
      found.push(...origin.clone().addScaledVector(u, a).addScaledVector(v, b).toArray());
    }
  return found;
}

/** Particles around a finger's bone. */
function aroundBone(from: Point, to: Point, found: number[]): void {
  const start = new Vector3(...from);
  const way = new Vector3(...to).sub(start);
  if (way.lengthSq() === 0) return;
  const side = new Vector3(way.z, way.x, way.y).cross(way).normalize();
  const other = way.clone().normalize().cross(side);
  for (let i = 0; i < 40; i++) {
    const turn = 2 * Math.PI * i * golden;
    found.push(...start.clone().addScaledVector(way, (i + 0.5) / 40).addScaledVector(side, fingerRadius * Math.cos(turn)).addScaledVector(other, fingerRadius * Math.sin(turn)).toArray());
  }
}

function onHand({ palm_mm: palm, fingers_mm: fingers }: LiveHand, found: number[]): void {
  for (const joints of fingers) joints.slice(1).forEach((joint, i) => aroundBone(joints[i] ?? joint, joint, found));
  // The palm lies between its middle and the knuckles, and as far on the other side.
  const middle = new Vector3(...palm);
  const knuckles = fingers.flatMap((joints) => (joints[0] ? [new Vector3(...joints[0]).sub(middle)] : []));
  knuckles.forEach((knuckle, i) => {
    const next = knuckles[(i + 1) % knuckles.length] ?? knuckle;
    for (let k = 0; k < 40; k++) {
      const along = (k * golden) % 1;
      found.push(...middle.clone().add(knuckle.clone().lerp(next, along).multiplyScalar(2 * Math.sqrt((k + 0.5) / 40) - 1)).toArray());
    }
  });
}

/** From an object's own frame to the array's. */
function poseOf({ center_mm: centre, x, z }: LiveObject): Matrix4 {
  const [right, up] = [new Vector3(...x), new Vector3(...z)];
  return new Matrix4().makeBasis(right, up.clone().cross(right), up).setPosition(...centre);
}

export class LiveDrawing extends Drawing {
  private object: { particles: number[]; back: Matrix4 } | undefined; // and from where it stood first to its own frame

  /** @param scene  none: no session  @param drawn  the object that is felt */
  show(scene: LiveScene | undefined, drawn: Drawn | undefined): void {
    this.clear();
    if (!scene) return void (this.object = undefined);
    const [now] = scene.objects; // the page's session has one
    if (now) this.object ??= { particles: drawn ? onSurface(drawn) : [], back: poseOf(now).invert() };
    const hands: number[] = [];
    for (const hand of scene.hands) onHand(hand, hands);
    const over = { depthTest: false, transparent: true };
    if (now && this.object) this.points(this.object.particles, 1.5, "--object", {}).applyMatrix4(poseOf(now).multiply(this.object.back));
    this.points(hands, 2, "--skin-edge", {});
    const lines = scene.contacts_mm.flatMap((line) => line.slice(1).flatMap((to, i) => [...(line[i] ?? to), ...to]));
    this.add(new LineSegments(geometryOf(new Float32Array(lines)), new LineBasicMaterial(over)), "--felt");
    this.points(scene.foci.flatMap(([x, y, z]) => [x, y, z]), 6, "--focus", over);
  }

  private points(places: number[], size: number, colour: string, more: object) {
    return this.add(new Points(geometryOf(new Float32Array(places)), new PointsMaterial({ size, sizeAttenuation: false, ...more })), colour);
  }
}
