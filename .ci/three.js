// What static/mount-view.js uses of three: `make three` bundles it as static/three.js.
export {
  AmbientLight,
  Box3,
  DirectionalLight,
  LoadingManager,
  PerspectiveCamera,
  Scene,
  Spherical,
  TextureLoader,
  Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
