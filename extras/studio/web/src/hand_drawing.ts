// SPDX-License-Identifier: Apache-2.0
// A hand in the view: its skin, the lines that are drawn on it, and the focal points of the pass. Lines and points are drawn over
// the skin, on which they lie.
import { DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Points, PointsMaterial } from "three";
import { Drawing, geometryOf } from "./drawing";
import type { DrawnHand } from "./link";

export class HandDrawing extends Drawing {
  /** @param hand  none: no hand */
  show(hand: DrawnHand | undefined): void {
    this.clear();
    if (!hand) return;
    const skin = geometryOf(hand.skin);
    skin.computeVertexNormals();
    // Behind its own lines, which lie exactly in it.
    const behind = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.add(new Mesh(skin, new MeshLambertMaterial({ side: DoubleSide, ...behind })), "--skin");
    const over = { depthTest: false, transparent: true };
    this.add(new LineSegments(geometryOf(hand.weak), new LineBasicMaterial(over)), "--weak");
    this.add(new LineSegments(geometryOf(hand.felt), new LineBasicMaterial(over)), "--felt");
    this.add(new Points(geometryOf(hand.foci), new PointsMaterial({ size: 4, sizeAttenuation: false, ...over })), "--focus");
  }
}
