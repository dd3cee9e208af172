// SPDX-License-Identifier: Apache-2.0
// A hand in the view: its skin, the lines that are drawn on it, and the focal points of the pass. Lines and points are drawn over
// the skin, on which they lie.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, type Material, Mesh, MeshLambertMaterial, Points, PointsMaterial } from "three";
import type { DrawnHand } from "./link";

type Part = Mesh<BufferGeometry, MeshLambertMaterial> | LineSegments<BufferGeometry, LineBasicMaterial> | Points<BufferGeometry, PointsMaterial>;

function geometryOf(positions: Float32Array<ArrayBuffer>): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  return geometry;
}

export class HandDrawing {
  readonly group = new Group();
  private parts: { part: Part; colour: string }[] = [];

  /** @param hand  none: no hand */
  show(hand: DrawnHand | undefined): void {
    for (const { part } of this.parts) {
      part.geometry.dispose();
      (part.material as Material).dispose();
    }
    this.group.clear();
    this.parts = [];
    if (!hand) return;
    const skin = geometryOf(hand.skin);
    skin.computeVertexNormals();
    // Behind its own lines, which lie exactly in it.
    const behind = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.add(new Mesh(skin, new MeshLambertMaterial({ side: DoubleSide, ...behind })), "--skin", 0);
    const over = { depthTest: false, transparent: true };
    this.add(new LineSegments(geometryOf(hand.weak), new LineBasicMaterial(over)), "--weak", 1);
    this.add(new LineSegments(geometryOf(hand.felt), new LineBasicMaterial(over)), "--felt", 2);
    this.add(new Points(geometryOf(hand.foci), new PointsMaterial({ size: 4, sizeAttenuation: false, ...over })), "--focus", 3);
  }

  /** Takes the colours of the page's theme. */
  paint(colour: (name: string) => Color): void {
    for (const { part, colour: name } of this.parts) (part.material as LineBasicMaterial).color = colour(name);
  }

  private add(part: Part, colour: string, order: number): void {
    part.renderOrder = order;
    this.parts.push({ part, colour });
    this.group.add(part);
  }
}
