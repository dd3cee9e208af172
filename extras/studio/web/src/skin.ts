// SPDX-License-Identifier: Apache-2.0
// The field on the skin of a hand: its triangles, whose corners get values from the engine, in the colours of the plane.
import { BufferAttribute, BufferGeometry, DoubleSide, Group, type IUniform, Mesh, ShaderMaterial } from "three";

/** Triangles of corners that are there once. */
export interface Skin {
  /** x, y, z of each, mm, to a micrometre */
  points: number[];
  index: number[];
}

/** @param corners  x, y, z of three for each triangle */
export function welded(corners: ArrayLike<number>, by: { x: number; y: number; z: number }): Skin {
  const known = new Map<string, number>();
  const skin: Skin = { points: [], index: [] };
  for (let i = 0; i + 2 < corners.length; i += 3) {
    const point = [by.x, by.y, by.z].map((each, axis) => Math.round(1000 * (each + (corners[i + axis] ?? 0))) / 1000);
    const name = point.join();
    const at = known.get(name) ?? known.size;
    if (at === known.size) {
      known.set(name, at);
      skin.points.push(...point);
    }
    skin.index.push(at);
  }
  return skin;
}

const vertexShader = `
  attribute float square;
  varying float value;
  void main() {
    value = square;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

export class SkinDrawing {
  readonly group = new Group();
  private readonly material: ShaderMaterial;

  /** @param colouring  GLSL that has vec3 colourOf(float square), of the uniforms */
  constructor(uniforms: Record<string, IUniform>, colouring: string) {
    const fragmentShader = `${colouring}
  varying float value;
  void main() {
    gl_FragColor = vec4(colourOf(value), 1.0);
  }`;
    // Before the plane, in which a palm may lie.
    this.material = new ShaderMaterial({ side: DoubleSide, uniforms, vertexShader, fragmentShader, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
  }

  /** @param squares  mean square pressure at each point */
  show(skin: Skin, squares: Float32Array<ArrayBuffer>): void {
    this.clear();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(skin.points), 3));
    geometry.setAttribute("square", new BufferAttribute(squares, 1));
    geometry.setIndex(skin.index);
    this.group.add(new Mesh(geometry, this.material));
  }

  clear(): void {
    for (const part of this.group.children) (part as Mesh).geometry.dispose();
    this.group.clear();
  }
}
