// Renderer, camera and light. Axes of the view: x east, y up, z south.
import {
  AmbientLight,
  Color,
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
} from 'three'

export function createStage() {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true })
  renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1))
  renderer.setClearColor(new Color(0xffffff), 0)
  const camera = new PerspectiveCamera(32, 1, 0.01, 100)
  const scene = new Scene()
  const sun = new DirectionalLight(0xffffff, 2.1)
  sun.position.set(-1.2, 2.2, 1.1)
  const fill = new DirectionalLight(0xdfe8f2, 0.7)
  fill.position.set(1.6, 0.8, -0.9)
  scene.add(sun, fill, new HemisphereLight(0xf4f6f8, 0x9a9488, 0.85), new AmbientLight(0xffffff, 0.25))

  let last = null
  return {
    camera,
    canvas: renderer.domElement,
    triangles: () => renderer.info.render.triangles,
    render(model, width, height) {
      if (last !== model) {
        if (last) scene.remove(last.group)
        scene.add(model.group)
        last = model
      }
      renderer.setSize(width, height, false)
      camera.aspect = width / height
      camera.updateProjectionMatrix()
      renderer.render(scene, camera)
    },
  }
}
