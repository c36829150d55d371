// A mount in 3D: turned by pointer, keys or buttons, its parts pulled apart.  It moves only when it is asked to.
// Without WebGL the page keeps what it shows without a script: the exploded drawing.
const TURN = 0.15, NEARER = 0.85, FIELD_DEG = 35;
const KEYS = {
  ArrowLeft: (view) => view.turn(-TURN, 0), ArrowRight: (view) => view.turn(TURN, 0),
  ArrowUp: (view) => view.turn(0, -TURN), ArrowDown: (view) => view.turn(0, TURN),
  "+": (view) => view.nearer(NEARER), "-": (view) => view.nearer(1 / NEARER), Home: (view) => view.begin(),
};

/** One view: `root` bears the model's address, and holds a canvas, buttons, a slider, a list and a line of words. */
class MountView {
  constructor(root, three, scene) {
    this.three = three;
    this.canvas = root.querySelector("canvas");
    this.renderer = new three.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.scene = new three.Scene();
    const sun = new three.DirectionalLight(0xffffff, 1.8);
    sun.position.set(1, 2, 3);
    this.scene.add(scene, sun, new three.AmbientLight(0xffffff, 0.9));
    this.parts = [];
    scene.traverse((one) => { if (one.isMesh) this.parts.push(one); });
    this.camera = new three.PerspectiveCamera(FIELD_DEG, 1, 0.001, 100);
    this.controls = new three.OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enablePan: false, enableZoom: false });
    this.measure();
    this.begin();
    this.listen(root);
  }

  /** The thinnest side of the whole is the way in which parts lie on each other; each has its rank along it. */
  measure() {
    const { Box3, Vector3 } = this.three;
    const size = new Box3().setFromObject(this.scene).getSize(new Vector3()).toArray();
    this.along = size.indexOf(Math.min(...size));
    this.step = 0.35 * Math.max(...size);
    const middles = this.parts.map((one) => new Box3().setFromObject(one).getCenter(new Vector3()).getComponent(this.along));
    const ranks = [...new Set(middles.map((middle) => middle.toFixed(4)))].sort((a, b) => a - b);
    this.ranks = middles.map((middle) => ranks.indexOf(middle.toFixed(4)) - (ranks.length - 1) / 2);
    this.places = this.parts.map((one) => one.position.getComponent(this.along));
  }

  /** Show it as at first: at an angle. */
  begin() {
    this.fit(new this.three.Vector3(0.4, 0.45, 0.8));
  }

  /** Show the whole as large as it fits, seen from a direction. */
  fit(from) {
    const { Box3, Vector3 } = this.three, box = new Box3().setFromObject(this.scene);
    const middle = box.getCenter(new Vector3()), radius = box.getSize(new Vector3()).length() / 2;
    const narrow = Math.min(this.canvas.clientWidth / this.canvas.clientHeight, 1) || 1;
    const away = radius / Math.sin((FIELD_DEG * Math.PI) / 360) / narrow;
    Object.assign(this.controls, { minDistance: radius / 4, maxDistance: 4 * away });
    this.controls.target.copy(middle);
    this.camera.position.copy(from).normalize().multiplyScalar(away).add(middle);
    this.camera.near = radius / 100;
    this.camera.far = 10 * away;
    this.controls.update();
    this.show();
  }

  turn(sideways, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new this.three.Spherical().setFromVector3(offset);
    place.theta -= sideways;
    place.phi -= down;
    this.camera.position.setFromSpherical(place.makeSafe()).add(this.controls.target);
    this.controls.update();
    this.show();
  }

  nearer(share) {
    this.camera.position.sub(this.controls.target).multiplyScalar(share).add(this.controls.target);
    this.controls.update();
    this.show();
  }

  /** Pull the parts apart; share: 0 as built, 1 at most. */
  apart(share) {
    this.parts.forEach((one, number) => {
      const place = this.places[number] + (share * this.ranks[number] * this.step) / one.parent.getWorldScale(new this.three.Vector3()).x;
      one.position.setComponent(this.along, place);
    });
    this.fit(this.camera.position.clone().sub(this.controls.target));
  }

  listen(root) {
    this.controls.addEventListener("change", () => this.show());
    // The wheel moves the page, until the view is chosen.
    this.canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    this.canvas.addEventListener("pointerdown", () => this.canvas.focus());
    this.canvas.addEventListener("keydown", (event) => {
      const act = KEYS[event.key === "=" ? "+" : event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act(this);
    });
    for (const button of root.querySelectorAll("button")) button.addEventListener("click", () => KEYS[button.value](this));
    root.querySelector("input[type=range]").addEventListener("input", (event) => this.apart(Number(event.target.value)));
    new ResizeObserver(() => this.show()).observe(this.canvas);
  }

  /** Draw at the next screen refresh, once for any number of events. */
  show() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const { clientWidth: wide, clientHeight: high } = this.canvas;
      if (!wide || !high) return;
      this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      this.renderer.setSize(wide, high, false);
      this.camera.aspect = wide / high;
      this.camera.updateProjectionMatrix();
      this.renderer.render(this.scene, this.camera);
    });
  }
}

/** The names of parts as words, with their colours as the model has them. */
function list(root, parts) {
  const row = root.querySelector("template").content;
  root.querySelector("ul").replaceChildren(...parts.map((part) => {
    const item = row.cloneNode(true);
    item.querySelector("rect").setAttribute("fill", `#${part.material.color.getHexString()}`);
    item.querySelector("span").textContent = part.name.replaceAll(/[-_]+/g, " ");
    return item;
  }));
}

async function begin(root) {
  const said = root.querySelector("[data-status]"), stage = root.querySelector("[data-stage]");
  try {
    if (!document.createElement("canvas").getContext("webgl2")) throw new Error("no WebGL");
    said.textContent = "Loading the parts …";
    const three = await import("./three.js");
    // The page's policy lets pictures come from the model itself, but only as pictures: its scripts fetch nothing else.
    const loader = new three.GLTFLoader().register((parser) => {
      parser.textureLoader = new three.TextureLoader(new three.LoadingManager());
      return { name: "pictures" };
    });
    const model = await loader.loadAsync(root.dataset.model);
    stage.hidden = false;
    const view = new MountView(root, three, model.scene);
    list(root, view.parts);
    said.textContent = `${view.parts.length} parts are shown.`;
  } catch {
    stage.hidden = true;
    said.textContent = "This browser shows no 3D here. The exploded drawing shows the same parts.";
  }
}

for (const root of document.querySelectorAll("[data-model]")) begin(root);
