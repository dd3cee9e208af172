// SPDX-License-Identifier: Apache-2.0
// Where x, y and z lead, as three lines with letters beside the array.
import { BufferGeometry, CanvasTexture, type Color, Group, Line, LineBasicMaterial, SRGBColorSpace, Sprite, SpriteMaterial, Vector3 } from "three";

const length = 40; // mm
const names = ["x", "y", "z"] as const;

export class Axes {
  readonly group = new Group();
  private readonly parts = names.map((name, i) => {
    const end = new Vector3().setComponent(i, length);
    const line = new Line(new BufferGeometry().setFromPoints([new Vector3(), end]), new LineBasicMaterial());
    const letter = new Sprite(new SpriteMaterial({ sizeAttenuation: false }));
    letter.position.copy(end).multiplyScalar(1.2);
    letter.scale.setScalar(0.035);
    this.group.add(line, letter);
    return { name, line, letter };
  });

  paint(colour: (name: string) => Color): void {
    for (const { name, line, letter } of this.parts) {
      line.material.color = colour(`--axis-${name}`);
      letter.material.map?.dispose();
      letter.material.needsUpdate = true; // it may have been drawn without a map
      letter.material.map = Object.assign(new CanvasTexture(drawn(name, `#${line.material.color.getHexString()}`)), { colorSpace: SRGBColorSpace });
    }
  }
}

function drawn(name: string, colour: string): HTMLCanvasElement {
  const canvas = Object.assign(document.createElement("canvas"), { width: 64, height: 64 });
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  Object.assign(context, { fillStyle: colour, font: "600 52px sans-serif", textAlign: "center", textBaseline: "middle" });
  context.fillText(name, 32, 32);
  return canvas;
}
