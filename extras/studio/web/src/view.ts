// SPDX-License-Identifier: Apache-2.0
// The 3-D view: array, object, foci, tour and a plane that shows the field. Millimetres, z up. It draws when something has
// changed, and not otherwise.
import {
  AmbientLight, BufferAttribute, BufferGeometry, CircleGeometry, Color, DataTexture, DirectionalLight, DoubleSide, FloatType, Frustum, Group, InstancedMesh,
  Line, LineBasicMaterial, LineLoop, LineSegments, LinearFilter, type Material, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, NearestFilter,
  type Object3D, PerspectiveCamera, Plane, PlaneGeometry, Points, PointsMaterial, Raycaster, RedFormat, Scene as World, ShaderMaterial, Vector2, Vector3,
  WebGLRenderer, Box3,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import { Axes } from "./axes";
import { type ColourMap, phaseColour, table } from "./colours";
import { geometryOf } from "./drawing";
import { HandDrawing } from "./hand_drawing";
import { LiveDrawing } from "./live_drawing";
import type { ArrayOf, Drawn, DrawnHand, Drives, LiveScene, Outline, Point, Scene, SliceData } from "./link";
import { type Look, quantities } from "./quantity";
import { type Skin, SkinDrawing, welded } from "./skin";

export type Orientation = "xy" | "xz" | "yz";

/** Where the plane is: its middle, millimetres, how it is turned as a quaternion, and how large it is. */
export interface PlanePlace {
  middle: Point;
  turn: number[];
  scale: number[];
}

/** A corner of the plane and the edges that begin there, millimetres. */
export interface Edges {
  origin: Point;
  u: Point;
  v: Point;
}

const vertexShader = `
  varying vec2 place;
  void main() {
    place = uv;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

// Mean square pressure to a place on the colour map: linear, by its root, or in decibels below the top. What is above the top is hatched.
const colouring = `
  uniform sampler2D colours;
  uniform float top, range;
  uniform int root;
  vec3 colourOf(float square) {
    float part = max(square / top, 1e-20);
    float level = range > 0.0 ? 1.0 + 4.342944819 * log(part) / range : (root == 1 ? sqrt(part) : part);
    vec3 colour = texture2D(colours, vec2(clamp(level, 0.002, 0.998), 0.5)).rgb;
    return level > 1.001 && mod(gl_FragCoord.x + gl_FragCoord.y, 10.0) < 3.0 ? vec3(1.0) - colour : colour;
  }`;

// The slice's first and last points lie on the edges, but the first and last texels beside them.
const fragmentShader = `${colouring}
  varying vec2 place;
  uniform sampler2D field;
  uniform float points;
  void main() {
    gl_FragColor = vec4(colourOf(texture2D(field, (place * (points - 1.0) + 0.5) / points).r), 0.94);
  }`;

function flat(points: Point[]): Float32Array<ArrayBuffer> {
  return new Float32Array(points.flat());
}

export class View {
  readonly canvas: HTMLCanvasElement;
  /** Called when the plane was moved. */
  moved: () => void = () => {};
  /** Called when the plane was let go by its handles, with where it was before. */
  letGo: (before: PlanePlace) => void = () => {};
  /** Called while the object is moved or turned by its handles, and once more when it is let go. */
  objectMoved: (centre: Point, turnDeg: Point, done: boolean) => void = () => {};
  /** Called when it has changed how many millimetres a pixel is in the middle of the view. */
  scaled: (mmPerPixel: number) => void = () => {};
  /** Called with whether nothing of the object is in the view, whenever it is drawn. */
  outside: (outside: boolean) => void = () => {};
  /** Called when the pointer is over the plane, with the place in millimetres and the mean square pressure there; and when it has left. */
  probed: (found: { at: Point; square: number } | undefined) => void = () => {};

  private readonly orbit: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly world = new World();
  private readonly camera = new PerspectiveCamera(38, 1, 1, 4000);
  private readonly gizmo: TransformControls;
  private readonly plane = new Group();
  private readonly sheet: Mesh<PlaneGeometry, ShaderMaterial>;
  private readonly frame: LineLoop<BufferGeometry, LineBasicMaterial>;
  private readonly array = new Group();
  private discs: InstancedMesh<CircleGeometry, MeshBasicMaterial> | undefined;
  private drives: Drives | undefined;
  private readonly object = new Group();
  private readonly surface = new Group();
  private readonly path = new Group();
  private readonly hand = new HandDrawing();
  private readonly live = new LiveDrawing();
  private drawn: Drawn | undefined;
  private readonly outline = new Group();
  private readonly stroke = new Group();
  private readonly axes = new Axes();
  private readonly pivot = new Group();
  private middleOfAll = new Vector3();
  private readonly boxOfObject = new Box3();
  private centreOfOne: Vector3 | undefined;
  private readonly focus: Points<BufferGeometry, PointsMaterial>;
  private readonly uniforms = {
    field: { value: null as DataTexture | null }, colours: { value: null as DataTexture | null }, points: { value: 2 }, top: { value: 1 }, range: { value: 0 }, root: { value: 0 },
  };
  private readonly skin = new SkinDrawing(this.uniforms, colouring);
  /** Corners of the skin of a hand that has no place of its own, and of one that has. */
  private palm: number[] | undefined;
  private touching: Float32Array<ArrayBuffer> | undefined;
  private slice: SliceData | undefined;
  private shownColours: ColourMap | undefined;
  private pointer: Vector2 | undefined;
  private texture: DataTexture | undefined;
  private taken: PlanePlace | undefined;
  private waiting = false;

  /** @throws Error when the browser has no WebGL 2 */
  constructor(host: HTMLElement) {
    this.canvas = document.createElement("canvas");
    // Smooth edges cost a third of the frames where the processor draws, and such a browser gives no context here.
    const fast = this.canvas.getContext("webgl2", { antialias: true, failIfMajorPerformanceCaveat: true });
    this.renderer = new WebGLRenderer(fast ? { canvas: this.canvas, context: fast } : { canvas: this.canvas, antialias: false });
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "3-D view of the array, the object, its focal points and the field on a plane");
    this.canvas.tabIndex = 0;
    host.append(this.canvas);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(260, -400, 340);
    const orbit = new OrbitControls(this.camera, this.canvas);
    orbit.target.set(0, 0, 75);
    orbit.update();
    orbit.addEventListener("change", () => this.tellScale());
    this.orbit = orbit;

    const sun = new DirectionalLight(0xffffff, 2);
    sun.position.set(1, -2, 3);
    this.world.add(new AmbientLight(0xffffff, 1.6), sun, this.array, this.object, this.surface, this.path, this.hand.group, this.live.group, this.outline, this.skin.group, this.stroke, this.plane, this.axes.group);

    const { uniforms } = this;
    this.sheet = new Mesh(new PlaneGeometry(1, 1), new ShaderMaterial({ side: DoubleSide, transparent: true, uniforms, vertexShader, fragmentShader }));
    this.sheet.visible = false;
    const corners: Point[] = [[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]];
    this.frame = new LineLoop(geometryOf(flat(corners)), new LineBasicMaterial());
    this.plane.add(this.sheet, this.frame);
    this.pivot.rotation.order = "ZYX"; // about x, then y, then z, as a project file says it
    this.focus = new Points(geometryOf(new Float32Array(3)), new PointsMaterial({ size: 12, sizeAttenuation: false, depthTest: false, transparent: true }));
    this.focus.renderOrder = 1; // over the plane, which is drawn late, too
    this.focus.visible = false;
    this.world.add(this.pivot, this.focus);
    this.gizmo = new TransformControls(this.camera, this.canvas);
    this.gizmo.attach(this.plane);
    this.gizmo.setSize(0.45);
    this.gizmo.addEventListener("dragging-changed", (event) => {
      orbit.enabled = !event.value;
      if (this.gizmo.object === this.plane) {
        if (event.value) this.taken = this.planePlace;
        else if (this.taken) this.letGo(this.taken);
      }
      if (!event.value && this.gizmo.object === this.pivot) this.tellObject(true);
    });
    this.gizmo.addEventListener("change", () => this.redraw());
    this.gizmo.addEventListener("objectChange", () => (this.gizmo.object === this.pivot ? this.tellObject(false) : this.moved()));
    this.world.add(this.gizmo.getHelper());
    this.place("xy", [0, 0, 130]);

    this.canvas.addEventListener("pointermove", (event) => {
      this.pointer = this.onCanvas(event.clientX, event.clientY);
      this.redraw();
    });
    this.canvas.addEventListener("pointerleave", () => {
      this.pointer = undefined;
      this.redraw();
    });
    this.canvas.addEventListener("webglcontextrestored", () => this.redraw());
    new ResizeObserver(() => this.fit(host)).observe(host);
    this.fit(host);
    this.paint();
  }

  /** Puts the plane parallel to two axes, with its middle at a point. */
  place(orientation: Orientation, middle: Point): void {
    this.plane.rotation.set(orientation === "xy" ? 0 : Math.PI / 2, orientation === "yz" ? Math.PI / 2 : 0, 0, "YXZ");
    this.plane.scale.set(160, 160, 1);
    this.plane.position.set(...middle);
    this.redraw();
  }

  get planePlace(): PlanePlace {
    const { position, quaternion, scale } = this.plane;
    return { middle: position.toArray(), turn: quaternion.toArray(), scale: scale.toArray() };
  }
  set planePlace({ middle, turn, scale }: PlanePlace) {
    this.plane.position.fromArray(middle);
    this.plane.quaternion.fromArray(turn as [number, number, number, number]);
    this.plane.scale.fromArray(scale as Point);
    this.redraw();
  }

  get middle(): Point {
    return this.plane.position.toArray();
  }
  set middle(middle: Point) {
    this.plane.position.set(...middle);
    this.redraw();
  }

  set turning(on: boolean) {
    this.gizmo.setMode(on ? "rotate" : "translate");
    this.redraw();
  }

  /** Whether the pointer draws instead of turning the view. */
  set drawing(on: boolean) {
    this.orbit.enabled = this.gizmo.enabled = this.gizmo.getHelper().visible = !on;
    this.canvas.setAttribute("role", on ? "application" : "img");
    this.canvas.setAttribute("aria-label", on ? "The plane, to draw on: arrow keys move the pen, Enter begins and ends the line" : "3-D view of the array, the object, its focal points and the field on a plane");
    this.redraw();
  }

  /** What of the plane, however far it goes on, is at a place of the page; nothing where it is not seen. */
  onPlane(clientX: number, clientY: number): Point | undefined {
    const ray = new Raycaster();
    ray.setFromCamera(this.onCanvas(clientX, clientY), this.camera);
    const normal = new Vector3(0, 0, 1).applyQuaternion(this.plane.quaternion);
    return ray.ray.intersectPlane(new Plane().setFromNormalAndCoplanarPoint(normal, this.plane.position), new Vector3())?.toArray();
  }

  /** @return the place so many millimetres beside another, along the plane's edges */
  besideOnPlane(at: Point, right: number, up: number): Point {
    const way = new Vector3(right, up, 0).applyQuaternion(this.plane.quaternion);
    return at.map((each, i) => Math.round((each + way.getComponent(i)) * 1e6) / 1e6) as Point;
  }

  /** A line that is being drawn by hand; without places, none. */
  showStroke(places: Point[]): void {
    this.clear(this.stroke);
    if (places.length > 1) {
      const line = new Line(geometryOf(flat(places)), new LineBasicMaterial({ depthTest: false }));
      line.renderOrder = 1;
      line.userData["colour"] = "--focus";
      this.stroke.add(line);
    }
    this.paint();
  }

  /** What the handles move. */
  set handles(of: "plane" | "object") {
    this.gizmo.attach(of === "plane" ? this.plane : this.pivot);
    this.redraw();
  }

  /** How the object is turned, so that its handles go on from there. */
  set turn(degrees: Point) {
    if (this.gizmo.dragging) return;
    this.pivot.rotation.set(...(degrees.map((each) => (each * Math.PI) / 180) as Point), "ZYX");
    this.redraw();
  }

  /** Marks the focal point of the scrubber. */
  showFocus(at: Point | undefined): void {
    // A board says every few moments where it is, and mostly that is where it was.
    const { focus } = this;
    if (focus.visible === (at !== undefined) && (!at || focus.position.equals(new Vector3(...at)))) return;
    focus.visible = at !== undefined;
    if (at) focus.position.set(...at);
    this.redraw();
  }

  /** Rounded to a picometre, so that a plane along the axes has edges along the axes. */
  edges(): Edges {
    this.plane.updateMatrixWorld();
    const corner = (x: number, y: number): Vector3 => new Vector3(x, y, 0).applyMatrix4(this.plane.matrixWorld);
    const round = (vector: Vector3): Point => vector.toArray().map((each) => Math.round(each * 1e9) / 1e9) as Point;
    const origin = corner(-0.5, -0.5);
    return { origin: round(origin), u: round(corner(0.5, -0.5).sub(origin)), v: round(corner(-0.5, 0.5).sub(origin)) };
  }

  showArray({ elements, radius_mm: radius }: ArrayOf): void {
    this.clear(this.array);
    const discs = new InstancedMesh(new CircleGeometry(radius, 20), new MeshBasicMaterial({ side: DoubleSide }), elements.length);
    elements.forEach((element, i) => discs.setMatrixAt(i, new Matrix4().makeTranslation(...element)));
    const corner = (along: 0 | 1): number => Math.min(...elements.map((element) => element[along])) - 12;
    this.axes.group.position.set(corner(0), corner(1), 0);
    this.array.add(discs);
    this.discs = discs;
    this.drives = undefined;
    this.paint();
  }

  /** @param tour  whether its focal points are drawn, in their order */
  showScene(scene: Scene, tour: boolean): void {
    this.showArray(scene.array);
    this.clear(this.path);
    const first = tour ? scene.foci[0] : undefined;
    if (first) {
      const line = new Line(geometryOf(flat([...scene.foci, first])), new LineBasicMaterial());
      line.userData["colour"] = "--tour";
      const foci = new Points(geometryOf(flat(scene.foci)), new PointsMaterial({ size: 5, sizeAttenuation: false }));
      foci.userData["colour"] = "--focus";
      this.path.add(line, foci);
    }
    this.paint();
  }

  /** Colours the discs by what they do while a record plays; without drives they are as they are. */
  showDrives(drives: Drives | undefined): void {
    this.drives = drives;
    this.paintDiscs();
    this.redraw();
  }

  private paintDiscs(): void {
    const { discs, drives } = this;
    if (!discs) return;
    const off = new Color(getComputedStyle(document.documentElement).getPropertyValue("--array").trim());
    for (let i = 0; i < discs.count; i++) {
      const phase = drives?.phases_deg[i];
      discs.setColorAt(i, phase === undefined ? off : off.clone().lerp(phaseColour(phase), Math.min(1, drives?.amplitudes[i] ?? 0)));
    }
    if (discs.instanceColor) discs.instanceColor.needsUpdate = true;
  }

  showObject(drawn: Drawn): void {
    this.drawn = drawn;
    this.skin.clear();
    this.clear(this.object);
    const surface = geometryOf(drawn.vertices);
    surface.setIndex(new BufferAttribute(drawn.triangles, 1));
    // Both sides in one pass: they have one colour, and where the processor draws, it takes half the time.
    const skin = new Mesh(surface, new MeshLambertMaterial({ side: DoubleSide, forceSinglePass: true, flatShading: true, transparent: true, opacity: 0.3, depthWrite: false }));
    const lines = new LineSegments(geometryOf(drawn.segments), new LineBasicMaterial());
    const points = new Points(geometryOf(drawn.points), new PointsMaterial({ size: 2, sizeAttenuation: false }));
    for (const part of [skin, lines, points]) part.userData["colour"] = "--object";
    this.object.add(skin, lines, points);
    const box = this.boxOfObject.setFromObject(this.object);
    if (!box.isEmpty()) this.middleOfAll = box.getCenter(new Vector3());
    this.placePivot();
    this.paint();
  }

  /** A hand and what it feels; without one, none. */
  showHand(hand: DrawnHand | undefined): void {
    this.hand.show(hand);
    this.touching = hand && hand.skin.length > 0 ? hand.skin : undefined;
    this.skin.clear();
    this.paint();
  }

  /** What a live session sees and plays, in place of what stands still; without one, that again. */
  showLive(scene: LiveScene | undefined): void {
    this.live.show(scene, this.drawn);
    for (const each of [this.object, this.path, this.hand.group, this.skin.group, this.plane, this.gizmo.getHelper()]) each.visible = scene === undefined;
    this.paint();
  }

  /** The outline of a hand whose palm is where the object is, as a scale; or none. */
  showOutline(hand: Outline | undefined): void {
    this.clear(this.outline);
    this.palm = hand?.skin;
    this.skin.clear();
    if (hand) {
      const lines = new LineSegments(geometryOf(flat(hand.segments)), new LineBasicMaterial());
      lines.userData["colour"] = "--skin-edge";
      this.outline.add(lines);
    }
    this.placePivot();
    this.paint();
  }

  /** The skin that the view has, where it is: that of the hand which touches, or else of the one for scale. */
  skinThere(): Skin | undefined {
    if (this.touching) return welded(this.touching, new Vector3());
    return this.palm && welded(this.palm, this.outline.position);
  }

  /** The field on that skin, as far as it is still there; or none. */
  showSkin(of: { skin: Skin; squares: Float32Array<ArrayBuffer> } | undefined): void {
    if (of) this.skin.show(of.skin, of.squares);
    else this.skin.clear();
    this.redraw();
  }

  /** No scene: neither focal points nor a field. */
  clearScene(): void {
    this.clear(this.path);
    this.skin.clear();
    this.sheet.visible = false;
    this.slice = undefined;
    this.redraw();
  }

  /** The surface of one value of the field, in place of the one before. */
  showSurface(geometry: BufferGeometry | undefined): void {
    this.clear(this.surface);
    if (geometry) {
      const skin = new Mesh(geometry, new MeshLambertMaterial({ side: DoubleSide, transparent: true, opacity: 0.6 }));
      skin.userData["colour"] = "--surface";
      this.surface.add(skin);
    }
    this.paint();
  }

  /** Where the handles of the object begin: at the centre of one of several, or, without it, of all together. */
  set centre(centre: Point | undefined) {
    this.centreOfOne = centre && new Vector3(...centre);
    this.placePivot();
    this.redraw();
  }

  private placePivot(): void {
    this.outline.position.copy(this.middleOfAll);
    if (!this.gizmo.dragging) this.pivot.position.copy(this.centreOfOne ?? this.middleOfAll);
  }

  showSlice(slice: SliceData, shown: Look): void {
    this.slice = slice;
    const { texture } = this;
    if (texture?.image.width === slice.width && texture.image.height === slice.height) {
      texture.image.data = slice.values;
      texture.needsUpdate = true;
    } else {
      texture?.dispose();
      this.texture = new DataTexture(slice.values, slice.width, slice.height, RedFormat, FloatType);
      const smooth = this.renderer.extensions.has("OES_texture_float_linear");
      this.texture.minFilter = this.texture.magFilter = smooth ? LinearFilter : NearestFilter;
      this.texture.needsUpdate = true;
    }
    this.uniforms.field.value = this.texture ?? null;
    this.uniforms.points.value = slice.width;
    this.sheet.visible = slice.greatest > 0;
    this.showLook(shown);
  }

  showLook({ quantity, colours, rangeDb, top }: Look): void {
    const { uniforms } = this;
    uniforms.top.value = top ?? this.slice?.greatest ?? 1;
    uniforms.range.value = quantities[quantity].decibels ? rangeDb : 0;
    uniforms.root.value = quantity === "rms" ? 1 : 0;
    if (colours !== this.shownColours) {
      uniforms.colours.value?.dispose();
      const texture = new DataTexture(table(colours), 256, 1);
      texture.minFilter = texture.magFilter = LinearFilter;
      texture.needsUpdate = true;
      uniforms.colours.value = texture;
      this.shownColours = colours;
    }
    this.redraw();
  }

  /** Takes the colours of the page's theme. */
  paint(): void {
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string): Color => new Color(style.getPropertyValue(name).trim());
    this.world.background = colour("--view");
    this.frame.material.color = colour("--frame");
    this.focus.material.color = colour("--stop");
    this.hand.paint(colour);
    this.live.paint(colour);
    this.axes.paint(colour);
    this.gizmo.setColors(colour("--axis-x"), colour("--axis-y"), colour("--axis-z"), colour("--accent"));
    this.paintDiscs();
    for (const group of [this.object, this.surface, this.path, this.outline, this.stroke])
      for (const part of group.children)
        (part as Mesh<BufferGeometry, MeshBasicMaterial>).material.color = colour(part.userData["colour"] as string);
    this.redraw();
  }

  /** Looks at the array, the object and the plane as a whole, from where it looked. */
  frameAll(): void {
    const box = new Box3();
    for (const group of [this.array, this.object, this.path, this.hand.group, this.outline, this.plane]) box.expandByObject(group);
    if (box.isEmpty()) return;
    const middle = box.getCenter(new Vector3());
    const radius = box.getSize(new Vector3()).length() / 2;
    const narrowest = Math.min(1, this.camera.aspect) * Math.tan((this.camera.fov * Math.PI) / 360);
    const way = this.camera.position.clone().sub(this.orbit.target).setLength((0.9 * radius) / narrowest);
    this.orbit.target.copy(middle);
    this.camera.position.copy(middle).add(way);
    this.orbit.update();
    this.tellScale();
  }

  private tellScale(): void {
    const { clientHeight: height } = this.canvas;
    if (height > 0) this.scaled((2 * this.camera.position.distanceTo(this.orbit.target) * Math.tan((this.camera.fov * Math.PI) / 360)) / height);
    this.redraw();
  }

  redraw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.renderer.render(this.world, this.camera);
      this.outside(this.isOutside());
      this.probed(this.probe());
    });
  }

  /** The middle of what was drawn as the object, to a tenth of a millimetre. */
  get middleOfObject(): Point {
    return this.middleOfAll.toArray().map((each) => Math.round(10 * each) / 10 || 0) as Point;
  }

  private isOutside(): boolean {
    if (!this.object.visible || this.boxOfObject.isEmpty()) return false;
    const seen = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    return !new Frustum().setFromProjectionMatrix(seen).intersectsBox(this.boxOfObject);
  }

  /** What is shown, without handles, as PNG. */
  async picture(): Promise<Blob> {
    const handles = this.gizmo.getHelper();
    const { visible } = handles;
    handles.visible = false;
    this.renderer.render(this.world, this.camera);
    const made = new Promise<Blob>((done, failed) => this.canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error("The browser made no picture of the view.")))));
    handles.visible = visible;
    this.redraw();
    return await made;
  }

  /** A place of the page as the camera counts: from -1 to 1. */
  private onCanvas(clientX: number, clientY: number): Vector2 {
    const box = this.canvas.getBoundingClientRect();
    return new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
  }

  private tellObject(done: boolean): void {
    const { x, y, z } = this.pivot.rotation;
    this.objectMoved(this.pivot.position.toArray(), [x, y, z].map((each) => (each * 180) / Math.PI) as Point, done);
  }

  /** What is under the pointer on the plane: between the slice's points by their four neighbours. */
  private probe(): { at: Point; square: number } | undefined {
    const { slice, pointer } = this;
    if (!slice || !pointer || !this.sheet.visible) return undefined;
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.camera);
    const hit = ray.intersectObject(this.sheet)[0];
    if (!hit?.uv) return undefined;
    const { width, height, values } = slice;
    const [x, y] = [hit.uv.x * (width - 1), hit.uv.y * (height - 1)];
    const [i, j] = [Math.min(width - 2, Math.floor(x)), Math.min(height - 2, Math.floor(y))];
    const row = (at: number): number => {
      const [left, right] = [values[at * width + i] ?? 0, values[at * width + i + 1] ?? 0];
      return left + (right - left) * (x - i);
    };
    return { at: hit.point.toArray(), square: row(j) + (row(j + 1) - row(j)) * (y - j) };
  }

  private clear(group: Group): void {
    for (const part of group.children as (Object3D & { geometry: BufferGeometry; material: Material })[]) {
      part.geometry.dispose();
      part.material.dispose();
    }
    group.clear();
  }

  private fit(host: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = host;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.tellScale();
    this.renderer.render(this.world, this.camera); // at once: a new size clears the canvas
  }
}
