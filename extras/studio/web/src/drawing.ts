// SPDX-License-Identifier: Apache-2.0
// What is drawn anew as a whole, in the colours of the page's theme.
import { BufferAttribute, BufferGeometry, type Color, Group, type LineBasicMaterial, type LineSegments, type Material, type Mesh, type MeshLambertMaterial, type Points, type PointsMaterial } from "three";

type Part = Mesh<BufferGeometry, MeshLambertMaterial> | LineSegments<BufferGeometry, LineBasicMaterial> | Points<BufferGeometry, PointsMaterial>;

export function geometryOf(positions: Float32Array<ArrayBuffer>): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  return geometry;
}

export class Drawing {
  readonly group = new Group();
  private parts: { part: Part; colour: string }[] = [];

  /** Takes the colours of the page's theme. */
  paint(colour: (name: string) => Color): void {
    for (const { part, colour: name } of this.parts) part.material.color = colour(name);
  }

  protected clear(): void {
    for (const { part } of this.parts) {
      part.geometry.dispose();
      (part.material as Material).dispose();
    }
    this.group.clear();
    this.parts = [];
  }

  /** Drawn over those before it. */
  protected add(part: Part, colour: string): Part {
    part.renderOrder = this.parts.length;
    this.parts.push({ part, colour });
    this.group.add(part);
    return part;
  }
}
